// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/sensor_trust.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// A constant offset is named, and no longer named, from these multiples of its stated deviation and of its own on.
constexpr double named_stated = 6.0, named_own = 5.0, unnamed = 3.0, least_stated_K = 0.03;

VectorXd stated_deviations(const reduction::ReducedModel& model) {
  VectorXd deviation = VectorXd::Constant(model.system.sensors.rows(), 1.0);
  for (Index s = 0; s < std::min(deviation.size(), std::ssize(model.machine.sensors)); ++s) {
    deviation[s] = model.machine.sensors[s].uncertainty;
  }
  return deviation;
}

void add_name(std::string& list, const std::string& name, const char* fault) {
  list += fmt::format("{}{}={}", list.empty() ? "" : " ", name, fault);
}

}  // namespace

SensorTrust::SensorTrust(const reduction::ReducedModel& model, const solver::Channels& channels)
    : machine_(model.machine),
      channels_(channels),
      check_(model.machine, channels),
      monitor_(stated_deviations(model)),
      drift_(stated_deviations(model)),
      named_faults_(model.machine.sensors.size(), ReadingFault::none),
      biased_(model.machine.sensors.size(), 0) {}

void SensorTrust::take_out_inputs(VectorXd& given) {
  check_.take_out_inputs(given);
  failed_inputs_.clear();
  if (!check_.any_input()) return;
  for (Index k = 0; k < given.size(); ++k) {
    if (check_.input(k) != ReadingFault::none)
      add_name(failed_inputs_, channels_.names()[k], fault_text(check_.input(k)));
  }
}

void SensorTrust::take_out_sensors(VectorXd& readings_C, const VectorXd& row) {
  check_.take_out_sensors(readings_C, row);
}

void SensorTrust::watch(double time, const VectorXd& reading_K, const VectorXd& expected_K, bool inputs_leapt,
                        const VectorXd& unsure_K_s) {
  bool changed = monitor_.judge(time, reading_K, expected_K, inputs_leapt, unsure_K_s);
  for (Index s = 0; s < std::ssize(named_faults_); ++s) {
    const ReadingFault fault = check_.sensor(s);
    changed = changed || fault != named_faults_[s];
    named_faults_[s] = fault;
  }
  if (changed) name_sensors();
}

/// Whether a sensor in doubt since the start has an offset by now.
bool SensorTrust::is_biased(const ErrorModel& errors, Index s) const {
  if (!errors.doubts(s)) return false;
  const ErrorModel::SensorOffset own = errors.own_offset(s);
  const double stated = std::max(machine_.sensors[s].uncertainty, least_stated_K), size = std::abs(own.value);
  return biased_[s] != 0 ? size > unnamed * std::max(stated, own.std)
                         : size > std::max(named_stated * stated, named_own * own.std);
}

void SensorTrust::watch_offsets(const ErrorModel& errors) {
  bool changed = false;
  for (Index s = 0; s < std::ssize(biased_); ++s) {
    const char biased = is_biased(errors, s) ? 1 : 0;
    changed = changed || biased != biased_[s];
    biased_[s] = biased;
  }
  if (changed) name_sensors();
}

void SensorTrust::watch_drift(double time, ErrorModel& errors) {
  watch_offsets(errors);
  const auto sensors = std::ssize(machine_.sensors);
  VectorXd value = VectorXd::Constant(sensors, solver::not_given), deviation = value;
  for (Index s = 0; s < sensors; ++s) {
    if (!trusted(s)) continue;
    const ErrorModel::SensorOffset seen = errors.offset(s);
    value[s] = seen.value;
    deviation[s] = seen.std;
  }
  if (const Index s = drift_.judge(time, value, deviation); s >= 0) {
    errors.release(s);
    name_sensors();
  }
}

/// Whether a reading is what degF makes of the expected one.
bool SensorTrust::reads_fahrenheit(Index s) const {
  const double value_C = monitor_.last_reading_K(s) + machine_.reference_C,
               expected_C = monitor_.last_expected_K(s) + machine_.reference_C;
  return check_.looks_fahrenheit(s) &&
         std::abs((value_C - 32.0) / 1.8 - expected_C) < 0.25 * std::abs(value_C - expected_C);
}

/// Why a sensor is left out; nullptr: it is not.
const char* SensorTrust::fault_of(Index s) const {
  if (check_.sensor(s) != ReadingFault::none) return fault_text(check_.sensor(s));
  if (monitor_.fault(s) == SensorFault::offset && reads_fahrenheit(s)) return fault_text(ReadingFault::fahrenheit);
  if (monitor_.fault(s) != SensorFault::none) return fault_text(monitor_.fault(s));
  if (drift_.drifts(s)) return "drift";
  return biased_[s] != 0 ? fault_text(SensorFault::offset) : nullptr;
}

void SensorTrust::name_sensors() {
  failed_sensors_.clear();
  for (Index s = 0; s < std::ssize(machine_.sensors); ++s) {
    if (const char* fault = fault_of(s); fault != nullptr) add_name(failed_sensors_, machine_.sensors[s].id, fault);
  }
}

}  // namespace thermotwin::compensation
