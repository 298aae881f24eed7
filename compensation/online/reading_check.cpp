// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/reading_check.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/statistics.h"
#include "core/units.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;

constexpr double colder_K = 40.0, warmer_K = 100.0;  ///< than the surroundings: what a machine's sensor may read
constexpr double too_warm_K = 30.0,
                 near_K = 15.0;  ///< of the surroundings: degF taken for degC; what it then is in degC
constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

bool like_fahrenheit(double value_C, double surroundings_C) {
  return value_C - surroundings_C > too_warm_K && std::abs((value_C - 32.0) / 1.8 - surroundings_C) <= near_K;
}

bool any(const std::vector<ReadingFault>& faults) {
  return std::any_of(faults.begin(), faults.end(), [](ReadingFault fault) { return fault != ReadingFault::none; });
}

}  // namespace

const char* fault_text(ReadingFault fault) {
  switch (fault) {
    case ReadingFault::none: return "none";
    case ReadingFault::implausible: return "implausible";
    case ReadingFault::kelvin: return "kelvin";
    case ReadingFault::fahrenheit: return "fahrenheit";
  }
  return "";
}

ReadingCheck::ReadingCheck(const mesh::Machine& machine, const solver::Channels& channels)
    : low_C_(machine.plausible_low_C),
      high_C_(machine.plausible_high_C),
      reference_C_(machine.reference_C),
      defaults_(channels.defaults()),
      input_faults_(channels.size(), ReadingFault::none),
      sensor_faults_(machine.sensors.size(), ReadingFault::none),
      fahrenheit_like_(machine.sensors.size(), false) {
  for (const mesh::AmbientSpec& ambient : machine.ambients) {
    if (ambient.follows.empty()) ambients_.push_back(channels.index(ambient.id + ".T_C"));
  }
  for (Index k = 0; k < channels.size(); ++k) {
    const bool ambient = std::find(ambients_.begin(), ambients_.end(), k) != ambients_.end();
    if (channels.names()[k].ends_with("T_C")) temperatures_.push_back({k, ambient});
  }
}

bool ReadingCheck::any_input() const { return any(input_faults_); }
bool ReadingCheck::any_sensor() const { return any(sensor_faults_); }

ReadingFault ReadingCheck::fault_outside(double value_C, double surroundings_C) const {
  const double above_K = value_C - core::units::zero_C_in_K - surroundings_C;
  return above_K >= -colder_K && above_K <= warmer_K ? ReadingFault::kelvin : ReadingFault::implausible;
}

void ReadingCheck::take_out_inputs(Eigen::VectorXd& given) {
  for (const auto& [k, ambient] : temperatures_) {
    ReadingFault& fault = input_faults_[k];
    fault = ReadingFault::none;
    if (std::isnan(given[k])) continue;
    const double usual_C = std::isnan(defaults_[k]) ? reference_C_ : defaults_[k];
    if (outside(given[k]))
      fault = fault_outside(given[k], usual_C);
    else if (ambient && like_fahrenheit(given[k], usual_C))
      fault = ReadingFault::fahrenheit;
    if (fault != ReadingFault::none) given[k] = nothing;
  }
}

void ReadingCheck::take_out_sensors(Eigen::VectorXd& readings_C, const Eigen::VectorXd& row) {
  // Half of the ambients are below the middle one: a warm fluid among them does not count.
  std::vector<double> around;
  for (const int k : ambients_) around.push_back(row[k]);
  const auto below = (std::ssize(around) - 1) / 2;
  const double surroundings_C = around.empty() ? reference_C_ : core::nth_smallest(std::move(around), below);
  bool some = false, all_fahrenheit = true, one_less = false;
  for (Index s = 0; s < readings_C.size(); ++s) {
    const std::size_t i = s;
    sensor_faults_[i] = ReadingFault::none;
    fahrenheit_like_[i] = false;
    if (std::isnan(readings_C[s])) continue;
    if (outside(readings_C[s])) {
      sensor_faults_[i] = fault_outside(readings_C[s], surroundings_C);
      readings_C[s] = nothing;
      continue;
    }
    some = true;
    fahrenheit_like_[i] = like_fahrenheit(readings_C[s], surroundings_C);
    all_fahrenheit = all_fahrenheit && fahrenheit_like_[i];
    one_less = one_less || readings_C[s] - surroundings_C <= too_warm_K;
  }
  if (some) {
    fahrenheit_ = started_ ? fahrenheit_ && !one_less : all_fahrenheit;
    started_ = true;
  }
  if (!fahrenheit_) return;
  for (Index s = 0; s < readings_C.size(); ++s) {
    if (std::isnan(readings_C[s])) continue;
    sensor_faults_[s] = ReadingFault::fahrenheit;
    readings_C[s] = nothing;
  }
}

}  // namespace thermotwin::compensation
