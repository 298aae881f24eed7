// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Removes measured temperatures that cannot be values of this machine in degC, before they are used:
// - implausible: outside plausible_C of machine.toml;
// - kelvin: outside plausible_C, while the value minus 273.15 is 40 K below to 100 K above the surroundings;
// - fahrenheit: at the first readings all sensors are more than 30 K above the surroundings, and each of them, taken as
//   degF, is within 15 K of the surroundings. All are left out until one reads at most 30 K above the surroundings.
// An ambient is checked by itself in each row, against its default: fahrenheit if it is more than 30 K above this and,
// taken as degF, within 15 K of it.
// The surroundings of the sensors are the median of the ambients (of an even number the lower middle one).
// Limits: the first readings of a machine whose sensors are all 30 K warm may be taken for degF. They then do not
// contribute to the initial state, and count again once the machine has cooled. A single sensor in degF among others
// in degC is left to the sensor monitor.

#include <Eigen/Core>

#include <vector>

#include "mesh/machine/machine.h"
#include "solver/operation/channels.h"

namespace thermotwin::compensation {

enum class ReadingFault { none, implausible, kelvin, fahrenheit };
const char* fault_text(ReadingFault fault);

class ReadingCheck {
public:
  ReadingCheck(const mesh::Machine& machine, const solver::Channels& channels);

  /// Sets implausible temperatures among the channels to NaN. @param given  (channels)
  void take_out_inputs(Eigen::VectorXd& given);
  /// The same for sensors. @param readings_C  (sensors)  @param row  (channels) after take_out_inputs() and with last
  ///   values in place of missing ones; gives the surroundings
  void take_out_sensors(Eigen::VectorXd& readings_C, const Eigen::VectorXd& row);

  ReadingFault input(Eigen::Index channel) const { return input_faults_[channel]; }
  ReadingFault sensor(Eigen::Index sensor) const { return sensor_faults_[sensor]; }
  bool any_input() const;
  bool any_sensor() const;
  /// @return whether the sensor's last reading, taken as degF, is near the surroundings
  bool looks_fahrenheit(Eigen::Index sensor) const { return fahrenheit_like_[sensor]; }

private:
  bool outside(double value_C) const { return !(value_C >= low_C_ && value_C <= high_C_); }
  ReadingFault fault_outside(double value_C, double surroundings_C) const;

  double low_C_, high_C_, reference_C_;
  struct Temperature {
    Eigen::Index channel;
    bool ambient;  ///< of an ambient that follows no other one
  };
  std::vector<Temperature> temperatures_;
  std::vector<int> ambients_;  ///< channels of the ambients that follow no other one
  Eigen::VectorXd defaults_;
  std::vector<ReadingFault> input_faults_, sensor_faults_;
  std::vector<bool> fahrenheit_like_;
  bool started_ = false, fahrenheit_ = false;
};

}  // namespace thermotwin::compensation
