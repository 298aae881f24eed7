// SPDX-License-Identifier: GPL-3.0-or-later
// The verb measure analyse: an R-Test or a volumetric grid to errors of the chain, a mandrel to displacements, heights
// of a table to its deformation, an ISO 230-3 record to its table.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "core/text.h"
#include "core/units.h"
#include "metrology/mandrel/mandrel.h"
#include "metrology/rtest/analysis.h"
#include "metrology/rtest/continuous.h"
#include "metrology/rtest/grid.h"
#include "metrology/rtest/result_folder.h"
#include "metrology/rtest/sphere_places.h"
#include "metrology/rtest/tool_places.h"
#include "metrology/surface/surface.h"
#include "tools/measure/estimate_plots.h"
#include "tools/measure/json_number.h"
#include "tools/measure/measure.h"
#include "tools/measure/thermal_tests.h"

namespace thermotwin::tools {
namespace {

using metrology::CycleResult;
using metrology::Estimates;
using metrology::RTestAnalysis;
using metrology::RTestRecord;
using nlohmann::json;
using Rows = std::vector<std::vector<std::string>>;
namespace units = core::units;

constexpr std::size_t most_rows = 12;  ///< of cycles on the terminal

json in_um(const Eigen::Vector3d& value) {
  return {number_or_null(value[0] / units::um), number_or_null(value[1] / units::um),
          number_or_null(value[2] / units::um)};
}

json json_of(const RTestAnalysis& analysis) {
  json cycles = json::array();
  for (const CycleResult& cycle : analysis.cycles) {
    json errors = json::object(), harmonics = json::array(), covariance = json::array();
    for (std::size_t e = 0; e < analysis.errors.size(); ++e) {
      errors[analysis.errors[e]] = {{"value", number_or_null(cycle.value[e] / units::um)},
                                    {"std", number_or_null(cycle.std[e] / units::um)},
                                    {"unit", analysis.units[e]}};
      json row = json::array();
      for (const double value : cycle.covariance.row(e)) row.push_back(number_or_null(value / units::um / units::um));
      covariance.push_back(row);
    }
    for (const metrology::Harmonic& harmonic : cycle.harmonics)
      harmonics.push_back(
          {{"order", harmonic.order}, {"cos_um", in_um(harmonic.cosine)}, {"sin_um", in_um(harmonic.sine)}});
    cycles.push_back({{"time_s", cycle.time},
                      {"errors", errors},
                      {"covariance", covariance},
                      {"drift_um", cycle.drift_estimated ? in_um(cycle.drift) : json(nullptr)},
                      {"harmonics", harmonics},
                      {"residual_rms_um", cycle.residual_rms / units::um},
                      {"rank", cycle.rank},
                      {"parameters", cycle.parameters}});
  }
  return {{"errors", analysis.errors},
          {"not_observable", analysis.not_observable},
          {"not_estimated", analysis.not_estimated},
          {"cycles", cycles}};
}

json arcs_json(const RTestRecord& record) {
  json methods = json::object();
  if (!metrology::is_continuous(record)) return methods;
  const std::pair<const char*, metrology::CircleMethod> all[] = {{"kasa", metrology::CircleMethod::kasa},
                                                                 {"taubin", metrology::CircleMethod::taubin},
                                                                 {"geometric", metrology::CircleMethod::geometric}};
  for (const auto& [name, method] : all) {
    json fits = json::array();
    for (const metrology::ArcFit& fit : metrology::fit_cycles(record, method)) {
      fits.push_back({{"centre_um", {fit.centre[0] / units::um, fit.centre[1] / units::um}},
                      {"tilt_um_per_m", {fit.tilt[0] / units::um, fit.tilt[1] / units::um}},
                      {"along_um", fit.along / units::um},
                      {"radius_mm", fit.radius / units::mm},
                      {"rms_circle_um", fit.rms_circle / units::um},
                      {"rms_plane_um", fit.rms_plane / units::um},
                      {"span_deg", fit.span / units::deg}});
    }
    methods[name] = fits;
  }
  const metrology::ArcNames of = metrology::arc_names(record);
  methods["names"] = {of.centre[0], of.centre[1], of.tilt[0], of.tilt[1]};
  return methods;
}

/// The geometric circle of the last cycle, and its change from the first one.
std::string arcs_words(const RTestRecord& record) {
  if (!metrology::is_continuous(record)) return "";
  const metrology::ArcNames of = metrology::arc_names(record);
  const std::vector<metrology::ArcFit> fits = metrology::fit_cycles(record, metrology::CircleMethod::geometric);
  const auto words = [&](const Eigen::Vector2d& centre, const Eigen::Vector2d& tilt) {
    return fmt::format("{} {:.2f} um, {} {:.2f} um, {} {:.2f} um/m, {} {:.2f} um/m", of.centre[0],
                       centre[0] / units::um, of.centre[1], centre[1] / units::um, of.tilt[0], tilt[0] / units::um,
                       of.tilt[1], tilt[1] / units::um);
  };
  const metrology::ArcFit &first = fits.front(), &last = fits.back();
  std::string text = fmt::format("circle and plane of cycle {}: {}; radius {:.4f} mm, arc of {:.1f} deg\n", fits.size(),
                                 words(last.centre, last.tilt), last.radius / units::mm, last.span / units::deg);
  if (fits.size() > 1)
    text += fmt::format("  less those of cycle 1: {}\n", words(last.centre - first.centre, last.tilt - first.tilt));
  return text;
}

constexpr std::size_t most_columns = 8;  ///< errors beside each other on the terminal

/// The last cycle of many errors, one a row.
Rows last_rows(const Estimates& estimates) {
  Rows rows{{"error", "unit", "last cycle", "U (k = 2)", "range"}};
  for (std::size_t e = 0; e < estimates.errors.size(); ++e) {
    const auto at = e;
    double low = 1e300, high = -1e300;
    for (const CycleResult& cycle : estimates.cycles) {
      low = std::min(low, cycle.value[at] / units::um);
      high = std::max(high, cycle.value[at] / units::um);
    }
    const CycleResult& last = estimates.cycles.back();
    rows.push_back({estimates.errors[e], estimates.units[e]});
    if (std::isnan(last.value[at])) {
      rows.back().insert(rows.back().end(), {"-", "-", "-"});
    } else {
      rows.back().insert(rows.back().end(),
                         {fmt::format("{:.2f}", last.value[at] / units::um),
                          fmt::format("{:.2f}", 2.0 * last.std[at] / units::um), fmt::format("{:.2f}", high - low)});
    }
  }
  return rows;
}

/// (errors) of all cycles.
Eigen::VectorXd largest_std(const Estimates& estimates) {
  Eigen::VectorXd largest = estimates.cycles.back().std;
  for (const CycleResult& cycle : estimates.cycles)
    for (Eigen::Index e = 0; e < largest.size(); ++e)
      if (!(largest[e] >= cycle.std[e])) largest[e] = cycle.std[e];
  return largest;
}

/// Where the cycles differ in U, the table has the largest. The first one is 0 where it is the reference.
std::string expanded_words(const Estimates& estimates) {
  constexpr double alike = 0.05;
  const Eigen::VectorXd largest = largest_std(estimates);
  for (std::size_t i = 1; i < estimates.cycles.size(); ++i) {
    for (Eigen::Index e = 0; e < largest.size(); ++e) {
      if (estimates.cycles[i].std[e] < (1.0 - alike) * largest[e])
        return "U differs between cycles: the table has the largest, the file of the errors that of each\n";
    }
  }
  return "";
}

/// Some cycles, one a row.
Rows cycle_rows(const Estimates& estimates) {
  Rows rows{{"cycle", "time s"}};
  for (std::size_t e = 0; e < estimates.errors.size(); ++e)
    rows[0].push_back(estimates.errors[e] + " " + estimates.units[e]);
  rows[0].insert(rows[0].end(), {"drift um", "residual um"});
  const std::size_t count = estimates.cycles.size(), step = (count + most_rows - 1) / most_rows;
  for (std::size_t i = 0; i < count; i = i + 1 == count ? count : std::min(i + step, count - 1)) {
    const CycleResult& cycle = estimates.cycles[i];
    std::vector<std::string> row{fmt::format("{}", i + 1), fmt::format("{:.6g}", cycle.time)};
    for (std::size_t e = 0; e < estimates.errors.size(); ++e)
      row.push_back(std::isnan(cycle.value[e]) ? "-" : fmt::format("{:.2f}", cycle.value[e] / units::um));
    row.push_back(cycle.drift_estimated ? fmt::format("{:.2f}", cycle.drift.norm() / units::um) : "-");
    row.push_back(fmt::format("{:.2f}", cycle.residual_rms / units::um));
    rows.push_back(row);
  }
  std::vector<std::string> expanded{"U (k = 2)", ""};
  for (const double std : largest_std(estimates))
    expanded.push_back(std::isnan(std) ? "-" : fmt::format("{:.2f}", 2.0 * std / units::um));
  expanded.insert(expanded.end(), {"", ""});
  rows.push_back(expanded);
  return rows;
}

std::string text_of(const Estimates& estimates) {
  const bool many = estimates.errors.size() > most_columns;
  std::string text = core::format_table(many ? last_rows(estimates) : cycle_rows(estimates));
  if (!many) text += expanded_words(estimates);
  for (const std::string& words : estimates.not_observable) text += words + "\n";
  if (!estimates.not_estimated.empty()) {
    text +=
        fmt::format("assumed 0, because the points do not distinguish them: {}; `errors` in the file chooses others\n",
                    core::join(estimates.not_estimated, "; "));
  }
  return text;
}

/// The residual of all cycles by a chi-square test: what is above the stated uncertainty comes from errors that are
/// not estimated, or the stated uncertainty is too small.
std::string residual_words(const Estimates& estimates, double std) {
  const metrology::ResidualTest test = metrology::residual_test(estimates, std);
  if (!test.exceeds) return "";
  return fmt::format(
      "residuals of {:.3g} um are {:.3g} times the stated uncertainty ({} degrees of freedom; by chance in less than "
      "0.1 %): the points show errors that are not estimated, or std_um is too small, so U is too small\n",
      test.ratio * std / units::um, test.ratio, test.degrees);
}

/// The same of probes around a mandrel, whose stated uncertainties may differ.
std::string misfit_words(const metrology::ResidualTest& test) {
  if (!test.exceeds) return "";
  return fmt::format(
      "residuals are {:.3g} times the stated uncertainties of the probes ({} degrees of freedom; "
      "by chance in less than 0.1 %): a probe is off, quantities are missing, or std_um is too small, so U is too "
      "small\n",
      test.ratio, test.degrees);
}

/// Cycles as numbers: "1, 3 to 5".
std::string numbers_of(const std::vector<std::size_t>& cycles) {
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < cycles.size();) {
    std::size_t last = i;
    while (last + 1 < cycles.size() && cycles[last + 1] == cycles[last] + 1) ++last;
    parts.push_back(last == i ? fmt::format("{}", cycles[i]) : fmt::format("{} to {}", cycles[i], cycles[last]));
    i = last + 1;
  }
  return core::join(parts);
}

/// Cycles without a repeated point, and what their drift does.
std::string drift_words(const RTestRecord& record, const RTestAnalysis& analysis) {
  std::vector<std::size_t> without;
  double squares = 0.0;
  for (std::size_t i = 0; i < analysis.cycles.size(); ++i) {
    squares += analysis.cycles[i].drift.squaredNorm();
    if (!analysis.cycles[i].drift_estimated) without.push_back(i + 1);
  }
  if (!record.drift || without.empty()) return "";
  const std::size_t count = analysis.cycles.size(), known = count - without.size();
  if (known == 0) return "no cycle repeats a point: drift during a cycle is neither corrected nor in U\n";
  const bool one = without.size() == 1;
  std::string text = fmt::format(
      "{} {} of {} {} no point: drift is not corrected there, and U has that of the other cycles, {:.3g} um rms\n",
      one ? "cycle" : "cycles", numbers_of(without), count, one ? "repeats" : "repeat",
      std::sqrt(squares / (1.0 * known)) / units::um);
  if (record.against_first && without.front() == 1)
    text += "cycle 1 is the reference: its drift is in the errors of all cycles, and in their U\n";
  return text;
}

constexpr const char* alone_words =
    "one cycle: there is none to compare it with; the errors are absolute, as with reference = \"absolute\"\n";

/// What the channels of location errors know of the points.
std::string points_words(const metrology::TestPoints& points) {
  if (points.too_many) {
    return fmt::format("a cycle has more than {} points: the channels of the folder do not state them\n",
                       metrology::most_functional_rows / 3);
  }
  if (points.empty()) {
    return "the cycles have no points in common: the channels of the folder do not state them, and a diagnosis with a "
           "machine needs --channels points\n";
  }
  const auto other = std::count(points.of_cycles.begin(), points.of_cycles.end(), false);
  if (other == 0) return "";
  return fmt::format("{} of {} cycles have other points than most: they are blank in the folder\n", other,
                     points.of_cycles.size());
}

std::optional<compensation::Measurement> beside_of(const MeasureOptions& options) {
  if (options.record.empty()) return std::nullopt;
  return compensation::read_measurement(options.record);
}

/// Where on the table the points are, with a warning where they contradict the positions of the axes.
std::string places_words(const RTestRecord& record, json& result) {
  const metrology::SpherePlaces places = metrology::sphere_places(record);
  result["places_on_table"] = places.count;
  if (!places.doubt.empty()) core::warn(places.doubt);
  return fmt::format("the points mean {}{} place{} of the sphere on the table\n", places.count,
                     places.is_cut ? " or more" : "", places.count == 1 ? "" : "s");
}

/// The tool point that the points of a grid mean, with a warning where they contradict the positions of the axes.
std::string tool_words(const RTestRecord& record, json& result) {
  const metrology::ToolPlaces places = metrology::tool_places(record);
  result["places_of_tool"] = places.count;
  if (!places.doubt.empty()) core::warn(places.doubt);
  const Eigen::Vector3d at = (places.first / units::um).array().round() * 1e-3;
  const std::string first = fmt::format("{:g}, {:g}, {:g} mm", at.x() + 0.0, at.y() + 0.0, at.z() + 0.0);
  if (places.count == 1) return fmt::format("the points mean a tool point at {} with all axes at 0\n", first);
  return fmt::format("the points mean {}{} tool points with all axes at 0, the first at {}\n", places.count,
                     places.is_cut ? " or more" : "", first);
}

std::string calibration_words(const metrology::CalibrationCheck& check, json& result) {
  result["calibration"] = {{"misfit_um", check.misfit / units::um},
                           {"expected_um", check.expected / units::um},
                           {"gains", {check.least_gain, check.most_gain}}};
  if (!check.doubt.empty()) core::warn(check.doubt);
  return fmt::format(
      "calibration: misfit {:.2g} um, by the stated noise {:.2g} um; probes read {:.3f} to {:.3f} um per um\n",
      check.misfit / units::um, check.expected / units::um, check.least_gain, check.most_gain);
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
