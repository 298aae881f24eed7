// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Decides which readings and measured inputs are used. It leaves out implausible temperatures (reading_check.h), failed
// sensors (sensor_monitor.h) and drifting sensors (drift_watch.h), and names them.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "compensation/online/drift_watch.h"
#include "compensation/online/error_model.h"
#include "compensation/online/reading_check.h"
#include "compensation/online/sensor_monitor.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::compensation {

class SensorTrust {
public:
  /// @param model, channels  must outlive it
  SensorTrust(const reduction::ReducedModel& model, const solver::Channels& channels);

  /// Sets implausible temperatures to NaN. @param given  (channels)
  void take_out_inputs(Eigen::VectorXd& given);
  /// The same for sensors. @param readings_C  (sensors)  @param row  (channels) as it holds
  void take_out_sensors(Eigen::VectorXd& readings_C, const Eigen::VectorXd& row);

  /// Finds sensors that have failed, see SensorMonitor::judge.
  void watch(double time, const Eigen::VectorXd& reading_K, const Eigen::VectorXd& expected_K, bool inputs_leapt,
             const Eigen::VectorXd& unsure_K_s);
  /// Finds sensors that drift, and removes their influence from the estimate; names offsets of sensors in doubt.
  void watch_drift(double time, ErrorModel& errors);
  void explain_first(std::vector<char> explained) { monitor_.explain_first(std::move(explained)); }
  /// See SensorMonitor::correct.
  void correct(const Eigen::VectorXd& change_K) { monitor_.correct(change_K); }

  /// @return whether the last reading may correct the model
  bool trusted(Eigen::Index sensor) const { return monitor_.trusted(sensor) && !drift_.drifts(sensor); }
  bool drifts(Eigen::Index sensor) const { return drift_.drifts(sensor); }
  bool any_input_out() const { return check_.any_input(); }
  bool any_sensor_out() const { return check_.any_sensor(); }
  /// "T3=stuck T5=absent"
  const std::string& failed_sensors() const { return failed_sensors_; }
  /// "air.T_C=kelvin"
  const std::string& failed_inputs() const { return failed_inputs_; }

private:
  bool reads_fahrenheit(Eigen::Index sensor) const;
  const char* fault_of(Eigen::Index sensor) const;
  bool is_biased(const ErrorModel& errors, Eigen::Index sensor) const;
  void watch_offsets(const ErrorModel& errors);
  void name_sensors();

  const mesh::Machine& machine_;
  const solver::Channels& channels_;
  ReadingCheck check_;
  SensorMonitor monitor_;
  DriftWatch drift_;
  std::vector<ReadingFault> named_faults_;  ///< (sensors) that failed_sensors tells of
  std::vector<char> biased_;  ///< (sensors) 1: has a constant offset since the start, and is used without it
  std::string failed_sensors_, failed_inputs_;
};

}  // namespace thermotwin::compensation
