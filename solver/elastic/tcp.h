// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The TCP error from its parts: error = tool side - table side, in the machine frame; offset = -error.
// The table side has two parts. The axis part is a rigid motion in the frame of the table's carrier. The own part is a
// rigid motion and a radial growth in the frame of the table. The own part turns with the table axis, and both parts
// turn with the axes that carry the table. Each part is evaluated at the point of the table that the tool touches.

#include <Eigen/Core>

#include "mesh/machine/kinematics.h"
#include "mesh/machine_mesh.h"

namespace thermotwin::solver {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Vector7 = Eigen::Matrix<double, 7, 1>;

struct TcpError {
  Vector6 error;  ///< dx dy dz in m, ra rb rc in rad
  /// The two sides, at the TCP.
  Vector6 tool, table;
};

/// @param table_axis, table_own  as OutputRows times temperature, see model.h
TcpError tcp_error(const mesh::Machine& machine, const mesh::Pose& pose, const Vector6& tool, const Vector6& table_axis,
                   const Vector7& table_own);

/// Position of the tool centre point in the machine frame, m.
Eigen::Vector3d tcp_position(const mesh::Machine& machine, const mesh::Pose& pose);

/// Columns of tcp.csv after time and pose: dx_um .. rc_um_per_m, *_tool, *_table (18).
std::vector<std::string> tcp_columns();
/// The 18 values in um and um/m.
Eigen::VectorXd tcp_values(const TcpError& error);

}  // namespace thermotwin::solver
