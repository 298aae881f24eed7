// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A kinematic chain in the notation of ISO 10791-1, "V [w C' B' b Y X Z (C1) t]", from the workpiece w over the bed b
// to the tool t. Axes before b carry the workpiece, axes after it the tool. An axis in round brackets is a spindle and
// positions nothing. The first letter is optional and gives the spindle's direction, vertical (V) or horizontal (H).

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
  /// Direction in which the axis moves its body, along or about X, Y or Z. A workpiece moves against the letter
  /// (ISO 841), a tool with it.
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< m, point on a rotary axis with all axes at 0
};

struct KinematicChain {
  std::vector<ChainAxis> table;  ///< from the bed to the workpiece
  std::vector<ChainAxis> tool;   ///< from the bed to the tool

  /// @throws InputError (place) naming the fault and what is allowed
  static KinematicChain parse(const std::string& text, const std::string& place);

  /// @return the axis, or nullptr
  ChainAxis* find(const std::string& id);
  const ChainAxis* find(const std::string& id) const;
  /// @return linear axes, then rotary ones, each in the order of the chain from the workpiece
  std::vector<std::string> ids() const;

  /// @return the transformation from the home frame of the body that this axis moves to the machine's frame
  /// @param moved  -1: the bed  @param positions  m and rad by id; absent: 0
  static Eigen::Isometry3d frame(const std::vector<ChainAxis>& branch, Eigen::Index moved,
                                 const std::map<std::string, double>& positions);
};

}  // namespace thermotwin::mesh
