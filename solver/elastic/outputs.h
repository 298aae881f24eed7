// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The output functionals of OutputRows and tcp_error: which bodies and surfaces they belong to, and
// their unit functionals. The rotary table's axis is the one nearest to the table on its way to the
// ground, if that is rotary; its seat is the master side of its bearings.

#include <array>

#include "mesh/machine/kinematics.h"
#include "solver/elastic/springs.h"

namespace thermotwin::solver {

/// Bodies that the table's motion is told apart by.
struct TableFrames {
  int table = -1;    ///< Machine::tcp.table_body
  int carrier = -1;  ///< body whose frame holds the axis part; the table itself without rotary axis
  int axis = -1;     ///< index of the rotary table axis; -1: none
};
TableFrames table_frames(const mesh::Machine& machine);

/// Origin and unit direction of the axis that radial growth refers to, table's home frame.
/// Without a rotary axis: through table_point along the machine's z.
std::pair<Eigen::Vector3d, Eigen::Vector3d> growth_axis(const mesh::Machine& machine);

class TcpOutputs {
public:
  /// @throws InputError: tool or table inelastic; a rotary table without a bearing on elastic bodies
  TcpOutputs(const mesh::MachineMesh& mesh, UnitFunctionals& units);

  /// The 19 outputs: tool (6, tool body's home frame), table_axis (6), table_own (7).
  std::array<Combination, 19> combinations() const;
  const TableFrames& frames() const { return frames_; }
  /// The pose with the table axis at 0, where rows are taken.
  mesh::Pose table_at_zero(const mesh::Pose& pose) const;

private:
  TableFrames frames_;
  int tool_ = -1;
  double table_radius_ = 0;
  std::array<int, 6> tool_units_{}, seat_units_{}, table_units_{};
  int growth_unit_ = 0;
};

}  // namespace thermotwin::solver
