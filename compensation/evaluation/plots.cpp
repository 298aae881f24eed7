// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/evaluation/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/missing.h"
#include "core/page_text.h"
#include "core/plot.h"
#include "core/statistics.h"
#include "core/units.h"

namespace thermotwin::compensation {

using core::missing;
namespace {

using core::Ink;
using Eigen::Index;
using Eigen::VectorXd;

/// A box from quartile to quartile the median through it, whiskers and outliers.
void draw_quartiles(core::Panel& panel, double at, const Quartiles& quarters, Ink ink) {
  constexpr double half = 0.13;
  panel.stroke(at, quarters.whisker_low, at, quarters.low, ink);
  panel.stroke(at, quarters.high, at, quarters.whisker_high, ink);
  panel.box(at - half, at + half, quarters.low, quarters.high, ink, 0.3);
  panel.stroke(at - half, quarters.median, at + half, quarters.median, ink);
  for (const double whisker : {quarters.whisker_low, quarters.whisker_high})
    panel.stroke(at - half / 2, whisker, at + half / 2, whisker, ink);
  const Eigen::Map<const VectorXd> outliers(quarters.outliers.data(), std::ssize(quarters.outliers));
  panel.dots(VectorXd::Constant(outliers.size(), at), outliers, ink);
}

}  // namespace

std::vector<std::string> scored_channels(const Evaluation& evaluation) {
  std::vector<std::string> channels;
  for (const EvaluationRow& row : evaluation.rows) {
    if (std::find(channels.begin(), channels.end(), row.channel) == channels.end()) channels.push_back(row.channel);
  }
  return channels;
}

std::string leaderboard_svg(const Evaluation& evaluation) {
  const std::vector<Standing>& standings = evaluation.leaderboard;
  const bool fits = std::any_of(standings.begin(), standings.end(), [](const Standing& s) { return s.seen_by_fit; });
  const std::string title = fits ? "RMS of the thermal error removed, %; (fit): on training rows, nothing was held out"
                                 : "RMS of the thermal error removed on held-out data, %";
  constexpr double row = 24.0;
  const double count = std::ssize(standings);
  const core::Frame frame{210.0, 46.0, 480.0, row * count};
  core::Plot plot(frame.right() + 90.0, frame.bottom() + 46.0, title);
  plot.title(12, 22, title);
  core::Axis removed{"", false, 0.0, 100.0};
  for (const Standing& standing : standings) removed.include(std::max(standing.reduction_percent, -100.0));
  core::Panel panel(plot, frame, removed, {"", false, count, 0.0});
  panel.x_axis(true);
  plot.text(frame.right() + 8, frame.top - 8, "(channels)");
  for (std::size_t i = 0; i < standings.size(); ++i) {
    const Standing& standing = standings[i];
    const bool twin = standing.model.starts_with("reduced_model") || standing.model.starts_with("extended_model");
    const Ink ink = twin ? Ink::orange : standing.model == "static_regression" ? Ink::grey : Ink::blue;
    const double base = frame.top + row * i + 16.0;
    plot.text(frame.left - 8, base,
              standing.model + (standing.seen_by_fit ? " (fit)" : "") + (standing.caution.empty() ? "" : " *"),
              core::Anchor::end);
    if (std::isfinite(standing.reduction_percent)) panel.box(0.0, standing.reduction_percent, i + 0.17, i + 0.83, ink);
    plot.text(frame.right() + 8, base, fmt::format("{:.1f} ({})", standing.reduction_percent, standing.channels));
  }
  if (std::any_of(standings.begin(), standings.end(), [](const Standing& s) { return !s.caution.empty(); }))
    plot.text(12, frame.bottom() + 36,
              "* ranked last: its fit is not to be relied on; the notes and tables.txt give the reason");
  return plot.file();
}

std::string channel_svg(const Evaluation& evaluation, const std::string& channel) {
  const core::Table& table = evaluation.predictions;
  std::vector<std::string> shown;
  for (const Standing& standing : evaluation.leaderboard) {
    if (shown.size() < 3 && table.find(channel + "_" + standing.model)) shown.push_back(standing.model);
  }
  if (std::find(shown.begin(), shown.end(), "static_regression") == shown.end() &&
      table.find(channel + "_static_regression"))
    shown.emplace_back("static_regression");
  const VectorXd hours = table.column("time_s") / core::units::hour, measured = table.column(channel + "_measured");
  std::string unit;
  for (const EvaluationRow& row : evaluation.rows) unit = row.channel == channel ? core::unit_text(row.unit) : unit;

  core::Axis time{"time in h"}, value{fmt::format("{} in {}", channel, unit)};
  time.include(hours);
  time.close();
  value.include(measured);
  value.close(0.05);
  const double half = 0.5 * (value.high - value.low);
  core::Plot plot(960, 610, channel + ", measured and predicted");
  core::Panel above(plot, {70, 44, 860, 276}, time, value),
      below(plot, {70, 350, 860, 216}, time, {fmt::format("measured minus predicted in {}", unit), false, -half, half});
  // Reduced models are not fitted; all fitted ones have the same rows.
  const auto fitted = std::find_if(evaluation.rows.begin(), evaluation.rows.end(),
                                   [&](const EvaluationRow& row) { return row.training && row.channel == channel; });
  for (const EvaluationRow& row : evaluation.rows) {
    if (!row.training || row.channel != channel || row.model != fitted->model) continue;
    for (core::Panel* panel : {&above, &below})
      panel->shade(row.from_s / core::units::hour, row.to_s / core::units::hour);
  }
  above.y_axis();
  below.y_axis();
  below.x_axis();
  above.line(hours, measured, Ink::black);
  double legend = plot.key(70, 20, "measured", Ink::black);
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const VectorXd predicted = table.column(channel + "_" + shown[i]);
    const Ink ink = shown[i] == "static_regression" ? Ink::grey : core::series_ink(i);
    above.line(hours, predicted, ink);
    below.line(hours, measured - predicted, ink);
    legend = plot.key(legend, 20, shown[i], ink);
  }
  if (fitted != evaluation.rows.end()) plot.text(legend, 24, "shaded: training data");
  return plot.file();
}

