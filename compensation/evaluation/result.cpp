// SPDX-License-Identifier: GPL-3.0-or-later
// An evaluation as tables for the terminal.

#include "compensation/evaluation/result.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compensation/evaluation/evaluate.h"
#include "core/text.h"

namespace thermotwin::compensation {
namespace {

std::string number(double value, const char* format = "{:.2f}") {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "-";
}

std::vector<std::string> line_of(const EvaluationRow& row) {
  const Measures& m = row.measures;
  return {row.model,
          row.segment + (row.training ? " (seen)" : ""),
          std::to_string(m.count),
          number(m.rms_before, "{:.3f}"),
          number(m.rms, "{:.3f}"),
          number(m.rms_reduction_percent, "{:.1f}"),
          number(m.peak_to_peak_before),
          number(m.peak_to_peak),
          number(m.mean_before),
          number(m.mean),
          number(m.maximum_before),
          number(m.maximum),
          number(m.fit, "{:.1f}")};
}

}  // namespace

std::string Evaluation::brief() const {
  std::string text = fmt::format("fitted on {:.1f} h of displacements; {} inputs available\n", training_hours, inputs);
  // With all rows in training nothing but the fit is left to show.
  const bool fits =
      std::any_of(leaderboard.begin(), leaderboard.end(), [](const Standing& s) { return s.seen_by_fit; });
  std::vector<std::vector<std::string>> board = {
      {"model", "channels", "predicted %",
       fits ? "RMS removed (fit: on training rows) %" : "RMS removed on held-out data %", "mean of channels %",
       "below static_regression %"}};
  for (const Standing& standing : leaderboard) {
    board.push_back({standing.model + (standing.seen_by_fit ? " (fit)" : "") + (standing.caution.empty() ? "" : " *"),
                     std::to_string(standing.channels), number(standing.predicted_percent, "{:.0f}"),
                     number(standing.reduction_percent, "{:.1f}"), number(standing.channel_mean_percent, "{:.1f}"),
                     number(standing.against_static_percent, "{:.1f}")});
  }
  text += core::format_table(board);
  for (const Standing& standing : leaderboard) {
    if (!standing.caution.empty()) text += fmt::format("* {} ranked last: {}\n", standing.model, standing.caution);
  }
  for (const std::string& line : notes) text += "  " + line + "\n";
  return text;
}

std::vector<std::vector<std::string>> Evaluation::table(const std::string& channel) const {
  std::vector<std::vector<std::string>> table = {{"model", "part", "rows", "RMS before", "after", "removed %",
                                                  "PK before", "after", "mean before", "after", "max before", "after",
                                                  "fit %"}};
  for (const EvaluationRow& row : rows)
    if (row.channel == channel) table.push_back(line_of(row));
  return table;
}

std::string Evaluation::tables() const {
  std::string text;
  std::vector<std::string> channels, units;
  for (const EvaluationRow& row : rows) {
    if (std::find(channels.begin(), channels.end(), row.channel) != channels.end()) continue;
    channels.push_back(row.channel);
    units.push_back(row.unit);
  }
  for (std::size_t c = 0; c < channels.size(); ++c)
    text += fmt::format("\n{} ({})\n", channels[c], units[c]) + core::format_table(table(channels[c]));
  return text;
}

std::string CrossExperiment::brief() const {
  std::string text = "RMS removed in %, fitted on the row's program, judged on the column's\n";
  for (const Entry& entry : entries) {
    std::vector<std::vector<std::string>> table = {{entry.model}};
    table[0].insert(table[0].end(), programs.begin(), programs.end());
    for (std::size_t i = 0; i < programs.size(); ++i) {
      table.push_back({programs[i]});
      for (std::size_t j = 0; j < programs.size(); ++j) {
        table.back().push_back(number(entry.reduction_percent(i, j), "{:.1f}"));
      }
    }
    text += core::format_table(table);
  }
  for (const std::string& note : notes) text += "  " + note + "\n";
  return text;
}

}  // namespace thermotwin::compensation
