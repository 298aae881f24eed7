// SPDX-License-Identifier: GPL-3.0-or-later
// The verb measure uncertainty --arc: what continuous R-Tests over short arcs can tell.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/plot.h"
#include "core/table.h"
#include "core/text.h"
#include "core/units.h"
#include "metrology/fit/arc_study.h"
#include "tools/measure/measure.h"

namespace thermotwin::tools {
namespace {

using metrology::ArcStudy;
using metrology::ArcStudyResult;
using nlohmann::json;
namespace units = core::units;

constexpr const char* names[] = {"centre_along", "centre_across", "tilt_along", "tilt_across"};

ArcStudy study_of(const MeasureOptions& options, double span_deg) {
  ArcStudy study;
  study.span = span_deg * units::deg;
  study.radius = options.radius_mm * units::mm;
  study.half_width = options.half_width_um * units::um;
  study.rate = options.rate_Hz;
  study.feed = options.feed_deg_min * units::deg_min;
  study.plane_offset = options.plane_offset_mm * units::mm;
  study.draws = options.draws;
  study.seed = options.seed;
  study.method = options.fit == "kasa"     ? metrology::CircleMethod::kasa
                 : options.fit == "taubin" ? metrology::CircleMethod::taubin
                                           : metrology::CircleMethod::geometric;
  return study;
}

/// Clouds of the centre (Fig. 4.15) and of the tilt (Figs. 4.16, 4.17), the same axes for all arcs.
std::string clouds(const std::vector<double>& arcs, const std::vector<ArcStudyResult>& results) {
  constexpr double width = 860, height = 420;
  core::Plot plot(width, height, "clouds of the centre and of the tilt of the axis");
  const char* titles[] = {"centre, um", "tilt of the axis, um/m"};
  for (Eigen::Index panel = 0; panel < 2; ++panel) {
    core::Axis x{"across the bisector"}, y{"along the bisector"};
    for (const ArcStudyResult& result : results) {
      x.include(result.draws.col(2 * panel + 1) / units::um);
      y.include(result.draws.col(2 * panel) / units::um);
    }
    x.close(0.05);
    y.close(0.05);
    plot.title(70.0 + 430.0 * panel, 24, titles[panel]);
    core::Panel at(plot, {70.0 + 430.0 * panel, 60, 330, 300}, x, y);
    at.x_axis();
    at.y_axis();
    for (std::size_t i = 0; i < results.size(); ++i)
      at.dots(results[i].draws.col(2 * panel + 1) / units::um, results[i].draws.col(2 * panel) / units::um,
              core::series_ink(i));
  }
  double key = 300;
  for (std::size_t i = 0; i < arcs.size(); ++i)
    key = plot.key(key, 42, fmt::format("{:.4g} deg", arcs[i]), core::series_ink(i));
  return plot.file();
}

core::Table draws_table(const std::vector<double>& arcs, const std::vector<ArcStudyResult>& results) {
  core::Table table;
  table.columns = {"arc_deg", "centre_along_um", "centre_across_um", "tilt_along_um_per_m", "tilt_across_um_per_m"};
  Eigen::Index rows = 0;
  for (const ArcStudyResult& result : results) rows += result.draws.rows();
  table.values.resize(rows, 5);
  rows = 0;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const Eigen::MatrixX4d& draws = results[i].draws;
    table.values.col(0).segment(rows, draws.rows()).setConstant(arcs[i]);
    table.values.block(rows, 1, draws.rows(), 4) = draws / units::um;
    rows += draws.rows();
  }
  return table;
}

}  // namespace

void measure_arcs(const MeasureOptions& options) {
  std::vector<ArcStudyResult> results;
  for (const double arc : options.arcs_deg) results.push_back(metrology::study_arc(study_of(options, arc)));
  std::vector<std::vector<std::string>> rows{
      {"arc deg", "points", "quantity", "unit", "std", "theory", "range", "mean"}};
  json arcs = json::array();
  for (std::size_t i = 0; i < results.size(); ++i) {
    const ArcStudyResult& result = results[i];
    json arc = {{"arc_deg", options.arcs_deg[i]}, {"points", result.points}};
    for (int k = 0; k < 4; ++k) {
      rows.push_back({fmt::format("{:.4g}", options.arcs_deg[i]), fmt::format("{}", result.points), names[k],
                      k < 2 ? "um" : "um/m", fmt::format("{:.3g}", result.std[k] / units::um),
                      fmt::format("{:.3g}", result.theory[k] / units::um),
                      fmt::format("{:.3g}", result.range[k] / units::um),
                      fmt::format("{:.2g}", result.draws.col(k).mean() / units::um)});
      arc[names[k]] = {{"mean", result.draws.col(k).mean() / units::um},
                       {"std", result.std[k] / units::um},
                       {"theory", result.theory[k] / units::um},
                       {"range", result.range[k] / units::um}};
    }
    arcs.push_back(arc);
  }
  core::write_csv(options.out / "arcs.csv", draws_table(options.arcs_deg, results));
  core::write_file(options.out / "arcs.svg", clouds(options.arcs_deg, results));
  const json result = {{"arcs", arcs}, {"draws", options.draws}, {"plane_offset_mm", options.plane_offset_mm}};
  core::write_file(options.out / "arcs.json", result.dump(1) + "\n");
  print_summary(options,
                core::format_table(rows) + fmt::format("{} draws of each arc; clouds in {}\n", options.draws,
                                                       (options.out / "arcs.svg").string()),
                result.dump());
}

}  // namespace thermotwin::tools
