// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A kinematic chain in the notation of ISO 10791-1, "V [w C' B' b Y X Z (C1) t]": from the workpiece
// w by way of the bed b to the tool t. Axes before b carry the workpiece, axes after it the tool;
// what stands in brackets is a spindle and positions nothing. The first letter says whether the
// spindle stands (V) or lies (H) and is optional.

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <map>
#include <string>
#include <vector>

namespace thermotwin::mesh {

struct ChainAxis {
  std::string id;  ///< "X", "B", "X1"
  bool rotary = false;
  bool table_side = false;  ///< carries the workpiece
  /// Which way the body goes that the axis moves: along, or about, X, Y or Z. A workpiece goes
  /// against the letter (ISO 841), the tool with it.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< m, point on a rotary axis with all axes at 0
};

struct KinematicChain {
  std::vector<ChainAxis> table;  ///< from the bed to the workpiece
  std::vector<ChainAxis> tool;   ///< from the bed to the tool

  /// @throws InputError (place) with what is wrong and what is allowed
  static KinematicChain parse(const std::string& text, const std::string& place);

  /// @return the axis, or nullptr
  ChainAxis* find(const std::string& id);
  const ChainAxis* find(const std::string& id) const;
  /// Linear axes, then rotary ones, in order of the chain from the workpiece.
  std::vector<std::string> ids() const;

  /// From the frame of what the axis with this index moves (its home) to the machine's frame.
  /// @param moved  -1: the bed  @param positions  m and rad by id; absent: 0
  static Eigen::Isometry3d frame(const std::vector<ChainAxis>& branch, int moved,
                                 const std::map<std::string, double>& positions);
};

}  // namespace thermotwin::mesh
