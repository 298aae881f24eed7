// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"
#include "tools/options.h"

namespace thermotwin::tools {

void add_simulate(CLI::App& app) {
  const auto options = std::make_shared<SimulateOptions>();
  SimulateOptions& simulate = *options;
  CLI::App* verb =
      add_verb(app, "simulate",
               "Runs one load program on the full model and writes fields.pvd, sensors.csv, tcp.csv and heat.csv.",
               "thermotwin simulate cases/vmc5 --load spindle_6000 --pose X=0,Y=0,Z=275", options, &tools::simulate);
  verb->add_option("CASE", simulate.case_path, "Case folder or case.toml.")->required();
  verb->add_option("--load", simulate.load, "Load program: the name of a file in loads/.")->required();
  verb->add_option("--pose", simulate.pose, "Axis positions, mm and deg, e.g. X=0,Y=0,Z=275,B=45 (default: home).");
  auto* steady = verb->add_flag(
      "--steady", simulate.steady,
      "Compute the steady state of each phase by one solution instead of the run, with one row and one field for each "
      "phase.");
  auto* every = verb->add_option("--fields-every", simulate.fields_every_s,
                                 "Interval between the temperature fields of fields.pvd, s.")
                    ->check(positive_number())
                    ->capture_default_str();
  auto* times =
      verb->add_option(
              "--output-times", simulate.output_times,
              "Times of the results, s, e.g. 0,600,3600; the run ends at the last one (default: every output_s of "
              "the load).")
          ->delimiter(',')
          ->check(non_negative_number());
  auto* from = verb->add_option(
      "--start-from", simulate.start_from,
      "Initial temperatures from a .vtu of fields.pvd, on any mesh of the machine (default: initial_C of the load).");
  auto* sensors = verb->add_option(
      "--start-from-sensors", simulate.start_from_sensors,
      "Initial temperatures as the smoothest field that agrees with the columns <sensor>_C of a table, such as "
      "sensors.csv.");
  from->excludes(sensors);
  verb->add_option("--start-time", simulate.start_time_s, "Time in that table, s (default: its first row).")
      ->needs(sensors)
      ->check(non_negative_number());
  auto* resume = verb->add_flag("--resume", simulate.resume,
                                "Continue from the checkpoint of an interrupted run with the same inputs.");
  for (CLI::Option* of_run : {every, times, from, sensors, resume}) steady->excludes(of_run);
  add_checkpoint_option(*verb, simulate.checkpoint_every_s);
  add_mesh_options(*verb, simulate.size, simulate.mesh_order);
  add_solver_option(*verb, simulate.solver);
}

}  // namespace thermotwin::tools
