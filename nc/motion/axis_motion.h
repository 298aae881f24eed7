// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Moves of the program as motion of the machine's axes. Under tool centre point control a move becomes lines of the
// axes that stay within 0.2 um of it, measured at the middle of each.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mesh/machine/machine.h"
#include "nc/motion/element.h"
#include "nc/motion/tcp_kinematics.h"

namespace thermotwin::nc {

class AxisMotion {
public:
  /// @param machine  must outlive this
  explicit AxisMotion(const mesh::Machine& machine);

  /// Bit mask of the program's letters that are axes of the machine.
  int axis_mask() const;
  /// Control position of the letters for machine positions, without tool centre point control.
  Nine letters_of(const Positions& positions) const;
  Positions positions_of(const Nine& values) const;

  /// Machine positions of a move's point. @param values  axes of the control with the tool offset
  Positions positions(const Nine& values, const Move& move) const;
  /// Values of the control for machine positions: the inverse of positions().
  Nine values(const Positions& positions, const Move& move, const Nine& nominal) const;

  /// The tool's tip in the workpiece, seen with all axes at home; for a machine without tool centre point control, in
  /// the axes X Y Z. @param tool_offset  m
  Eigen::Vector3d tip(const Positions& positions, const Eigen::Vector3d& tool_offset) const;

  /// Values of the control at a share of the move.
  static Nine values_at(const Move& move, double u);

  /// @param file  of the program, for messages
  /// @throws InputError (file:line) for a letter that is no axis of the machine, and beyond the travel
  void elements(const Move& move, const std::string& file, const std::shared_ptr<const Source>& source,
                const std::function<void(Element&&)>& take) const;

  const mesh::Machine& machine() const { return machine_; }
  bool has_tcp() const { return tcp_.has_value(); }

private:
  void require_axes(const Move& move, const std::string& file) const;
  void require_travel(const Element& element, const std::string& file) const;
  Element whole(const Move& move) const;

  const mesh::Machine& machine_;
  std::vector<int> letter_;  ///< (axes) of each axis, -1
  std::optional<TcpKinematics> tcp_;
};

}  // namespace thermotwin::nc
