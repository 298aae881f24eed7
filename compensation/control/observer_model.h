// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Fills the data of the online core's observer (observer.h) from a reduced model of capacity 1.

#include <cstdint>
#include <vector>

#include "compensation/control/day_model.h"
#include "compensation/control/observer.h"
#include "compensation/control/sensor_model.h"
#include "compensation/online/compensator.h"
#include "solver/operation/operating_model.h"

namespace thermotwin::compensation {

class ObserverModel {
public:
  /// @param model, operating  may be gone afterwards  @param options  steps and start  @param rank_tolerance  of terms
  /// @throws InputError if the capacity is not 1
  ObserverModel(const reduction::ReducedModel& model, const solver::OperatingModel& operating,
                const CompensatorOptions& options, double rank_tolerance = 1e-14);
  ObserverModel(const ObserverModel&) = delete;
  ObserverModel& operator=(const ObserverModel&) = delete;

  /// @return valid as long as this
  const tt_observer_model& data() const { return data_; }
  const SensorModel& sensors() const { return sensors_; }
  DayModel& day() { return day_; }
  /// @return the observer's drives among those of the day of work: those that heat
  const std::vector<std::int32_t>& drives() const { return drives_; }

private:
  void add_readings(const mesh::Machine& machine, const solver::Channels& channels);

  std::vector<std::int32_t> drives_;
  SensorModel sensors_;
  DayModel day_;
  std::vector<double> default_, offset_;
  std::vector<std::int32_t> temperature_, is_ambient_, own_ambient_, ambient_channel_;
  tt_reading_model readings_{};
  tt_observer_model data_{};
};

}  // namespace thermotwin::compensation
