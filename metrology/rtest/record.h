// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The points of an R-Test: cycles of points, each at positions of the axes, with the deviation of the tool against the
// workpiece. A folder has rtest.toml (docs/reference/rtest.md) and points.csv: time_s, cycle, positions X_mm, B_deg,
// the nominal centre of the sphere x_mm, y_mm, z_mm in the machine frame at these positions, and the deviation dx_um,
// dy_um, dz_um = tool - workpiece in the machine frame. A sphere on the table that is probed from the spindle moves by
// the negative of it.

#include <Eigen/Core>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/table.h"
#include "mesh/machine/kinematic_chain.h"
#include "metrology/probe/raw_signals.h"

namespace thermotwin::metrology {

struct RTestPoint {
  double time = 0;                                      ///< s
  std::map<std::string, double> positions;              ///< m and rad by axis
  Eigen::Vector3d nominal = Eigen::Vector3d::Zero();    ///< m, machine frame
  Eigen::Vector3d deviation = Eigen::Vector3d::Zero();  ///< m, tool - workpiece, machine frame
};

struct RTestCycle {
  std::string place;  ///< "points.csv cycle 3"
  std::vector<RTestPoint> points;
  double first_time() const { return points.front().time; }
  double last_time() const { return points.back().time; }
};

struct RTestRecord {
  std::string source;  ///< rtest.toml
  mesh::KinematicChain chain;
  std::vector<std::string> errors;
  bool errors_stated = false;         ///< in the file, else those of the axes that move
  std::vector<std::string> left_out;  ///< with errors that are not stated: ErrorChoice::left_out
  double table_radius = 0.3;          ///< m
  double std = 0;                     ///< m, of one coordinate
  bool against_first = true, drift = true;
  bool alone = false;  ///< one cycle: against the nominal chain, whatever the file says
  int harmonics = 0;
  bool table_shift = true;  ///< a shift of the table's surface is estimated beside the errors, see analysis.h
  std::vector<RTestCycle> cycles;
  std::optional<CalibrationCheck> calibration;  ///< of the probes, where their signals are read

  /// @throws InputError: an unknown axis, error or column, a missing value, time or cycles that run back, no points
  static RTestRecord load(const std::filesystem::path& folder);
  /// @param signals  of the probes; nullptr: the points have deviations
  static RTestRecord parse(const std::string& toml, const core::Table& points, const std::string& source,
                           const RawSignals* signals = nullptr);

  /// Ids of the rotary axes that the points move, from the bed outwards, the workpiece's before the tool's.
  std::vector<std::string> moved_axes() const;
};

/// Deviations from the probes: the sphere moves with the tool or, where the probes are in the spindle, against it.
/// @param displacements  of the sphere against the probes, all points in order, m, in the probes' frame
void take_displacements(RTestRecord& record, const ProbeSetup& setup,
                        const std::vector<Eigen::Vector3d>& displacements);

/// Location errors (ISO 230-7, and T for the table) that a test with these axes is for: two shifts and two rotations
/// each; of the outermost one on the workpiece's side all shifts (along it that of the table), all rotations, and R0T
/// where it carries the table. 000, 4.1.2 has R0T and Z0T beside the standard's.
std::vector<std::string> usual_errors(const mesh::KinematicChain& chain, const std::vector<std::string>& moved);

}  // namespace thermotwin::metrology
