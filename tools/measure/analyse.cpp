// SPDX-License-Identifier: GPL-3.0-or-later
// The verb measure analyse: an R-Test to location errors, or an ISO 230-3 record to its table.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>

#include "core/error.h"
#include "core/file.h"
#include "core/text.h"
#include "core/units.h"
#include "metrology/iso230/thermal_table.h"
#include "metrology/rtest/analysis.h"
#include "metrology/rtest/continuous.h"
#include "metrology/rtest/result_folder.h"
#include "tools/measure/json_number.h"
#include "tools/measure/measure.h"

namespace thermotwin::tools {
namespace {

using metrology::CycleResult;
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
                                    {"unit", analysis.turns(e) ? "um/m" : "um"}};
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
  return {{"errors", analysis.errors}, {"not_observable", analysis.not_observable}, {"cycles", cycles}};
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
  return methods;
}

std::string text_of(const RTestRecord& record, const RTestAnalysis& analysis) {
  Rows rows{{"cycle", "time s"}};
  for (std::size_t e = 0; e < analysis.errors.size(); ++e)
    rows[0].push_back(analysis.errors[e] + (analysis.turns(e) ? " um/m" : " um"));
  rows[0].insert(rows[0].end(), {"drift um", "residual um"});
  const std::size_t count = analysis.cycles.size(), step = (count + most_rows - 1) / most_rows;
  for (std::size_t i = 0; i < count; i = i + 1 == count ? count : std::min(i + step, count - 1)) {
    const CycleResult& cycle = analysis.cycles[i];
    std::vector<std::string> row{fmt::format("{}", i + 1), fmt::format("{:.6g}", cycle.time)};
    for (std::size_t e = 0; e < analysis.errors.size(); ++e)
      row.push_back(std::isnan(cycle.value[e]) ? "-" : fmt::format("{:.2f}", cycle.value[e] / units::um));
    row.push_back(cycle.drift_estimated ? fmt::format("{:.2f}", cycle.drift.norm() / units::um) : "-");
    row.push_back(fmt::format("{:.2f}", cycle.residual_rms / units::um));
    rows.push_back(row);
  }
  std::vector<std::string> expanded{"U (k = 2)", ""};
  for (const double std : analysis.cycles.back().std)
    expanded.push_back(std::isnan(std) ? "-" : fmt::format("{:.2f}", 2.0 * std / units::um));
  expanded.insert(expanded.end(), {"", ""});
  rows.push_back(expanded);
  std::string text = core::format_table(rows);
  for (const std::string& words : analysis.not_observable) text += words + "\n";
  const bool drifts = analysis.cycles.back().drift_estimated;
  if (record.drift && !drifts) text += "no cycle repeats a point: drift during a cycle is not corrected\n";
  return text;
}

void analyse_rtest(const MeasureOptions& options) {
  const RTestRecord record = RTestRecord::load(options.file);
  const RTestAnalysis analysis = metrology::analyse(record);
  std::optional<compensation::Measurement> beside;
  if (!options.record.empty()) beside = compensation::read_measurement(options.record);
  const compensation::Measurement measurement = options.channels == "points"
                                                    ? metrology::points_measurement_of(record, beside)
                                                    : metrology::measurement_of(record, analysis, beside);
  json result = json_of(analysis);
  if (const json arcs = arcs_json(record); !arcs.empty()) result["arcs"] = arcs;
  core::write_csv(options.out / "location_errors.csv", metrology::error_table(analysis));
  compensation::write_measurement(options.out / "measurement", measurement);
  core::write_file(options.out / "analysis.json", result.dump(1) + "\n");
  result["measurement"] = (options.out / "measurement").string();
  print_summary(
      options,
      text_of(record, analysis) + fmt::format("{} cycles; location errors in {}, a folder for evaluate and "
                                              "diagnose in {}\n",
                                              analysis.cycles.size(), (options.out / "location_errors.csv").string(),
                                              (options.out / "measurement").string()),
      result.dump());
}

void analyse_thermal(const MeasureOptions& options) {
  const metrology::ThermalTable table =
      metrology::thermal_table(compensation::read_measurement(options.file), options.ambient);
  Rows rows{{"channel", "unit", "first hour", "whole test", "end", "u of a range"}};
  if (!table.ambient.empty()) rows[0].insert(rows[0].end(), {"per K", "u"});
  json json_rows = json::array();
  for (const metrology::ThermalRow& row : table.rows) {
    rows.push_back({row.channel, row.unit, fmt::format("{:.3g}", row.first_hour), fmt::format("{:.3g}", row.whole),
                    fmt::format("{:.3g}", row.last), fmt::format("{:.2g}", row.uncertainty)});
    if (!table.ambient.empty())
      rows.back().insert(rows.back().end(),
                         {fmt::format("{:.3g}", row.gradient), fmt::format("{:.2g}", row.gradient_std)});
    json_rows.push_back({{"channel", row.channel},
                         {"unit", row.unit},
                         {"count", row.count},
                         {"range_first_hour", row.first_hour},
                         {"range", row.whole},
                         {"end", row.last},
                         {"std_of_a_range", row.uncertainty},
                         {"gradient_per_K", number_or_null(row.gradient)},
                         {"gradient_std", number_or_null(row.gradient_std)}});
  }
  const json result = {{"duration_s", table.duration},
                       {"ambient", table.ambient},
                       {"ambient_range_K", table.ambient_range},
                       {"rows", json_rows}};
  core::write_file(options.out / "thermal_table.json", result.dump(1) + "\n");
  std::string text = core::format_table(rows) + fmt::format("{:.4g} h", table.duration / units::hour);
  if (!table.ambient.empty()) text += fmt::format("; {} changes by {:.3g} K", table.ambient, table.ambient_range);
  print_summary(options, text + fmt::format("; in {}\n", (options.out / "thermal_table.json").string()), result.dump());
}

}  // namespace

void measure_analyse(const MeasureOptions& options) {
  const bool rtest = std::filesystem::exists(options.file / "rtest.toml");
  if (!rtest && !std::filesystem::exists(options.file / "channels.toml")) {
    throw core::InputError(options.file.string(), "neither rtest.toml nor channels.toml",
                           "a folder with rtest.toml and points.csv, or a measurement folder of an ISO 230-3 test");
  }
  if (rtest && !options.ambient.empty())
    throw core::UsageError("--ambient belongs to a measurement folder; an R-Test has no gradients per K");
  if (!rtest && !options.record.empty())
    throw core::UsageError("--record belongs to an R-Test; a measurement folder has its own loads and temperatures");
  if (rtest) {
    analyse_rtest(options);
  } else {
    analyse_thermal(options);
  }
}

}  // namespace thermotwin::tools
