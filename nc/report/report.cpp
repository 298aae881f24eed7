// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/plot.h"
#include "core/text.h"
#include "core/units.h"
#include "nc/report/path_scene.h"
#include "nc/report/time_text.h"

namespace thermotwin::nc {

namespace units = core::units;

namespace {

using Rows = std::vector<std::vector<std::string>>;

constexpr std::size_t most_rows = 300;  ///< of a table of the page; the CSV files have all

/// The path's point of the largest error in a cut; none: nothing is cut.
const PathPoint* worst_of(const PathPoints& path) {
  const PathPoint* worst = nullptr;
  for (const PathPoint& point : path.points())
    if (!point.rapid && (worst == nullptr || point.error_um.norm() > worst->error_um.norm())) worst = &point;
  return worst;
}

std::string headline(const Report& report, const PathPoints& path, const BeyondLimits& beyond) {
  const PathPoint* worst = worst_of(path);
  int part = report.parts;
  if (report.worst_before && (worst == nullptr || report.worst_before->error_um.norm() > worst->error_um.norm())) {
    worst = &*report.worst_before;
    part = report.worst_part;
  }
  std::vector<std::string> sentences;
  if (worst != nullptr)
    sentences.push_back(fmt::format("The largest TCP error of a cut is {:.1f} µm (± {:.1f}), in line {}{} after {}.",
                                    worst->error_um.norm(), worst->std_um.norm(), worst->line,
                                    report.parts > 1 ? fmt::format(" of part {}", part) : "", time_text(worst->time)));
  if (report.first_good_part > 1)
    sentences.push_back(
        fmt::format("The first good part is number {}: its mean offsets and those of all later parts "
                    "lie within {:.3g} µm of the last one's. It begins after {}.",
                    report.first_good_part, report.tolerance_um, time_text(report.warm_up_s)));
  if (report.parts > 1 && report.drift_ahead_um > report.tolerance_um)
    sentences.push_back("<span class=\"warning\">" + unsettled_text(report.drift_ahead_um, report.tolerance_um, "µm") +
                        "</span>");
  if (!report.rewritten.empty()) sentences.push_back(core::html_sentence(report.rewritten));
  if (!beyond.entries().empty())
    sentences.push_back("<span class=\"warning\">Some moves are beyond limits; a table below lists them.</span>");
  if (sentences.empty()) sentences.emplace_back("The program cuts nothing.");
  const std::vector<std::string> tiles{
      core::html_tile("duration", time_text(report.duration_s),
                      fmt::format("{} moves, {} lines{}", report.moves, report.lines,
                                  report.parts > 1 ? fmt::format("; {} parts", report.parts) : "")),
      core::html_tile("cutting", time_text(report.cutting_s), "at feed"),
      core::html_tile("rapid", time_text(report.rapid_s), "between cuts"),
      core::html_tile("standing", time_text(report.pause_s), "dwells, tool changes, stops"),
      core::html_tile("largest error", worst == nullptr ? "none" : fmt::format("{:.1f} µm", worst->error_um.norm()),
                      worst == nullptr ? "" : fmt::format("± {:.1f} µm", worst->std_um.norm()))};
  return core::html_finding(beyond.entries().empty() ? core::Tone::plain : core::Tone::warn, "error along the program",
                            sentences) +
         core::html_tiles(tiles);
}

std::string over_time(const ErrorOverTime& errors, double duration) {
  std::vector<std::size_t> filled;
  for (std::size_t i = 0; i < errors.intervals().size(); ++i)
    if (errors.intervals()[i].count > 0) filled.push_back(i);
  if (filled.empty()) return "";
  const TimeUnit unit = unit_for(duration);
  const auto count = std::ssize(filled);
  Eigen::VectorXd time(count);
  for (Eigen::Index i = 0; i < count; ++i) time[i] = (filled[i] + 0.5) * errors.width() / unit.seconds;
  constexpr double height = 120.0, apart = 146.0, top = 8.0;
  core::Axis across{"", false};
  across.include(0.0);
  across.include(duration / unit.seconds);
  across.close();
  core::Plot plot(1080, 3 * apart + 16 + top, "TCP error of the cuts over time with its standard deviation");
  constexpr const char* names[] = {"X in \u00b5m", "Y in \u00b5m", "Z in \u00b5m"};
  for (int c = 0; c < 3; ++c) {
    Eigen::VectorXd mean(count), low(count), high(count), std(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const ErrorOverTime::Interval& interval = errors.intervals()[filled[i]];
      mean[i] = interval.sum[c] / interval.count;
      low[i] = interval.low[c];
      high[i] = interval.high[c];
      std[i] = interval.std[c];
    }
    core::Axis error{names[c]};
    error.include(0.0);
    error.include(low - 2.0 * std);
    error.include(high + 2.0 * std);
    error.close(0.06);
    if (c == 2) across.title = fmt::format("time in {}", unit.name);
    core::Panel panel(plot, {64, top + apart * c, 1000, height}, across, error);
    panel.band(time, low - 2.0 * std, high + 2.0 * std);
    panel.y_axis();
    panel.x_axis();
    panel.line(time, low, core::Ink::grey);
    panel.line(time, high, core::Ink::grey);
    panel.line(time, mean, core::Ink::blue);
  }
  const std::string legend =
      "<div class=\"legend\"><span><i class=\"blue\"></i>mean of the cuts</span><span><i class=\"grey\"></i>smallest "
      "and largest</span><span><i class=\"band\"></i>with two standard deviations</span></div>\n";
  return core::html_section(
      "Error over time",
      fmt::format("cuts within {}; translations of the tool against the table", time_text(errors.width())),
      legend + plot.inset());
}

std::string not_shown(std::size_t all, const char* file) {
  if (all <= most_rows) return "";
  return fmt::format("<p class=\"below\">{} of {} rows; {} has all.</p>\n", most_rows, all, file);
}

std::string operations_section(const Operations& operations, const Report& report) {
  Rows rows{{"operation", "tool", "lines", "duration", "cutting", "feed mm/min", "spindle rpm"}};
  if (report.parts > 1) rows.front().insert(rows.front().begin(), "part");
  for (const std::string& axis : report.axes)
    for (const char* what : {"mean", "largest", "std"})
      rows.front().push_back(fmt::format("offset {} {} um", axis, what));
  const auto all = operations.all();
  for (const auto& [key, o] : all) {
    if (rows.size() > most_rows) break;
    std::vector<std::string> row{std::to_string(key.second),
                                 o->tool > 0 ? fmt::format("T{}", o->tool) : "none",
                                 fmt::format("{} to {}", o->first_line, o->last_line),
                                 time_text(o->duration()),
                                 time_text(o->cutting_s),
                                 fmt::format("{:.0f}", o->mean_feed() / units::mm_min),
                                 fmt::format("{:.0f}", o->duration() > 0 ? o->rpm_s / o->duration() : 0.0)};
    if (report.parts > 1) row.insert(row.begin(), std::to_string(key.first + 1));
    for (std::size_t i = 0; i < report.axes.size(); ++i) {
      const Eigen::Index k = i;
      if (o->cuts == 0) {
        row.insert(row.end(), 3, "");
        continue;
      }
      row.push_back(fmt::format("{:.2f}", o->sum_um[k] / o->cuts));
      row.push_back(fmt::format("{:.2f}", o->largest_um[k]));
      row.push_back(fmt::format("{:.2f}", o->std_um[k]));
    }
    rows.push_back(row);
  }
  return core::html_section("Operations", "between tool changes and program stops; offsets of the cuts",
                            core::html_table(rows) + not_shown(all.size(), "operations.csv"));
}

std::string beyond_section(const BeyondLimits& beyond) {
  const compensation::OffsetLimits& limits = beyond.limits();
  const std::string below = fmt::format("limits of the offsets: {:.0f} µm, and {:.3g} µm/s beside the axes' motion",
                                        limits.largest_um, limits.rate_um_s);
  if (beyond.entries().empty())
    return core::html_section("Moves beyond limits", below,
                              "<p>None: all moves end within the workspace of the model.</p>");
  Rows rows{{"what", "lines", "from", "to", "moves", "largest"}};
  for (const BeyondLimits::Entry& entry : beyond.entries()) {
    const bool workspace = entry.kind == BeyondLimits::Kind::workspace;
    rows.push_back(
        {workspace                                ? "pose outside of the workspace of the model"
         : entry.kind == BeyondLimits::Kind::size ? "offset above its limit"
                                                  : "offset changes faster than its limit",
         fmt::format("{} to {}", entry.first_line, entry.last_line), time_text(entry.start_s), time_text(entry.end_s),
         std::to_string(entry.moves),
         workspace ? ""
                   : fmt::format("{:.3g} um{}", entry.largest, entry.kind == BeyondLimits::Kind::rate ? "/s" : "")});
  }
  std::string markup = core::html_table(rows);
  if (beyond.not_listed() > 0)
    markup += fmt::format("<p class=\"below\">{} further moves are not listed.</p>\n", beyond.not_listed());
  return core::html_section("Moves beyond limits", below, markup);
}

core::Plot parts_plot(const Parts& parts, const Report& report) {
  const auto count = std::ssize(parts.all());
  Eigen::VectorXd number(count);
  core::Axis across{"part"}, offset{"offset in \u00b5m"};
  for (Eigen::Index i = 0; const auto& [part, values] : parts.all()) {
    number[i++] = part + 1;
    for (const Eigen::ArrayXd& one : {values.low, values.high, Eigen::ArrayXd(values.mean())})
      offset.include(Eigen::VectorXd(one.matrix()));
  }
  across.include(number);
  across.close();
  offset.include(0.0);
  offset.close(0.06);
  core::Plot plot(1080, 340, "Offsets of the cuts of each part");
  core::Panel panel(plot, {64, 30, 1000, 260}, across, offset);
  std::vector<Eigen::VectorXd> mean(report.axes.size(), Eigen::VectorXd(count)), low = mean, high = mean;
  for (Eigen::Index i = 0; const auto& [part, values] : parts.all()) {
    for (std::size_t a = 0; a < report.axes.size(); ++a) {
      const Eigen::Index k = a;
      mean[a][i] = values.mean()[k];
      low[a][i] = values.low[k];
      high[a][i] = values.high[k];
    }
    ++i;
  }
  for (std::size_t a = 0; a < report.axes.size(); ++a) panel.band(number, low[a], high[a]);
  panel.y_axis();
  panel.x_axis();
  double at = 64;
  for (std::size_t a = 0; a < report.axes.size(); ++a) {
    panel.line(number, mean[a], core::series_ink(a));
    panel.dots(number, mean[a], core::series_ink(a));
    at = plot.key(at, 18, report.axes[a], core::series_ink(a)) + 14;
  }
  if (report.first_good_part > 0) {
    panel.mark(report.first_good_part);
    plot.text(1064, 18,
              fmt::format("dashed: first part within {:.3g} \u00b5m of the last one, number {}, after {}",
                          report.tolerance_um, report.first_good_part, time_text(report.warm_up_s)),
              core::Anchor::end);
  }
  return plot;
}

std::string parts_section(const Parts& parts, const Report& report) {
  if (report.parts < 2 || parts.all().empty()) return "";
  return core::html_section("Series of parts", "mean offsets of each part's cuts and their range",
                            parts_plot(parts, report).inset());
}

}  // namespace

std::string parts_svg(const Parts& parts, const Report& report) { return parts_plot(parts, report).file(); }

std::string report_page(const Report& report, const PathPoints& path, const ErrorOverTime& errors,
                        const Operations& operations, const BeyondLimits& beyond, const Parts& parts) {
  const std::string title = "TCP error along " + report.program;
  return core::html_document(
      title,
      core::html_title(title, fmt::format("{}; {}", report.machine, report.begins)) + headline(report, path, beyond) +
          path_scene_html(path, report.parts > 1 ? "of the last part; the tool's tip in the workpiece"
                                                 : "the tool's tip in the workpiece") +
          over_time(errors, report.duration_s) + parts_section(parts, report) + report.imprint + report.locations +
          operations_section(operations, report) + beyond_section(beyond) + core::html_next_steps(report.next));
}

}  // namespace thermotwin::nc
