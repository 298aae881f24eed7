// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"
#include "tools/options.h"

namespace thermotwin::tools {

void add_export(CLI::App& app) {
  const auto options = std::make_shared<ExportOptions>();
  ExportOptions& exported = *options;
  CLI::App* verb =
      add_verb(app, "export", "Exports a machine to other programs, as a CalculiX deck or as Matrix Market files.",
               "thermotwin export cases/vmc5 --calculix --load spindle_6000 --pose X=0,Y=0,Z=275\n"
               "  cd out/calculix && ccx heat && ccx static\n"
               "  thermotwin export cases/vmc5 --matrices && thermotwin reduce --matrices out/matrices --out reduced",
               options, &tools::export_model);
  verb->add_option("MODEL", exported.model, "Case folder, case.toml or machine.toml.")->required();
  verb->add_flag("--calculix", exported.calculix,
                 "Write decks for CalculiX (ccx 2.20) in SI units and degC: heat.inp, static.inp and mesh.inp.");
  auto* matrices = verb->add_flag(
      "--matrices", exported.matrices,
      "Write the matrices E, A, B, C, one for each film, contact and flow, and names.toml, for `reduce --matrices`.");
  auto* load =
      verb->add_option("--load", exported.load,
                       "Load program of the deck, as amplitudes (default: steady state of the machine at rest).");
  auto* step = verb->add_option("--time-step", exported.time_step_s,
                                "Longest time increment of the deck, s (default: time_step_s of the load).")
                   ->check(CLI::PositiveNumber)
                   ->needs(load);
  verb->add_option("--steady-at", exported.steady_at_s,
                   "Time of the load, s, whose steady state replaces the transient.")
      ->check(CLI::NonNegativeNumber)
      ->needs(load)
      ->excludes(step);
  verb->add_option(
      "--pose", exported.pose,
      "Axis positions, mm and deg, at which bodies are placed and TCP errors are evaluated (default: home).");
  auto* body = verb->add_option("--body", exported.body,
                                "The only body of the deck, without its joints to others (default: all bodies).");
  auto* heat_only = verb->add_flag("--heat-only", exported.heat_only, "Write no static.inp.");
  for (CLI::Option* of_calculix : {load, body, heat_only}) matrices->excludes(of_calculix);
  add_mesh_options(*verb, exported.size, exported.mesh_order);
}

}  // namespace thermotwin::tools
