// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The data of the online core's observer, part by part, with terms of full rank.

#include "compensation/control/control_model.h"
#include "compensation/control/observer_data.h"

namespace thermotwin::compensation::test {

class ObserverParts {
public:
  /// @param drives  that have a heat of their own; -1: those that heat
  explicit ObserverParts(const reduction::ReducedModel& model, const CompensatorOptions& options = {}, int drives = -1)
      : control_(model, full_rank(options)) {
    tt_observer_data_of(&control_.model(), &data_);
    if (drives >= 0) data_.sensors.drives = drives;
  }
  ObserverParts(const ObserverParts&) = delete;
  ObserverParts& operator=(const ObserverParts&) = delete;

  const tt_sensor_model& sensors() const { return data_.sensors; }
  const tt_reading_model& readings() const { return data_.readings; }
  const tt_day_model& day() const { return data_.day; }
  const tt_observer_model& observer() const { return data_.observer; }
  void set_coefficients(void (*coefficients)(const void*, const double*, double*, double*), const void* with) {
    data_.day.coefficients = coefficients;
    data_.day.with = with;
  }

private:
  static ControlOptions full_rank(const CompensatorOptions& options) {
    ControlOptions all;
    all.compensator = options;
    all.tolerance = 1e-14;
    return all;
  }

  ControlModel control_;
  tt_observer_data data_{};
};

}  // namespace thermotwin::compensation::test
