// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Raw signals of probes. raw.csv: time_s, `point` (the row of points.csv from 1; blank between points) and a column for
// each probe, `<probe>_um`. calibration.csv: the displacement of the sphere against the probes, x_mm, y_mm, z_mm, and
// the same columns. A point is the mean of its samples, without the first and last cut_s of a record.

#include <Eigen/Core>

#include <filesystem>
#include <vector>

#include "core/table.h"
#include "metrology/probe/calibration_check.h"
#include "metrology/probe/probe_setup.h"

namespace thermotwin::metrology {

struct RawSignals {
  core::Table raw, calibration;
  /// @throws InputError for a missing file
  static RawSignals load(const std::filesystem::path& folder);
};

/// @param points  as many as points.csv has @return displacement of the sphere against the probes at each, m, in the
///   frame of what carries the probes
/// @throws InputError: a clock that runs back, a point without a sample or an unknown one, a missing reading, probes
///   that are not those of the calibration
/// @param check  filled where given
std::vector<Eigen::Vector3d> sphere_displacements(const RawSignals& signals, const ProbeSetup& setup,
                                                  Eigen::Index points, CalibrationCheck* check = nullptr);

}  // namespace thermotwin::metrology
