// SPDX-License-Identifier: GPL-3.0-or-later
// The verb measure analyse: an R-Test or a volumetric grid to errors of the chain, a mandrel to displacements, heights
// of a table to its deformation, an ISO 230-3 record to its table.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/file.h"
#include "core/text.h"
#include "metrology/mandrel/mandrel.h"
#include "metrology/rtest/analysis.h"
#include "metrology/rtest/grid.h"
#include "metrology/rtest/result_folder.h"
#include "metrology/rtest/tool_places.h"
#include "metrology/surface/surface.h"
#include "tools/measure/analysis_json.h"
#include "tools/measure/estimate_plots.h"
#include "tools/measure/estimate_words.h"
#include "tools/measure/json_number.h"
#include "tools/measure/measure.h"
#include "tools/measure/record_words.h"
#include "tools/measure/thermal_tests.h"

namespace thermotwin::tools {
namespace {

using metrology::Estimates;
using metrology::RTestAnalysis;
using metrology::RTestRecord;
using nlohmann::json;

constexpr const char* alone_words =
    "one cycle: there is none to compare it with; the errors are absolute, as with reference = \"absolute\"\n";

std::optional<compensation::Measurement> beside_of(const MeasureOptions& options) {
  if (options.record.empty()) return std::nullopt;
  return compensation::read_measurement(options.record);
}

/// The files that all records have in common, and the summary.
void write_estimates(const MeasureOptions& options, const Estimates& estimates,
                     const compensation::Measurement& measurement, const std::string& table, const std::string& picture,
                     json result, std::string text) {
  warn_of_other_results(options, table + ".csv");
  core::write_csv(options.out / (table + ".csv"), metrology::error_table(estimates));
  if (!picture.empty()) core::write_file(options.out / (table + ".svg"), picture);
  if (!measurement.channels.empty()) {
    compensation::write_measurement(options.out / "measurement", measurement);
    result["measurement"] = (options.out / "measurement").string();
  }
  core::write_file(options.out / "analysis.json", result.dump(1) + "\n");
  text += fmt::format("{} cycle{}; in {}", estimates.cycles.size(), estimates.cycles.size() == 1 ? "" : "s",
                      (options.out / (table + ".csv")).string());
  if (!measurement.channels.empty())
    text += fmt::format(", a folder for evaluate and diagnose in {}", (options.out / "measurement").string());
  print_summary(options, text + "\n", result.dump());
}

/// An R-Test or a volumetric grid.
void analyse_points(const MeasureOptions& options, const RTestRecord& record, bool grid) {
  const RTestAnalysis analysis = metrology::analyse(record);
  const std::string channels = !options.channels.empty() ? options.channels : grid ? "points" : "errors";
  const auto beside = beside_of(options);
  const metrology::TestPoints points =
      channels == "points" ? metrology::TestPoints() : metrology::common_points(record, analysis);
  const compensation::Measurement measurement = channels == "points"
                                                    ? metrology::points_measurement_of(record, beside)
                                                    : metrology::measurement_of(record, analysis, points, beside);
  json result = json_of(analysis);
  result["residual_over_std"] = number_or_null(metrology::residual_test(analysis, record.std).ratio);
  if (!grid) {
    if (const json arcs = arcs_json(record); !arcs.empty()) result["arcs"] = arcs;
  }
  const core::Table residuals = metrology::residual_table(record, analysis);
  core::write_csv(options.out / "residuals.csv", residuals);
  if (grid) core::write_file(options.out / "residuals.svg", residual_picture(residuals));
  std::string text = text_of(analysis) + residual_words(analysis, record.std);
  text += drift_words(record, analysis) + (record.alone ? alone_words : "");
  if (record.calibration) text += calibration_words(*record.calibration, result);
  if (!grid) text += arcs_words(record) + places_words(record, result);
  if (grid || metrology::has_linear_positions(record)) text += tool_words(record, result);
  if (channels == "errors") text += points_words(points);
  write_estimates(options, analysis, measurement, grid ? "errors" : "location_errors",
                  over_time(analysis, grid ? "errors of the chain" : "location errors"), result, text);
}

void analyse_mandrel(const MeasureOptions& options) {
  const metrology::MandrelRecord record = metrology::MandrelRecord::load(options.file);
  const Estimates estimates = metrology::analyse(record);
  const compensation::Measurement measurement =
      metrology::measurement_of(estimates, record.pose, record.against_first, beside_of(options));
  const metrology::ResidualTest test = metrology::residual_test(record, estimates);
  json result = json_of(estimates);
  result["residual_over_std"] = number_or_null(test.ratio);
  write_estimates(options, estimates, measurement, "displacements",
                  over_time(estimates, "displacement and rotation of the tool"), std::move(result),
                  text_of(estimates) + misfit_words(test) + (record.alone ? alone_words : ""));
}

void analyse_surface(const MeasureOptions& options) {
  constexpr int map_steps = 20;
  const metrology::SurfaceRecord record = metrology::SurfaceRecord::load(options.file);
  const Estimates estimates = metrology::analyse(record);
  const compensation::Measurement measurement =
      metrology::measurement_of(estimates, record.pose, record.against_first, beside_of(options));
  const core::Table map = metrology::surface_map(record, estimates, map_steps),
                    points = metrology::surface_points(record, estimates);
  core::write_csv(options.out / "map.csv", map);
  core::write_file(options.out / "map.svg", surface_picture(map, points));
  core::write_csv(options.out / "residuals.csv", points);
  write_estimates(options, estimates, measurement, "modes", over_time(estimates, "modes of the table's surface"),
                  json_of(estimates),
                  text_of(estimates) + residual_words(estimates, record.std) + (record.alone ? alone_words : ""));
}

}  // namespace

void measure_analyse(const MeasureOptions& options) {
  if (!options.others.empty()) return analyse_thermal_tests(options);
  const auto has = [&](const char* name) { return std::filesystem::exists(options.file / name); };
  const std::vector<std::string> kinds{"rtest.toml", "grid.toml", "mandrel.toml", "surface.toml", "channels.toml"};
  std::vector<std::string> found;
  for (const std::string& kind : kinds)
    if (has(kind.c_str())) found.push_back(kind);
  if (found.size() != 1) {
    throw core::InputError(options.file.string(), found.empty() ? "none of " + core::join(kinds) : core::join(found),
                           "a folder with one of " + core::join(kinds) +
                               ": an R-Test, a volumetric grid, a mandrel, a table's surface, or a measurement folder "
                               "of an ISO 230-3 test");
  }
  const std::string& kind = found.front();
  if (kind != "channels.toml" && !options.ambient.empty())
    throw core::UsageError("--ambient belongs to a measurement folder; " + kind + " has no gradients per K");
  if (kind == "channels.toml" && !options.record.empty())
    throw core::UsageError("--record belongs to points or readings; a measurement folder has its own loads");
  if (kind != "rtest.toml" && kind != "grid.toml" && !options.channels.empty())
    throw core::UsageError("--channels belongs to an R-Test or a volumetric grid, not to " + kind);
  if (kind == "rtest.toml") {
    analyse_points(options, RTestRecord::load(options.file), false);
  } else if (kind == "grid.toml") {
    analyse_points(options, metrology::load_grid(options.file), true);
  } else if (kind == "mandrel.toml") {
    analyse_mandrel(options);
  } else if (kind == "surface.toml") {
    analyse_surface(options);
  } else {
    analyse_thermal(options);
  }
}

}  // namespace thermotwin::tools
