// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Fills the data of the online core's day of work (day_of_work.h) from a machine. The coefficients are left to the
// caller: the core evaluates its own laws, tests those of solver::OperatingModel.

#include <cstdint>
#include <vector>

#include "compensation/control/day_of_work.h"
#include "compensation/control/sensor_model.h"
#include "solver/operation/channels.h"

namespace thermotwin::compensation {

class DayModel {
public:
  /// @param sensors  of this machine, must outlive it
  DayModel(const mesh::Machine& machine, const solver::Channels& channels, const SensorModel& sensors);
  DayModel(const DayModel&) = delete;
  DayModel& operator=(const DayModel&) = delete;

  /// The law of the coefficients, see tt_day_model.
  using Coefficients = void (*)(const void* with, const double* row, double* p, double* q);
  void set_coefficients(Coefficients coefficients, const void* with) {
    data_.coefficients = coefficients;
    data_.with = with;
  }
  /// @return valid as long as this
  const tt_day_model& data() const { return data_; }

private:
  void add_axes(const mesh::Machine& machine, const solver::Channels& channels);
  void add_warm(const SensorModel& sensors);

  using Doubles = std::vector<double>;
  using Ints = std::vector<std::int32_t>;
  Doubles default_, travel_low_, travel_high_, drive_half_speed_, warm_K_;
  Ints axis_position_, axis_low_, axis_high_, coolant_on_, drive_channel_, warm_quantity_;
  tt_day_model data_{};
};

}  // namespace thermotwin::compensation
