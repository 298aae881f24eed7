// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/measure/record_words.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/progress.h"
#include "core/text.h"
#include "core/units.h"
#include "metrology/rtest/continuous.h"
#include "metrology/rtest/sphere_places.h"
#include "metrology/rtest/tool_places.h"

namespace thermotwin::tools {

using metrology::RTestAnalysis;
using metrology::RTestRecord;
using nlohmann::json;
namespace units = core::units;

namespace {

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

}  // namespace

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

std::string places_words(const RTestRecord& record, json& result) {
  const metrology::SpherePlaces places = metrology::sphere_places(record);
  result["places_on_table"] = places.count;
  if (!places.doubt.empty()) core::warn(places.doubt);
  return fmt::format("the points mean {}{} place{} of the sphere on the table\n", places.count,
                     places.is_cut ? " or more" : "", places.count == 1 ? "" : "s");
}

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

}  // namespace thermotwin::tools
