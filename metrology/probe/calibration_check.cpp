// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/probe/calibration_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/units.h"

namespace thermotwin::metrology {

using core::InputError;
using Eigen::Index;
using Eigen::Vector3d;
namespace units = core::units;

namespace {

constexpr double most_gain = 2.0, most_way = 1.5;     ///< ratios
constexpr double least_cosine = 0.5;                  ///< between a probe and its stated direction
constexpr double least_along = -0.2;                  ///< of a probe of the default arrangement along z
constexpr double most_misfit = 0.1;                   ///< of the way
constexpr double suspicious = 5.0;                    ///< misfits of what is expected
constexpr double least_zero = 5e-6, like_zero = 0.2;  ///< m; share

void require_gain(const Calibration& calibration, Index probe, const std::string& place) {
  const double gain = calibration.directions().col(probe).norm();
  if (gain <= most_gain && gain * most_gain >= 1.0) return;
  throw InputError(fmt::format("{} {}", place, calibration.names()[probe]),
                   fmt::format("a probe that reads {:.3g} um per um of displacement", gain),
                   "a gain from 0.5 to 2: displacements in mm, readings in um");
}

void require_direction(const Calibration& calibration, const ProbeSetup& setup, Index probe, const std::string& place) {
  const Vector3d found = calibration.directions().col(probe).normalized();
  const std::string at = fmt::format("{} {}", place, calibration.names()[probe]);
  const std::string measured =
      fmt::format("a probe whose direction is {:.2f}, {:.2f}, {:.2f}", found.x(), found.y(), found.z());
  if (!setup.directions_stated) {
    if (found.z() >= least_along) return;
    throw InputError(at, measured,
                     "a positive z as that of the default probes, or `directions` in [probes]; with signs reversed "
                     "all errors are");
  }
  const Eigen::VectorXd cosines = setup.directions.transpose() * found;  // columns may stand in another order
  if (cosines.maxCoeff() >= least_cosine) return;
  throw InputError(at, measured,
                   std::string("within 60 deg of one of `directions` in [probes]") +
                       (cosines.minCoeff() < -least_cosine ? ": its sign is reversed" : ""));
}

}  // namespace

void CalibrationCheck::see(const Eigen::VectorXd& reading, const std::string& source, const Calibration& calibration) {
  const Eigen::VectorXd& zero = calibration.zero();
  const double size = zero.norm();
  if (size < least_zero || !doubt.empty()) return;
  if ((reading * 1e3 - zero).norm() > like_zero * size) return;
  doubt = fmt::format(
      "{}: the readings of a point are a thousandth of those at the zero of the calibration, {:.4g} um; allowed: "
      "readings in um",
      source, size / units::um);
}

CalibrationCheck check_calibration(const Calibration& calibration, const ProbeSetup& setup, const std::string& place) {
  CalibrationCheck check;
  const Index probes = calibration.probes();
  if (setup.directions_stated && setup.directions.cols() != probes) {
    throw InputError(place, fmt::format("{} probes", probes),
                     fmt::format("the {} of `directions` in [probes]", setup.directions.cols()));
  }
  for (Index probe = 0; probe < probes; ++probe) {
    require_gain(calibration, probe, place);
    require_direction(calibration, setup, probe, place);
  }
  const double ratio = calibration.way() / setup.calibration;
  if (setup.calibration_stated && (ratio > most_way || ratio * most_way < 1.0)) {
    throw InputError(place, fmt::format("displacements up to {:.4g} mm", calibration.way() / units::mm),
                     fmt::format("calibration_mm = {:.4g} of [probes]", setup.calibration / units::mm));
  }
  const Eigen::VectorXd gains = calibration.directions().colwise().norm().transpose();
  check.least_gain = gains.minCoeff();
  check.most_gain = gains.maxCoeff();
  check.misfit = calibration.residual_rms();
  check.expected = setup.std_of_point(1.0);
  if (check.misfit > most_misfit * calibration.way()) {
    throw InputError(place, fmt::format("readings that miss the displacements by {:.3g} um", check.misfit / units::um),
                     fmt::format("at most a tenth of the way of {:.3g} mm", calibration.way() / units::mm));
  }
  if (check.misfit > suspicious * std::max(check.expected, units::um)) {
    check.doubt = fmt::format(
        "{}: the calibration misses its own displacements by {:.3g} um, and all points have this error; allowed by "
        "noise_um and repeatability_um: about {:.2g} um",
        place, check.misfit / units::um, check.expected / units::um);
  }
  return check;
}

}  // namespace thermotwin::metrology
