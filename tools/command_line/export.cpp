// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"
#include "tools/export_control.h"

namespace thermotwin::tools {

namespace {

void add_control_options(CLI::App& verb, ControlExportOptions& exported, CLI::Option& matrices) {
  auto* source =
      verb.add_option("--c", exported.c_folder,
                      "Folder for the model as C99 source without allocation; its offsets equal those of `compensate` "
                      "bit for bit.");
  auto* fmu = verb.add_option("--fmu", exported.fmu,
                              "Version of FMI (2 or 3): write the model as FMU for co-simulation to --out FILE.fmu.")
                  ->check(CLI::IsMember({2, 3}));
  auto* linuxcnc = verb.add_option("--linuxcnc", exported.linuxcnc,
                                   "INI file of a LinuxCNC configuration: write model, pins, guard and the pieces of "
                                   "HAL and INI for it to the folder --out.");
  matrices.excludes(source)->excludes(fmu)->excludes(linuxcnc);
  source->excludes(fmu)->excludes(linuxcnc);
  fmu->excludes(linuxcnc);
  const auto add = [&](const char* name, double& value, const char* text) {
    return verb.add_option(name, value, text);
  };
  verb.add_option("--order", exported.order,
                  "With --c, --fmu, --linuxcnc: number of states of the model that are kept, from the first on "
                  "(default: all).")
      ->check(positive_number());
  add("--step", exported.step_s, "With --c, --fmu, --linuxcnc: longest step of the thermal state, s (default 60).");
  add("--start-C", exported.start_C,
      "With --c, --fmu, --linuxcnc: initial temperature of the machine, degC (default 20).")
      ->check(start_temperature());
  add("--largest-offset", exported.largest_um,
      "With --c, --fmu, --linuxcnc: limit of each offset, um (default: by the model).");
  add("--offset-rate", exported.rate_um_s,
      "With --c, --fmu, --linuxcnc: limit of each offset's rate of change, um/s (default: by the model).");
  add("--low-rank", exported.tolerance,
      "With --c, --fmu, --linuxcnc: eigenvalues of a term below this share of its largest are left out (default "
      "1e-7).");
  add("--start-over", exported.start_over_s,
      "With --c, --fmu, --linuxcnc: machine time that the work of the first row is spread over, s (default 0: done in "
      "that row).");
  verb.add_option_function<std::string>(
          "--observer", [&exported](const std::string& value) { exported.observer = value == "on"; },
          "With --c, --fmu, --linuxcnc: on: temperature sensors correct the model and offsets have standard "
          "deviations; off: open "
          "loop (default on).")
      ->check(CLI::IsMember({"on", "off"}));
}

}  // namespace

void add_export(CLI::App& app) {
  const auto options = std::make_shared<ControlExportOptions>();
  ControlExportOptions& exported = *options;
  CLI::App* verb = add_verb(
      app, "export",
      "Exports a machine as a CalculiX deck or as Matrix Market files, or a reduced model as C source, as FMU or "
      "for LinuxCNC.",
      "thermotwin export cases/vmc5 --calculix --load spindle_6000 --pose X=0,Y=0,Z=275\n"
      "  cd out/calculix && ccx heat && ccx static\n"
      "  thermotwin export cases/vmc5 --matrices && thermotwin reduce --matrices out/matrices --out reduced\n"
      "  thermotwin export out/model.rom.h5 --c out/twin\n"
      "  thermotwin export out/model.rom.h5 --fmu 2 --out out/twin.fmu\n"
      "  thermotwin export out/model.rom.h5 --linuxcnc ~/linuxcnc/configs/mill/mill.ini --out out/linuxcnc",
      options, &tools::export_any);
  verb->add_option("MODEL", exported.model,
                   "Case folder, case.toml or machine.toml; with --c, --fmu, --linuxcnc: model.rom.h5.")
      ->required();
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
                   ->check(positive_number())
                   ->needs(load);
  verb->add_option("--steady-at", exported.steady_at_s,
                   "Time of the load, s, whose steady state replaces the transient.")
      ->check(non_negative_number())
      ->needs(load)
      ->excludes(step);
  verb->add_option(
      "--pose", exported.pose,
      "Axis positions, mm and deg, at which bodies are placed and TCP errors are evaluated (default: home).");
  auto* body = verb->add_option("--body", exported.body,
                                "The only body of the deck, without its joints to others (default: all bodies).");
  auto* heat_only = verb->add_flag("--heat-only", exported.heat_only, "Write no static.inp.");
  for (CLI::Option* of_calculix : {load, body, heat_only}) matrices->excludes(of_calculix);
  add_mesh_options(*verb, exported.size, exported.mesh_order, "--mesh-order");
  add_control_options(*verb, exported, *matrices);
}

}  // namespace thermotwin::tools
