// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/day_model.h"

#include <iterator>
#include <numbers>
#include <string>

namespace thermotwin::compensation {
namespace {

constexpr double half = 0.5;
constexpr double warmer_K = 2.0;  ///< surroundings than the hall

}  // namespace

DayModel::DayModel(const mesh::Machine& machine, const solver::Channels& channels, const SensorModel& sensors) {
  const Eigen::VectorXd& defaults = channels.defaults();
  default_.assign(defaults.begin(), defaults.end());
  for (const mesh::CoolantSpec& coolant : machine.coolants)
    coolant_on_.push_back(channels.index("coolant." + coolant.id + ".on"));
  drive_channel_.push_back(channels.index("spindle.speed_rpm"));
  drive_half_speed_.push_back(half * machine.spindle_max_rpm);
  add_axes(machine, channels);
  add_warm(sensors);

  const auto count = [](const auto& values) { return static_cast<std::int32_t>(values.size()); };
  data_.sensors = &sensors.data();
  data_.channels = count(default_);
  data_.axes = count(axis_position_);
  data_.coolants = count(coolant_on_);
  data_.drives = count(drive_channel_);
  data_.warm = count(warm_quantity_);
  data_.machine_on = channels.index("machine.on");
  data_.fluid_on = channels.index("cutting_fluid.on");
  data_.channel_default = default_.data();
  data_.axis_position = axis_position_.data();
  data_.axis_low = axis_low_.data();
  data_.axis_high = axis_high_.data();
  data_.travel_low = travel_low_.data();
  data_.travel_high = travel_high_.data();
  data_.coolant_on = coolant_on_.data();
  data_.drive_channel = drive_channel_.data();
  data_.drive_half_speed = drive_half_speed_.data();
  data_.warm_quantity = warm_quantity_.data();
  data_.warm_K = warm_K_.data();
}

void DayModel::add_axes(const mesh::Machine& machine, const solver::Channels& channels) {
  for (const mesh::Axis& axis : machine.axes) {
    const bool linear = axis.kind == mesh::AxisKind::linear;
    const std::string id = "axis." + axis.id + ".", unit = linear ? "mm" : "deg";
    const double to_unit = linear ? 1e3 : 180.0 / std::numbers::pi;
    axis_position_.push_back(channels.index(id + "position_" + unit));
    axis_low_.push_back(channels.index(id + "low_" + unit));
    axis_high_.push_back(channels.index(id + "high_" + unit));
    travel_low_.push_back(axis.low * to_unit);
    travel_high_.push_back(axis.high * to_unit);
    drive_channel_.push_back(channels.index(id + "feed_" + unit + "_min"));
    drive_half_speed_.push_back(half * axis.rapid * to_unit * 60.0);
  }
}

void DayModel::add_warm(const SensorModel& sensors) {
  for (std::int32_t k = 0; k < static_cast<std::int32_t>(std::ssize(sensors.quantities())); ++k) {
    if (sensors.quantities()[k].ambient < 0) continue;
    warm_quantity_.push_back(k);
    warm_K_.push_back(warmer_K);
  }
}

}  // namespace thermotwin::compensation
