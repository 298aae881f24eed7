// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/nc/run_report.h"

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "core/html_page.h"
#include "core/quoted.h"

namespace thermotwin::tools {

namespace {

/// Options that the program is read with, as they were given, but for those of the machine's temperatures.
std::string reading_words(const NcOptions& options) {
  std::string words;
  if (options.control != NcOptions().control) words += " --control " + core::shell_word(options.control);
  for (const auto& [option, file] :
       {std::pair{"--tools", &options.tools}, {"--folder", &options.folder}, {"--process", &options.process}}) {
    if (!file->empty()) words += fmt::format(" {} {}", option, core::shell_word(*file));
  }
  if (!options.start.empty()) words += " --start " + core::shell_word(options.start);
  if (options.start_C != NcOptions().start_C) words += fmt::format(" --start-C {:g}", options.start_C);
  return words;
}

/// Options for the temperatures before the program, as they were given.
std::string present_words(const NcOptions& options) {
  if (options.state.empty()) return options.rested ? " --rested" : "";
  std::string words = " --state " + core::shell_word(options.state);
  if (options.after_s) words += fmt::format(" --after {:g}", *options.after_s);
  return words;
}

std::vector<core::NextStep> next_steps(const NcOptions& options) {
  const std::string model = core::shell_word(options.model),
                    read = core::shell_word(options.program) + reading_words(options),
                    program = read + present_words(options), out = core::shell_word(options.out);
  std::vector<core::NextStep> steps;
  if (options.rewrite.empty())
    steps.push_back({"The program with corrected coordinates:",
                     fmt::format("thermotwin nc {} {} --rewrite path --out {}", model, program, out)});
  if (options.state.empty())
    steps.push_back({"From the present temperatures, if `compensate --state machine.state` runs beside the control:",
                     fmt::format("thermotwin nc {} {} --state machine.state --out {}", model, read, out)});
  if (options.repeat == 1)
    steps.push_back({"A series of parts, and how long to warm up before the first good one:",
                     fmt::format("thermotwin nc {} {} --repeat 20 --pause 60 --out {}", model, program, out)});
  steps.push_back({"The offsets of a control on the same rows:",
                   fmt::format("thermotwin compensate {} --in {}/rows.csv --out offsets.csv", model, out)});
  return steps;
}

}  // namespace

nc::Report report_of(const Outcome& found) {
  nc::Report report;
  report.program = found.options.program.filename().string();
  report.machine = fmt::format("machine {}, order {}", found.twin.machine.name, found.twin.model->system.order());
  report.begins =
      found.options.state.empty()
          ? fmt::format("the machine begins at a uniform temperature of {} °C{}", found.options.start_C,
                        found.options.rested ? ", rested" : "")
          : fmt::format("begins {} s after the saved state {}", found.options.after_s.value_or(found.options.row_s),
                        found.options.state.filename().string());
  report.axes = found.axes;
  report.duration_s = found.duration_s;
  report.cutting_s = found.cutting_s;
  report.rapid_s = found.rapid_s;
  report.pause_s = found.pause_s;
  report.moves = found.program.moves;
  report.lines = found.program.blocks;
  report.parts = found.options.repeat;
  report.tolerance_um = found.options.tolerance_um;
  if (found.options.repeat > 1 && found.predicted > 0) {
    report.first_good_part = found.parts.first_good(found.options.tolerance_um);
    report.warm_up_s = report.first_good_part > 0 ? found.parts.start_of(report.first_good_part) : 0.0;
    report.drift_ahead_um = found.parts.drift_ahead();
  }
  report.rewritten = found.uncorrected.sentence("µm");
  if (found.corrected) {
    report.rewritten = fmt::format("{} is the corrected program.{}{}", found.corrected->name(),
                                   report.rewritten.empty() ? "" : " ", report.rewritten);
  }
  report.locations = nc::location_section(*found.locations);
  if (found.imprint) report.imprint = nc::imprint_section(*found.imprint, 300);
  report.next = next_steps(found.options);
  return report;
}

}  // namespace thermotwin::tools
