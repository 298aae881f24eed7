// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"
#include "tools/options.h"

namespace thermotwin::tools {

void add_export(CLI::App& app) {
  const auto options = std::make_shared<ExportOptions>();
  ExportOptions& exported = *options;
  CLI::App* verb =
      add_verb(app, "export",
               "the machine for another program: a CalculiX deck (heat.inp, static.inp, mesh.inp), or its matrices "
               "(Matrix Market)",
               "thermotwin export cases/vmc5 --calculix --load spindle_6000 --pose X=0,Y=0,Z=275\n"
               "  cd out/calculix && ccx heat && ccx static\n"
               "  thermotwin export cases/vmc5 --matrices && thermotwin reduce --matrices out/matrices --out reduced",
               options, &tools::export_model);
  verb->add_option("MODEL", exported.model, "case folder, case.toml or machine.toml")->required();
  verb->add_flag("--calculix", exported.calculix,
                 "decks for ccx 2.20: heat transfer, then thermo-elastic displacement, SI units and degC");
  auto* matrices = verb->add_flag(
      "--matrices", exported.matrices,
      "E, A, a matrix for each film, contact and flow, B, C, and names.toml: what `reduce --matrices` reads");
  auto* load = verb->add_option("--load", exported.load,
                                "load program, as amplitudes (absent: steady state of the machine as it stands)");
  auto* step =
      verb->add_option("--time-step", exported.time_step_s, "longest increment, s (absent: time_step_s of the load)")
          ->check(CLI::PositiveNumber)
          ->needs(load);
  verb->add_option("--steady-at", exported.steady_at_s,
                   "steady state of what the load has at this time, s, instead of a transient")
      ->check(CLI::NonNegativeNumber)
      ->needs(load)
      ->excludes(step);
  verb->add_option(
      "--pose", exported.pose,
      "axis positions, mm and deg, where the bodies are put, and whose TCP error the matrices give (absent: home)");
  auto* body = verb->add_option("--body", exported.body, "only this body, without its joints to others");
  auto* heat_only = verb->add_flag("--heat-only", exported.heat_only, "no static.inp");
  for (CLI::Option* of_calculix : {load, body, heat_only}) matrices->excludes(of_calculix);
  add_mesh_options(*verb, exported.size, exported.mesh_order);
}

}  // namespace thermotwin::tools
