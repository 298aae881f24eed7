// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/measure/analysis_json.h"

#include <nlohmann/json.hpp>

#include <utility>

#include "core/units.h"
#include "metrology/rtest/continuous.h"
#include "tools/measure/json_number.h"

namespace thermotwin::tools {

using metrology::CycleResult;
using metrology::Estimates;
using metrology::RTestRecord;
using nlohmann::json;
namespace units = core::units;

namespace {

json in_um(const Eigen::Vector3d& value) {
  return {number_or_null(value[0] / units::um), number_or_null(value[1] / units::um),
          number_or_null(value[2] / units::um)};
}

}  // namespace

json json_of(const Estimates& analysis) {
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

}  // namespace thermotwin::tools
