// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"
#include "tools/options.h"

namespace thermotwin::tools {

void add_simulate(CLI::App& app) {
  const auto options = std::make_shared<SimulateOptions>();
  SimulateOptions& simulate = *options;
  CLI::App* verb =
      add_verb(app, "simulate", "one load on the full model: fields.pvd, sensors.csv, tcp.csv, heat.csv",
               "thermotwin simulate cases/vmc5 --load spindle_6000 --pose X=0,Y=0,Z=275", options, &tools::simulate);
  verb->add_option("CASE", simulate.case_path, "case folder or case.toml")->required();
  verb->add_option("--load", simulate.load, "load program (name of a file in loads/)")->required();
  verb->add_option("--pose", simulate.pose, "axis positions, mm and deg: X=0,Y=0,Z=275,B=45 (absent: home)");
  verb->add_option("--fields-every", simulate.fields_every_s, "seconds between fields in fields.pvd")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  verb->add_option("--output-times", simulate.output_times,
                   "results at these times only, s: 0,600,3600; the run ends with the last")
      ->delimiter(',')
      ->check(CLI::NonNegativeNumber);
  auto* from = verb->add_option("--start-from", simulate.start_from,
                                "start with the temperatures of a fields .vtu, of any mesh of the machine");
  auto* sensors =
      verb->add_option("--start-from-sensors", simulate.start_from_sensors,
                       "start with the smoothest field that agrees with a table of <sensor>_C (sensors.csv)");
  from->excludes(sensors);
  verb->add_option("--start-time", simulate.start_time_s, "time in that table, s (absent: its first row)")
      ->needs(sensors)
      ->check(CLI::NonNegativeNumber);
  verb->add_flag("--resume", simulate.resume, "go on from the checkpoint of a stopped run with the same inputs");
  add_checkpoint_option(*verb, simulate.checkpoint_every_s);
  add_mesh_options(*verb, simulate.size, simulate.mesh_order);
  add_solver_option(*verb, simulate.solver);
}

}  // namespace thermotwin::tools
