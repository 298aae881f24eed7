// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Measured temperatures that cannot be degC of this machine are taken out before anything sees them:
// - implausible: outside plausible_C of machine.toml;
// - kelvin: outside it, and 273.15 less is near the surroundings;
// - fahrenheit: at the first readings all sensors stand more than 30 K above the surroundings, and each of them
//   read as degF is within 15 K of these. They stay out until one of them reads less; the same of an ambient alone.
// Limits: the first readings of a machine whose sensors are all 30 K warm may be taken for degF; then the start is not
// theirs, and they come back as it cools. One sensor in degF among others in degC is the sensor monitor's to find.

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

  /// Sets temperatures among the channels that cannot be to NaN. @param given  (channels)
  void take_out_inputs(Eigen::VectorXd& given);
  /// The same for sensors. @param readings_C  (sensors)  @param row  (channels) as it holds: tells the surroundings
  void take_out_sensors(Eigen::VectorXd& readings_C, const Eigen::VectorXd& row);

  ReadingFault input(Eigen::Index channel) const { return input_faults_[channel]; }
  ReadingFault sensor(Eigen::Index sensor) const { return sensor_faults_[sensor]; }
  bool any_input() const;
  bool any_sensor() const;
  /// Whether the sensor's last reading would be near the surroundings if it were degF.
  bool looks_fahrenheit(Eigen::Index sensor) const { return fahrenheit_like_[sensor]; }

private:
  bool outside(double value_C) const { return !(value_C >= low_C_ && value_C <= high_C_); }
  ReadingFault fault_outside(double value_C, double surroundings_C) const;

  double low_C_, high_C_, reference_C_;
  struct Temperature {
    Eigen::Index channel;
    bool ambient;  ///< of one that has a temperature of its own
  };
  std::vector<Temperature> temperatures_;
  std::vector<int> ambients_;  ///< channels of those
  Eigen::VectorXd defaults_;
  std::vector<ReadingFault> input_faults_, sensor_faults_;
  std::vector<bool> fahrenheit_like_;
  bool started_ = false, fahrenheit_ = false;
};

}  // namespace thermotwin::compensation
