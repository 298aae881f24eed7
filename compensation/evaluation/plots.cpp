// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/evaluation/plots.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "compensation/evaluation/result.h"
#include "core/statistics.h"
#include "core/svg.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr std::array<const char*, 6> colours{"#222222", "#d1495b", "#2e86ab", "#3b8132", "#b26e00", "#7a4fa3"};

std::string label(double x, double y, const std::string& text, const char* anchor = "start", const char* extra = "") {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" {}>{}</text>\n", x, y, anchor, extra,
                     core::xml_text(text));
}

std::string opening(double width, double height) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
      width, height);
}

/// A panel with axes; maps values to pixels.
struct Panel {
  double left, top, width, height, x_low, x_high, y_low, y_high;
  double x(double value) const { return left + (value - x_low) / (x_high - x_low) * width; }
  double y(double value) const { return top + height - (value - y_low) / (y_high - y_low) * height; }

  std::string frame(const std::string& x_name, const std::string& y_name) const {
    std::string svg;
    for (const double tick : core::axis_ticks(y_low, y_high, 6)) {
      svg += fmt::format("<line x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"#dddddd\"/>\n", left,
                         left + width, y(tick), y(tick));
      svg += label(left - 6, y(tick) + 4, fmt::format("{:g}", std::abs(tick) < 1e-12 ? 0.0 : tick), "end");
    }
    for (const double tick : core::axis_ticks(x_low, x_high, 10)) {
      svg += fmt::format("<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1:.1f}\" y2=\"{2:.1f}\" stroke=\"#eeeeee\"/>\n",
                         x(tick), top, top + height);
      if (!x_name.empty()) svg += label(x(tick), top + height + 16, fmt::format("{:g}", tick), "middle");
    }
    svg += fmt::format(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"none\" stroke=\"#888888\"/>\n", left,
        top, width, height);
    svg += label(left, top - 6, y_name);
    if (!x_name.empty()) svg += label(left + width, top + height + 32, x_name, "end");
    return svg;
  }

  /// At most 1500 points: more than pixels show nothing more. A missing value breaks the line.
  std::string line(const VectorXd& at, const VectorXd& values, const char* colour, double thickness) const {
    std::string path;
    const Index stride = std::max<Index>(1, at.size() / 1500);
    bool pen_down = false;
    for (Index i = 0; i < at.size(); i += stride) {
      if (!std::isfinite(values[i])) {
        pen_down = false;
        continue;
      }
      path += fmt::format("{}{:.1f} {:.1f}", pen_down ? " L" : " M", x(at[i]), y(std::clamp(values[i], y_low, y_high)));
      pen_down = true;
    }
    return fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"/>\n", path, colour, thickness);
  }
};

void widen(double& low, double& high) {
  if (!(high > low)) {
    low -= 1.0;
    high += 1.0;
  }
  const double margin = 0.05 * (high - low);
  low -= margin;
  high += margin;
}

std::string bars_of(const Panel& panel, double at, double half, const Quartiles& box, const char* colour) {
  std::string svg;
  const auto horizontal = [&](double value, double wide, double thickness) {
    svg += fmt::format(
        "<line x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" stroke-width=\"{}\"/>\n",
        at - wide, at + wide, panel.y(value), panel.y(value), colour, thickness);
  };
  svg += fmt::format("<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1:.1f}\" y2=\"{2:.1f}\" stroke=\"{3}\"/>\n", at,
                     panel.y(box.whisker_low), panel.y(box.whisker_high), colour);
  svg +=
      fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"white\" stroke=\"{}\"/>\n",
                  at - half, panel.y(box.high), 2 * half, std::max(0.5, panel.y(box.low) - panel.y(box.high)), colour);
  horizontal(box.median, half, 2.5);
  horizontal(box.whisker_low, half / 2, 1);
  horizontal(box.whisker_high, half / 2, 1);
  for (const double value : box.outliers) {
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2\" fill=\"none\" stroke=\"{}\"/>\n", at,
                       panel.y(std::min(value, panel.y_high)), colour);
  }
  return svg;
}

}  // namespace

std::vector<std::string> judged_channels(const Evaluation& evaluation) {
  std::vector<std::string> channels;
  for (const EvaluationRow& row : evaluation.rows) {
    if (std::find(channels.begin(), channels.end(), row.channel) == channels.end()) channels.push_back(row.channel);
  }
  return channels;
}

