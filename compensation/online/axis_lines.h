// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What the offsets of one moment are for controls that take a straight line for each axis, or tables along each axis.
//
// A line for axis a, exact at the present position p of the axis, all other axes where they are:
//   offset_a(s) = offset_a(p) + slope (s - p),
// its slope by least squares over positions s spread evenly over the workspace. Two figures state what it leaves: the
// largest difference along the axis, and the largest over all poses of the workspace, where the other axes, linear and
// rotary, move too and the line of axis a does not know it. A rotary axis without ends takes quarters of a turn.
//
// A table for axis a holds the component errors of ISO 230-1 (E_XX, E_YX, E_ZX, E_AX, E_BX, E_CX of X): the error of
// the tool against the table at positions of the axis, all others in the middle of the workspace (a rotary one without
// ends at 0), minus the error at the middle. Rotations are those of the tool against the table.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "compensation/online/online_model.h"
#include "compensation/online/output_map.h"
#include "mesh/machine/machine.h"

namespace thermotwin::compensation {

struct AxisLine {
  double reference = 0;       ///< m, present position of the axis
  double offset_um = 0;       ///< there, as the guard gives it
  double slope_um_m = 0;      ///< um per m
  double left_travel_um = 0;  ///< largest difference along the axis
  double left_across_um = 0;  ///< largest difference over the workspace
};

/// @param map  of its reduced model  @param machine  likewise  @param offset_um  (linear axes) of the last row
/// @return the lines of the linear axes, in the order of its axes()
std::vector<AxisLine> axis_lines(const OnlineModel& model, const OutputMap& map, const mesh::Machine& machine,
                                 const Eigen::VectorXd& offset_um);

/// Component errors along one linear axis.
struct AxisErrors {
  std::string axis;
  Eigen::VectorXd position;  ///< (positions) m
  Eigen::MatrixXd errors;    ///< (6 x positions) dx dy dz um, ra rb rc um/m, along the axes of machine.toml
  int along = 0;             ///< 0 x, 1 y, 2 z of machine.toml: direction in which it moves most
};

/// Where a rotary axis stands for the tables, and between which positions they are judged, rad.
struct RotaryRange {
  std::string axis;
  double middle = 0, low = 0, high = 0;
};

struct ErrorTables {
  std::vector<AxisErrors> axes;
  std::vector<RotaryRange> rotary;
  Eigen::Matrix<double, 6, 1> at_middle;  ///< error at the middle of the workspace, um and um/m
  /// (3) um: largest difference, over the workspace, between the translations and the sum of what the tables hold
  Eigen::Vector3d left_um;
  Eigen::Vector3d left_at_rotary_middle_um;  ///< the same while the rotary axes stand in the middle
};
/// @return the tables for the present state  @param machine  of its reduced model
ErrorTables error_tables(const OnlineModel& model, const mesh::Machine& machine);

}  // namespace thermotwin::compensation
