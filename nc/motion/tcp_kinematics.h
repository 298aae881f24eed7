// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Tool centre point control: the program's point belongs to the workpiece, which the rotary axes of the table carry.
// With F the transformation of a body from home, g the tool point of machine.toml at home and l the tool offset, the
// tool's tip is at F_tool(q) (g - l). A programmed point p of the workpiece, seen with all axes at home, is at
// F_table(q) (g + p). The linear axes bring both together; their positions enter both sides linearly.

#include <Eigen/Geometry>

#include <vector>

#include "mesh/machine/machine.h"
#include "nc/motion/element.h"

namespace thermotwin::nc {

class TcpKinematics {
public:
  /// @throws InputError for a machine without [tcp], or whose linear axes do not span the space
  explicit TcpKinematics(const mesh::Machine& machine);

  /// Fills in the linear axes. @param positions  (axes) with the rotary axes  @param point  p, m
  /// @param tool  tool offset l, m
  void solve(const Eigen::Vector3d& point, const Eigen::Vector3d& tool, Positions& positions) const;

  /// @return the programmed point at which the tool's tip is
  Eigen::Vector3d point(const Positions& positions, const Eigen::Vector3d& tool) const;

private:
  struct Link {
    int axis;
    bool linear;
    Eigen::Vector3d direction, origin;
  };
  static std::vector<Link> chain_to(const mesh::Machine& machine, int body);
  static Eigen::Isometry3d frame(const std::vector<Link>& chain, const Positions& positions, bool linear);
  /// Adds to the columns what a unit of each linear axis moves the end of the chain, in the machine's frame.
  static void motions(const std::vector<Link>& chain, const Positions& positions, double sign,
                      const std::vector<int>& column, Eigen::Matrix3d& out);

  std::vector<Link> tool_, table_;
  std::vector<int> linear_;  ///< three axes
  std::vector<int> column_;  ///< (axes) place in linear_, -1
  Eigen::Vector3d gauge_;
};

}  // namespace thermotwin::nc
