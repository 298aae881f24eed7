// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Whether a calibration fits what is stated of the probes: their directions, a gain of 1, the way of the calibration
// and the noise. A calibration in another unit or with signs reversed scales or reverses all errors and leaves no
// residual in the points.

#include <Eigen/Core>

#include <string>

#include "metrology/probe/probe_setup.h"
#include "metrology/probe/probes.h"

namespace thermotwin::metrology {

struct CalibrationCheck {
  double misfit = 0;                     ///< m, of a coordinate, rms of the displacements that the calibration fits
  double expected = 0;                   ///< m, that the noise and the axes' repeatability stand for
  double least_gain = 0, most_gain = 0;  ///< of a probe, reading per displacement
  std::string doubt;                     ///< a warning; empty: none

  /// Compares the mean reading of a point with the zero of the calibration: one in mm is a thousandth of it.
  void see(const Eigen::VectorXd& reading, const std::string& source, const Calibration& calibration);
};

/// @param place  of the calibration's file
/// @throws InputError: a gain that is not between 1/2 and 2, a probe against its stated direction or, where none is
///   stated, away from the sphere; a way other than that stated; a misfit above a tenth of the way
CalibrationCheck check_calibration(const Calibration& calibration, const ProbeSetup& setup, const std::string& place);

}  // namespace thermotwin::metrology
