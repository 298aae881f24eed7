// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/error_states.h"

namespace thermotwin::compensation {
namespace {

ErrorModel::State named(std::string name, const char* unit) {
  ErrorModel::State state;
  state.name = std::move(name);
  state.unit = unit;
  return state;
}

}  // namespace

ErrorModel::State start_state(Eigen::Index mode) {
  return mode == 0 ? named("start, uniform", "K") : named("start, pattern " + std::to_string(mode), "1");
}

ErrorModel::State sensor_offset_state(const mesh::Machine& machine, Eigen::Index sensor) {
  return named("offset of sensor " + machine.sensors[sensor].id, "K");
}

ErrorModel::State output_state(Eigen::Index output) {
  const std::string axis(1, "xyz"[output % 3]);
  if (output >= 6) return named("rest along " + axis, "m");
  return named((output < 3 ? "motion of the tool side along " : "motion of the table side along ") + axis, "1");
}

ErrorModel::State unrecorded_state(const std::string& drive) { return named("unrecorded heat of " + drive, "1"); }

}  // namespace thermotwin::compensation
