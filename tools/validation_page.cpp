// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/validation_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "compensation/evaluation/validation_plots.h"
#include "core/html_page.h"
#include "core/quoted.h"
#include "core/text.h"
#include "tools/page.h"
#include "tools/shell_command.h"

namespace thermotwin::tools {
namespace {

using compensation::DotColumn;
using compensation::quantile;

std::string page_of(const ValidationHead& head, const std::string& subject, const std::string& body) {
  const std::string title = subject + " of " + head.machine;
  return core::html_document(
      title, core::html_title(title, fmt::format("machines measured virtually: {}; {} parameters perturbed", head.truth,
                                                 head.perturbed)) +
                 body);
}

std::string dots_section(const std::string& heading, const std::string& svg) {
  return core::html_section(heading,
                            "a dot a machine; the stroke is the median, its number on top, the bar reaches from the "
                            "10th to the 90th percentile",
                            svg);
}

std::string tables(const compensation::Rows& rows, const compensation::Rows* full, const std::string& legend = "") {
  std::string markup = core::html_section("In numbers", legend, core::html_table(rows));
  if (full != nullptr) markup += core::html_section("The same on full models", "", core::html_table(*full));
  return markup;
}

std::string model_words(const ValidateOptions& options) {
  return options.model.empty() ? core::shell_word(options.out / "model.rom.h5") : core::shell_word(options.model);
}

/// What makes the measured machines, as it was given.
std::string machine_words(const ValidateOptions& options) {
  const ValidateOptions usual;
  return ShellCommand("")
      .texts("--load", options.loads)
      .text("--perturb", options.perturb == usual.perturb ? "" : options.perturb)
      .number("--measured-size", options.size_factor, usual.size_factor)
      .flag("--coolant", options.coolant_rise)
      .flag("--no-noise", options.no_noise)
      .text("--truth", options.reference)
      .words();
}

struct Study {
  const char *why, *flags;
};

std::string next_steps(const ValidateOptions& options, const std::vector<Study>& studies) {
  std::vector<core::NextStep> steps;
  for (const auto& [why, flags] : studies) {
    steps.push_back(
        {why, fmt::format("thermotwin validate {} --model {}{} {} --out {}", core::shell_word(options.case_path),
                          model_words(options), machine_words(options), flags, core::shell_word(options.out))});
  }
  steps.push_back({"Beside a control, row by row:",
                   fmt::format("thermotwin compensate {} --in rows.csv --out offsets.csv", model_words(options))});
  return core::html_next_steps(steps);
}

constexpr Study more_machines{"More machines make percentiles firm:", "--draws 20"},
    power_off{"The return from a power-off, when the thermal state is unknown:", "--power-off --draws 20"},
    failures{"What each failed temperature sensor costs:", "--failed-sensors --draws 3"};

}  // namespace

std::string validation_page(const ValidationHead& head, const compensation::Validation& main,
                            const compensation::Validation* full) {
  using compensation::ValidationRow;
  using compensation::With;
  std::vector<std::string> loads, tiles, sentences;
  for (const compensation::ValidationRow& row : main.rows)
    if (std::find(loads.begin(), loads.end(), row.load) == loads.end()) loads.push_back(row.load);
  double least = 100.0;
  for (const std::string& load : loads) {
    const std::vector<double> removed = main.reductions(load, With::sensors);
    const double median = quantile(removed, 0.5);
    least = std::min(least, median);
    sentences.push_back(fmt::format(
        "With sensors, compensation removes {:.1f}&#8239;% of the RMS of the TCP error in {} (median of {} machine{}; "
        "10th percentile {:.1f}&#8239;%): {:.1f} µm become {:.1f} µm.",
        median, core::xml_text(load), removed.size(), removed.size() == 1 ? "" : "s", quantile(removed, 0.1),
        main.rms(load, &ValidationRow::rms_before_um), main.rms(load, &ValidationRow::rms_sensors_um)));
    if (const std::string stays = main.unmoved_sentence(load, "µm"); !stays.empty()) sentences.push_back(stays);
    tiles.push_back(core::html_tile(core::xml_text(load) + ", sensors", fmt::format("{:.1f}&#8239;%", median),
                                    "median RMS removed"));
    tiles.push_back(core::html_tile(core::xml_text(load) + ", no sensors",
                                    fmt::format("{:.1f}&#8239;%", quantile(main.reductions(load, With::model), 0.5)),
                                    "median RMS removed"));
  }
  const compensation::Rows rows = main.table(), of_full = full != nullptr ? full->table() : compensation::Rows{};
  return page_of(
      head, "Validation",
      core::html_finding(least > 50.0 ? core::Tone::good : core::Tone::warn, "compensation", sentences) +
          core::html_tiles(tiles) + dots_section("RMS removed on each machine", compensation::removal_svg(main)) +
          traces_section(main.traces) +
          tables(rows, full != nullptr ? &of_full : nullptr,
                 "Columns without % are RMS in µm. Surroundings known: without sensors, with every ambient at the "
                 "hall temperature. Cut by sensors: share of that residual which the sensors remove" +
                     std::string(main.unmoved_directions.empty() ? "." : ", in the directions that axes move.")) +
          next_steps(head.options, {more_machines, power_off}));
}

std::string validation_page(const ValidationHead& head, const compensation::PowerOffStudy& main,
                            const compensation::PowerOffStudy* full) {
  constexpr const char* moments[] = {"after 5 min", "after 30 min", "after 2 h"};
  std::vector<DotColumn> columns;
  std::vector<std::string> tiles;
  for (int k = 0; k < 3; ++k) {
    columns.push_back({"time since the return", moments[k], main.left_percent(k), core::Ink::blue});
    tiles.push_back(core::html_tile(
        std::string("residual, ") + moments[k], fmt::format("{:.1f}&#8239;%", quantile(main.left_percent(k), 0.5)),
        fmt::format("median; 90th percentile {:.1f}&#8239;%", quantile(main.left_percent(k), 0.9))));
  }
  const compensation::Rows rows = main.table(), of_full = full != nullptr ? full->table() : compensation::Rows{};
  const double early = quantile(main.left_percent(0), 0.5), late = quantile(main.left_percent(2), 0.5);
  const std::string finding = fmt::format(
      "Of the RMS of the TCP error, {:.1f}&#8239;% is left 5 min after the return and {:.1f}&#8239;% after 2 h "
      "(medians "
      "of {} machines).",
      early, late, main.rows.size());
  std::vector<std::string> sentences{finding};
  if (const std::string stays = main.unmoved_sentence(); !stays.empty()) sentences.push_back(stays);
  return page_of(
      head, "Return from a power-off",
      core::html_finding(early < 50.0 ? core::Tone::good : core::Tone::warn, "unknown state at the return", sentences) +
          core::html_tiles(tiles) +
          dots_section("Residual after the return",
                       compensation::dots_svg("Residual after the return",
                                              "residual in % of the RMS without compensation", columns)) +
          tables(rows, full != nullptr ? &of_full : nullptr) + next_steps(head.options, {failures, more_machines}));
}

std::string validation_page(const ValidationHead& head, const compensation::RestartStudy& main,
                            const compensation::RestartStudy* full) {
  constexpr double good = 1.2;
  std::vector<std::string> sentences, tiles;
  double largest = 0.0;
  for (const std::string& load : main.loads()) {
    const double ratio = main.ratio(load);
    largest = std::max(largest, ratio);
    sentences.push_back(
        fmt::format("In {}, the RMS over the hour after the return is {:.2f} times that of a compensator that never "
                    "stopped, and {:.2f} times if the offsets could come at once.",
                    core::xml_text(load), ratio, main.ratio_at_once(load)));
    tiles.push_back(core::html_tile(core::xml_text(load), fmt::format("{:.2f}", ratio), "ratio of RMS"));
  }
  const compensation::Rows rows = main.table(), of_full = full != nullptr ? full->table() : compensation::Rows{};
  return page_of(
      head, "Restart after an hour off",
      core::html_finding(largest <= good ? core::Tone::good : core::Tone::warn, "restart from the state", sentences) +
          core::html_tiles(tiles) +
          tables(rows, full != nullptr ? &of_full : nullptr, "RMS of the TCP error over the hour after the return.") +
          next_steps(head.options, {power_off, more_machines}));
}

std::string validation_page(const ValidationHead& head, const compensation::FailedSensorStudy& main,
                            const compensation::FailedSensorStudy* full) {
  std::vector<std::string> faults;
  for (const auto& row : main.rows)
    if (std::find(faults.begin(), faults.end(), row.fault) == faults.end()) faults.push_back(row.fault);
  std::vector<DotColumn> columns;
  double costliest = 0.0;
  long named = 0, told = 0;
  for (const std::string& fault : faults) {
    DotColumn whole{fault, "all work", {}, core::Ink::blue}, failed{fault, "one failed", {}, core::Ink::orange};
    for (const auto& row : main.rows) {
      if (row.fault != fault) continue;
      whole.values.push_back(row.whole_percent);
      failed.values.push_back(row.failed_percent);
      costliest = std::max(costliest, row.cost_percent());
      told += row.told ? 1 : 0;
      named += row.told && row.named_min < 1e9 ? 1 : 0;
    }
    columns.push_back(whole);
    columns.push_back(failed);
  }
  const compensation::Rows rows = main.summary(), of_full = full != nullptr ? full->summary() : compensation::Rows{};
  const std::string finding = fmt::format(
      "A failed sensor costs at most {:.1f}&#8239;% of what compensation removes; {} of {} failures that readings can "
      "show are named.",
      costliest, named, told);
  return page_of(
      head, "Failed sensors",
      core::html_finding(costliest < 20.0 && named == told ? core::Tone::good : core::Tone::warn, "one failed sensor",
                         {finding}) +
          core::html_tiles({core::html_tile("failures named", fmt::format("{} of {}", named, told),
                                            "of those that readings can show"),
                            core::html_tile("largest cost of a failure", fmt::format("{:.1f}&#8239;%", costliest),
                                            "of the RMS that compensation removes"),
                            core::html_tile("false alarms", std::to_string(main.false_alarms()),
                                            "in runs in which no sensor failed")}) +
          core::html_section("RMS removed after the failure",
                             "a dot a sensor, machine and program; the stroke is the median, its number on top",
                             compensation::dots_svg("RMS removed after the failure", "RMS removed in %", columns)) +
          tables(rows, full != nullptr ? &of_full : nullptr) + next_steps(head.options, {power_off, more_machines}));
}

}  // namespace thermotwin::tools