std::string step_responses_svg(const FittedModel& model) {
  std::vector<std::pair<const FittedModel::ChannelSteps*, const StepResponse*>> drawn;
  const std::vector<FittedModel::ChannelSteps> channels = model.step_responses();
  for (const auto& channel : channels)
    for (const StepResponse& response : channel.responses) drawn.emplace_back(&channel, &response);
  if (drawn.empty()) return {};
  constexpr double left = 70, top = 60, width = 340, height = 170, across = 450, down = 250;
  constexpr std::size_t columns = 2;
  const std::string title = model.name() + ": answers to a unit step of one input";
  const double rows = (drawn.size() + columns - 1) / columns;
  core::Plot plot(columns * across, rows * down + 40.0, title);
  plot.title(left, 24, title);
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    const auto& [channel, response] = drawn[i];
    const VectorXd hours =
        VectorXd::LinSpaced(response->values.size(), 0.0, (response->values.size() - 1) * response->interval_s) /
        core::units::hour;
    core::Axis time{"time in h"}, value{core::unit_text(channel->unit) + " per unit"};
    time.include(hours);
    time.close();
    value.include(0.0);
    value.include(response->end);
    value.include(response->values);
    value.close(0.05);
    const core::Frame frame{left + across * (i % columns), top + down * (i / columns), width, height};
    core::Panel panel(plot, frame, time, value);
    panel.y_axis();
    panel.x_axis();
    panel.line(hours, response->values, Ink::blue);
    panel.level(response->end, "");
    plot.text(
        frame.left, frame.top - 8,
        fmt::format("{}, step of {}{}", channel->channel, response->input, response->stable() ? "" : ", unstable"));
  }
  return plot.file();
}

std::vector<std::string> stability_lines(const FittedModel& model) {
  std::vector<std::string> lines;
  for (const auto& channel : model.step_responses()) {
    for (const StepResponse& response : channel.responses) {
      lines.push_back(fmt::format("{} {}, step of {}: {}, largest pole {:.6f}; {:.4g} {} per unit, 95 % after {:.3g} h",
                                  model.name(), channel.channel, response.input,
                                  response.stable() ? "stable" : "unstable", response.largest_pole, response.end,
                                  channel.unit, response.settling_s / core::units::hour));
    }
  }
  return lines;
}

Quartiles quartiles(const VectorXd& values) {
  std::vector<double> sorted;
  for (const double value : values) {
    if (std::isfinite(value)) sorted.push_back(value);
  }
  Quartiles result;
  if (sorted.empty()) return {missing, missing, missing, missing, missing, {}};
  std::sort(sorted.begin(), sorted.end());
  result.low = core::quantile(sorted, 0.25);
  result.median = core::quantile(sorted, 0.5);
  result.high = core::quantile(sorted, 0.75);
  const double reach = 1.5 * (result.high - result.low);
  result.whisker_low = result.low;
  result.whisker_high = result.high;
  for (const double value : sorted) {
    if (value < result.low - reach || value > result.high + reach) {
      result.outliers.push_back(value);
    } else {
      result.whisker_low = std::min(result.whisker_low, value);
      result.whisker_high = std::max(result.whisker_high, value);
    }
  }
  return result;
}

std::string length_study_svg(const LengthStudy& study) {
  std::vector<Quartiles> fit, rest;
  double high = 0.0;
  for (Index l = 0; l < study.hours.size(); ++l) {
    fit.push_back(quartiles(study.fit_rms.row(l).transpose()));
    rest.push_back(quartiles(study.rest_rms.row(l).transpose()));
    for (const double value : {fit.back().whisker_high, rest.back().high}) {
      if (std::isfinite(value)) high = std::max(high, value);
    }
  }
  const std::string title =
      fmt::format("{} of {}: residual over the length of the measurement", study.model, study.channel);
  const std::string unit = core::unit_text(study.unit);
  core::Plot plot(800, 440, title);
  plot.title(70, 24, title);
  plot.key(plot.key(70, 44, "in the section that was fitted", Ink::blue), 44, "outside of it", Ink::orange);
  core::Panel panel(plot, {70, 60, 700, 320}, {"", false, 0.0, 1.0 * study.hours.size()},
                    {fmt::format("RMS residual in {}", unit), false, 0.0, high > 0.0 ? 1.3 * high : 1.0});
  panel.y_axis();
  for (Index l = 0; l < study.hours.size(); ++l) {
    const std::size_t i = l;
    if (std::isfinite(fit[i].median)) draw_quartiles(panel, l + 0.34, fit[i], Ink::blue);
    if (std::isfinite(rest[i].median)) draw_quartiles(panel, l + 0.66, rest[i], Ink::orange);
    plot.text(panel.x(l + 0.5), 398, fmt::format("{:.3g} h", study.hours[l]), core::Anchor::middle);
  }
  return plot.file();
}

}  // namespace thermotwin::compensation