std::string leaderboard_svg(const Evaluation& evaluation) {
  constexpr double row = 24.0, left = 210.0, width = 480.0, top = 46.0;
  const double count = evaluation.leaderboard.size();
  std::string svg = opening(left + width + 90.0, top + row * count + 46.0);
  const bool fits = std::any_of(evaluation.leaderboard.begin(), evaluation.leaderboard.end(),
                                [](const Standing& s) { return s.seen_by_fit; });
  svg += label(12, 22,
               fits ? "RMS of the thermal error removed, %; (fit): on training rows, nothing was held out"
                    : "RMS of the thermal error removed on held-out data, %",
               "start", "font-size=\"15\" font-weight=\"bold\"");
  double low = 0.0;
  for (const Standing& standing : evaluation.leaderboard) {
    if (std::isfinite(standing.reduction_percent)) low = std::min(low, standing.reduction_percent);
  }
  low = std::max(low, -100.0);  // how much worse than nothing matters little
  const Panel panel{left, top, width, row * count, low, 100.0, 0.0, 1.0};
  for (const double tick : core::axis_ticks(low, 100.0, 8)) {
    svg += fmt::format("<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1:.1f}\" y2=\"{2:.1f}\" stroke=\"#dddddd\"/>\n",
                       panel.x(tick), top, top + row * count);
    svg += label(panel.x(tick), top + row * count + 18, fmt::format("{:g}", tick), "middle");
  }
  double y = top;
  for (const Standing& standing : evaluation.leaderboard) {
    const bool twin = standing.model.starts_with("reduced_model") || standing.model.starts_with("extended_model"),
               baseline = standing.model == "static_regression";
    const double value =
        std::isfinite(standing.reduction_percent) ? std::clamp(standing.reduction_percent, low, 100.0) : 0.0;
    const double from = panel.x(std::min(0.0, value)), to = panel.x(std::max(0.0, value));
    svg +=
        label(left - 8, y + 16,
              standing.model + (standing.seen_by_fit ? " (fit)" : "") + (standing.caution.empty() ? "" : " *"), "end");
    svg += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"/>\n", from,
                       y + 4, to - from, row - 8,
                       twin       ? "#d1495b"
                       : baseline ? "#888888"
                                  : "#2e86ab");
    svg += label(panel.x(100.0) + 8, y + 16, fmt::format("{:.1f} ({})", standing.reduction_percent, standing.channels));
    y += row;
  }
  svg += label(panel.x(100.0) + 8, top - 8, "(channels)");
  if (std::any_of(evaluation.leaderboard.begin(), evaluation.leaderboard.end(),
                  [](const Standing& s) { return !s.caution.empty(); }))
    svg += label(12, top + row * count + 36, "* ranked last, reason in tables.txt");
  return svg + "</svg>\n";
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
  const VectorXd hours = table.column("time_s") / 3600.0, measured = table.column(channel + "_measured");
  std::string unit;
  for (const EvaluationRow& row : evaluation.rows) unit = row.channel == channel ? row.unit : unit;

  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const double value : measured) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  if (!(low <= high)) low = high = 0.0;
  widen(low, high);
  double x_low = hours[0], x_high = hours[hours.size() - 1];
  if (!(x_high > x_low)) x_high = x_low + 1.0;
  const double half = 0.5 * (high - low);
  const Panel above{70, 60, 860, 260, x_low, x_high, low, high}, below{70, 360, 860, 200, x_low, x_high, -half, half};
  std::string svg = opening(960, 610);
  for (const EvaluationRow& row : evaluation.rows) {
    if (shown.empty() || !row.training || row.channel != channel || row.model != shown.front()) continue;
    for (const Panel& panel : {above, below}) {
      const double from = panel.x(std::max(x_low, row.from_s / 3600.0)),
                   to = panel.x(std::min(x_high, row.to_s / 3600.0));
      svg += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"#f2f2f2\"/>\n",
                         from, panel.top, std::max(0.0, to - from), panel.height);
    }
  }
  svg += above.frame("", fmt::format("{} in {}", channel, unit)) +
         below.frame("time in h", fmt::format("measured minus predicted in {}", unit));
  svg += above.line(hours, measured, colours[0], 2.0);
  double x = 70.0;
  const auto legend = [&](const std::string& text, const char* colour) {
    svg += fmt::format("<line x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"20\" y2=\"20\" stroke=\"{}\" stroke-width=\"3\"/>\n", x,
                       x + 18, colour) +
           label(x + 22, 24, text);
    x += 40.0 + 7.2 * text.size();
  };
  legend("measured", colours[0]);
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const VectorXd predicted = table.column(channel + "_" + shown[i]);
    const char* colour = shown[i] == "static_regression" ? "#999999" : colours[1 + i % (colours.size() - 1)];
    svg += above.line(hours, predicted, colour, 1.3) + below.line(hours, measured - predicted, colour, 1.3);
    legend(shown[i], colour);
  }
  svg += label(x, 24, "shaded: training data", "start", "fill=\"#777777\"");
  return svg + "</svg>\n";
}

Quartiles quartiles(const VectorXd& values) {
  std::vector<double> sorted;
  for (const double value : values) {
    if (std::isfinite(value)) sorted.push_back(value);
  }
  Quartiles result;
  constexpr double missing = std::numeric_limits<double>::quiet_NaN();
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
  high = high > 0.0 ? 1.3 * high : 1.0;
  const Panel panel{70, 60, 700, 320, 0.0, 1.0 * study.hours.size(), 0.0, high};
  std::string svg =
      opening(800, 440) +
      panel.frame("", fmt::format("RMS residual in {}: blue in the fitted section, red outside of it", study.unit));
  svg += label(70, 24, fmt::format("{} of {}: residual over the length of the measurement", study.model, study.channel),
               "start", "font-size=\"15\" font-weight=\"bold\"");
  for (Index l = 0; l < study.hours.size(); ++l) {
    const std::size_t i = l;
    const double at = panel.x(l + 0.5);
    if (std::isfinite(fit[i].median)) svg += bars_of(panel, at - 14, 11, fit[i], colours[2]);
    if (std::isfinite(rest[i].median)) svg += bars_of(panel, at + 14, 11, rest[i], colours[1]);
    svg += label(at, 398, fmt::format("{:.3g} h", study.hours[l]), "middle");
  }
  return svg + "</svg>\n";
}

}  // namespace thermotwin::compensation
