// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"
#include "tools/options.h"

namespace thermotwin::tools {

void add_compensate(CLI::App& app) {
  const auto options = std::make_shared<CompensateOptions>();
  CompensateOptions& compensate = *options;
  CLI::App* verb =
      add_verb(app, "compensate", "streams rows of what a control knows in, axis offsets out, row by row",
               "thermotwin compensate out/model.rom.h5 --in rows.csv --out offsets.csv", options, &tools::compensate);
  verb->add_option("MODEL", compensate.model, "model.rom.h5")->required();
  verb->add_option("--in", compensate.in, "CSV file, or - for standard input")->capture_default_str();
  verb->get_option("--out")->description("CSV file of the offsets, or - for standard output");
  verb->add_flag("--no-sensors", compensate.no_sensors, "ignore temperature sensors");
  verb->add_option("--step", compensate.step_s, "longest step of the thermal state, s")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();

  verb->add_option("--largest-offset", compensate.largest_um,
                   "um; no offset is larger (absent: twice what the model's operating points make)")
      ->check(CLI::PositiveNumber);
  verb->add_option("--offset-rate", compensate.rate_um_s,
                   "um/s; no offset changes faster, from nought at the start (absent: the largest in 300 s, and what "
                   "moves of the axes account for)")
      ->check(CLI::PositiveNumber);

  verb->add_flag("--strict", compensate.strict,
                 "a cell that cannot be read, or a value that the machine cannot have, ends the run (absent: it counts "
                 "as missing, and the status says so)");

  verb->add_option("--probe-std", compensate.probe_std_um,
                   "um, standard deviation of the values in columns probe_dx_um, probe_dy_um, probe_dz_um")
      ->check(CLI::Range(0.001, 1e5))
      ->capture_default_str();
  verb->add_flag("--probed-compensated", compensate.probed_compensated,
                 "they were probed while the offsets of the row before were applied");
  verb->add_option(
      "--learned", compensate.learned,
      "CSV file: what sensors and probing told of powers, films, expansions, ..., with its uncertainty, at the end");
  verb->add_option("--explain", compensate.explain,
                   "text file: which augmented states the sensors can tell (detectability), by name, at the end");
}

}  // namespace thermotwin::tools
