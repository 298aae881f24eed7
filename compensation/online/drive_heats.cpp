// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/drive_heats.h"

#include <iterator>
#include <numbers>

namespace thermotwin::compensation {

using Eigen::Index;
using Eigen::VectorXd;

VectorXd source_heat(const reduction::ReducedSystem& system, const solver::OperatingModel& operating,
                     const VectorXd& row) {
  const VectorXd inlet = VectorXd::Zero(std::ssize(operating.machine().coolants));
  const solver::Coefficients c = operating.coefficients(row, inlet);
  VectorXd heat = VectorXd::Zero(system.order());
  for (Index k = 0; k < std::ssize(system.layout.inputs); ++k) {
    if (system.layout.inputs[k].kind == solver::InputKind::source) heat += c.q[k] * system.inputs.col(k);
  }
  return heat;
}

VectorXd heat_at_half_speed(const reduction::ReducedSystem& system, const solver::OperatingModel& operating,
                            const DriveHeat& drive, VectorXd row) {
  if (const int on = operating.channels().index("machine.on"); on >= 0 && row[on] == 0.0)
    return VectorXd::Zero(system.order());
  row[drive.channel] = 0.0;
  const VectorXd standing = source_heat(system, operating, row);
  row[drive.channel] = drive.half_speed;
  return source_heat(system, operating, row) - standing;
}

std::vector<DriveHeat> drive_heats(const reduction::ReducedModel& model, const solver::OperatingModel& operating,
                                   const VectorXd& rest) {
  constexpr double half = 0.5;
  const VectorXd resting = source_heat(model.system, operating, rest);
  std::vector<DriveHeat> drives;
  const auto add = [&](const std::string& name, const std::string& channel, double speed) {
    DriveHeat drive{name, operating.channels().index(channel), speed, VectorXd::Zero(resting.size())};
    if (drive.channel >= 0) {
      VectorXd running = rest;
      running[drive.channel] = speed;
      drive.heat = source_heat(model.system, operating, running) - resting;
    }
    drives.push_back(std::move(drive));
  };
  add("spindle", "spindle.speed_rpm", half * model.machine.spindle_max_rpm);
  for (const mesh::Axis& axis : model.machine.axes) {
    const bool linear = axis.kind == mesh::AxisKind::linear;
    add("axis " + axis.id, "axis." + axis.id + (linear ? ".feed_mm_min" : ".feed_deg_min"),
        half * axis.rapid * (linear ? 6e4 : 180.0 / std::numbers::pi * 60.0));
  }
  return drives;
}

}  // namespace thermotwin::compensation
