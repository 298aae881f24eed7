// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"
#include "tools/options.h"

namespace thermotwin::tools {

void add_compensate(CLI::App& app) {
  const auto options = std::make_shared<CompensateOptions>();
  CompensateOptions& compensate = *options;
  CLI::App* verb =
      add_verb(app, "compensate", "Streams rows of a control's channels in and axis offsets out, row by row.",
               "thermotwin compensate out/model.rom.h5 --in rows.csv --out offsets.csv", options, &tools::compensate);
  verb->add_option("MODEL", compensate.model, "Reduced model model.rom.h5.")->required();
  verb->add_option(
          "--in", compensate.in,
          "CSV file of rows, or - for standard input. A blank cell or nan is a missing value: the last value of the "
          "channel holds, and after 300 s the status is input_missing. inf is unreadable.")
      ->capture_default_str();
  verb->get_option("--out")->description("CSV file of offsets, or - for standard output.")->group("Options");
  verb->add_flag("--no-sensors", compensate.no_sensors, "Ignore the temperature sensors.");
  verb->add_option("--step", compensate.step_s, "Longest step of the thermal state, s.")
      ->check(positive_number())
      ->capture_default_str();
  verb->add_option("--start-C", compensate.start_C,
                   "Uniform temperature of the machine at the start, degC; with sensors it is estimated from their "
                   "first readings.")
      ->check(start_temperature())
      ->capture_default_str();
  verb->add_option("--largest-offset", compensate.largest_um,
                   "Limit of each offset, um (default: twice the largest offset at the model's operating points).")
      ->check(positive_number());
  verb->add_option("--offset-rate", compensate.rate_um_s,
                   "Limit of each offset's rate of change, um/s, from 0 at the start (default: the largest offset in "
                   "300 s, plus axis moves).")
      ->check(positive_number());

  verb->add_flag(
      "--strict", compensate.strict,
      "Stop at a cell that is unreadable or that the machine cannot have (default: it counts as missing, and "
      "the status names it).");

  verb->add_option("--probe-std", compensate.probe_std_um,
                   "Standard deviation of the values in the columns probe_dx_um, probe_dy_um and probe_dz_um, um.")
      ->check(CLI::Range(0.001, 1e5))
      ->capture_default_str();
  verb->add_flag("--probed-compensated", compensate.probed_compensated,
                 "The values were probed with compensation active, that is, with the offsets of the row before.");
  verb->add_option("--learned", compensate.learned,
                   "CSV file, written at the end, of the estimated powers, films, expansions and other states with "
                   "standard deviations.");
  auto* lines =
      verb->add_option("--lines", compensate.lines,
                       "CSV file of a straight line for each axis (reference position, offset, slope) for controls "
                       "that take one, with the largest residual, um.");
  verb->add_option("--lines-every", compensate.lines_every_s,
                   "Machine time between two versions of the file of --lines with --out -, s.")
      ->check(non_negative_number())
      ->capture_default_str()
      ->needs(lines);
  verb->add_option("--axis-errors", compensate.axis_errors,
                   "Folder, written at the end, of a table of component errors (ISO 230-1) along each linear axis.");
  verb->add_option("--state", compensate.state,
                   "File of the whole state: read at the start where it exists, written at least once a minute of the "
                   "rows' time and at the end. A pause of more than 300 s is computed as a machine that is off.");
  verb->add_flag("--json-lines", compensate.json_lines,
                 "Write a line of JSON a row instead of CSV: offsets, status, guard and failed sensors. Once a second "
                 "of the rows' time it also has the sensors with their predictions, and the errors over the "
                 "workspace.");
  verb->add_option("--order", compensate.order,
                   "Number of states of the model that are kept, from the first on (default: all).")
      ->check(positive_number());
  verb->add_option("--explain", compensate.explain,
                   "Text file, written at the end, of the disturbance states and their detectability by the sensors.");
}

}  // namespace thermotwin::tools
