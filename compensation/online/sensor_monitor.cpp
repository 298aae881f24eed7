// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/sensor_monitor.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace thermotwin::compensation {
namespace {

using Eigen::Index;

constexpr double absent_s = 300.0, agreed_s = 1800.0;
constexpr double window_s = 900.0, window_rows = 8.0;  ///< that noise is looked for in
constexpr double memory_s = 600.0;                     ///< of the usual difference; at least four rows
constexpr double leap = 12.0, scatter = 4.0, turning = 3.5, moved = 5.0, same = 0.1;
constexpr double unsure_factor = 3.0;  ///< deviations of how fast an expected reading changes
constexpr double start_K = 1.0, start_factor = 6.0, least_deviation_K = 0.03, model_share = 0.1;
constexpr double confirm_s = 30.0;  ///< that a leap has to stay
constexpr double known_readings = 60.0, most_repeats = 0.2, by_chance = 1e-12,
                 lifeless_s = 300.0;  ///< of one that scatters
constexpr std::size_t most_samples = 64;

}  // namespace

const char* fault_text(SensorFault fault) {
  switch (fault) {
    case SensorFault::none: return "none";
    case SensorFault::absent: return "absent";
    case SensorFault::stuck: return "stuck";
    case SensorFault::offset: return "offset";
    case SensorFault::noise: return "noise";
  }
  return "";
}

SensorMonitor::SensorMonitor(const Eigen::VectorXd& deviation_K)
    : deviation_(deviation_K.cwiseMax(least_deviation_K)),
      sensors_(deviation_.size()) {}

void SensorMonitor::start(Sensor& sensor, double time, double reading, double expected) {
  sensor.known = true;
  sensor.seen_at = time;
  sensor.last_reading = sensor.same_value = reading;
  sensor.same_expected = sensor.expected_memory = expected;
  sensor.same_count = 1;
  sensor.same_since = time;
  sensor.usual = sensor.last_difference = reading - expected;
  sensor.last_expected = expected;
}

void SensorMonitor::correct(const Eigen::VectorXd& change) {
  for (Index s = 0; s < std::min(change.size(), std::ssize(sensors_)); ++s) {
    Sensor& sensor = sensors_[s];
    if (!sensor.known) continue;
    sensor.last_difference -= change[s];
    sensor.last_expected += change[s];
    sensor.expected_memory += change[s];
    if (!sensor.from_start) sensor.usual -= change[s];
    for (Sample& sample : sensor.recent) sample.difference -= change[s];
  }
}

bool SensorMonitor::judge(double time, const Eigen::VectorXd& reading, const Eigen::VectorXd& expected,
                          bool inputs_leapt, const Eigen::VectorXd& unsure) {
  // What sensors differ by from what is expected, at the first readings: most of them are right.
  std::vector<double> differences;
  for (Index s = 0; s < reading.size(); ++s) {
    if (std::isfinite(reading[s])) differences.push_back(std::abs(reading[s] - expected[s]));
  }
  double usual = 0.0;
  if (!differences.empty()) {
    const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
    std::nth_element(differences.begin(), middle, differences.end());
    usual = *middle;
  }
  bool changed = false;
  faults_ = 0;
  for (Index s = 0; s < reading.size(); ++s) {
    Sensor& sensor = sensors_[s];
    const SensorFault before = sensor.fault;
    if (std::isfinite(reading[s])) {
      const std::size_t i = s;
      judge_one(sensor, deviation_[s], reading[s],
                {time, expected[s], usual, unsure.size() > s ? unsure[s] : 0.0, inputs_leapt,
                 i < explained_.size() && explained_[i] != 0});
    } else {
      sensor.trusted = false;
      if (sensor.known && sensor.fault == SensorFault::none && time - sensor.seen_at > absent_s)
        sensor.fault = SensorFault::absent;
    }
    changed = changed || sensor.fault != before;
    faults_ += sensor.fault != SensorFault::none;
  }
  return changed;
}

void SensorMonitor::judge_one(Sensor& sensor, double deviation, double reading, const Row& row) {
  const double time = row.time, expected = row.expected;
  const bool first = !sensor.known;
  const double interval = first ? 0.0 : time - sensor.seen_at;
  if (first) {
    start(sensor, time, reading, expected);
    // A sensor far off from the start has nothing usual to leap from.
    const double off = std::abs(reading - expected);
    if (!row.explained && off > start_K && off > start_factor * (row.others + deviation)) {
      sensor.from_start = true;
      sensor.usual = 0.0;
      sensor.leapt = true;
      sensor.leapt_at = time;
      sensor.leap = std::abs(reading - expected);
    }
  } else if (sensor.fault == SensorFault::absent) {
    sensor.fault = SensorFault::none;
    sensor.usual = sensor.last_difference = reading - expected;
    sensor.last_expected = expected;
    sensor.recent.clear();
  }
  const double share = 1.0 - std::exp(-interval / std::max(memory_s, 4.0 * interval));
  sensor.expected_memory += share * (expected - sensor.expected_memory);
  const double sigma = deviation + model_share * std::abs(expected - sensor.expected_memory) +
                       row.unsure_K_s * std::max(memory_s, 4.0 * interval);
  const double difference = reading - expected - sensor.usual;
  const double jump = std::abs(reading - expected - sensor.last_difference);
  // The reading may have moved as far as expected at once, or not yet at all.
  const double step = std::abs(expected - sensor.last_expected), unsure = unsure_factor * row.unsure_K_s * interval;
  const double unknown = (row.inputs_leapt ? step : 0.0) + unsure;
  if (!sensor.leapt && jump > leap * deviation + std::max(model_share * step, unknown)) {
    sensor.leapt = true;
    sensor.leapt_at = time;
    sensor.leap = jump;
  }
  const bool apart = sensor.leapt &&
                     std::abs(difference) > std::min(scatter * sigma, std::max(scatter * deviation, 0.5 * sensor.leap));
  // A spike is over at once; what has its name stays until it has agreed for long.
  if (sensor.fault != SensorFault::offset && !apart) sensor.leapt = false;

  // Stuck: the reading repeats while the machine moves on. Coarse digits repeat too.
  if (const double digits = std::abs(reading - sensor.last_reading); digits > 0.0) {
    sensor.smallest_step = sensor.smallest_step > 0.0 ? std::min(sensor.smallest_step, digits) : digits;
  }
  if (std::abs(reading - sensor.same_value) <= same * deviation) {
    ++sensor.same_count;
  } else {
    if (sensor.fault != SensorFault::stuck) {
      sensor.readings += sensor.same_count;
      sensor.repeats += sensor.same_count - 1;
    }
    sensor.same_value = reading;
    sensor.same_expected = expected;
    sensor.same_unsure = 0.0;
    sensor.same_count = 1;
    sensor.same_since = time;
  }
  sensor.same_unsure += unsure;
  // What the observer expects follows a stuck sensor for a while; that readings no longer scatter tells sooner.
  // Digits coarser than the scatter repeat too often to say anything.
  const double chance = (sensor.repeats + 1.0) / (sensor.readings + 2.0);
  const bool lifeless = sensor.readings >= known_readings && chance <= most_repeats &&
                        time - sensor.same_since >= lifeless_s &&
                        (sensor.same_count - 1) * std::log(chance) <= std::log(by_chance);
  const double enough = std::max(moved * deviation, 1.5 * sensor.smallest_step) + sensor.same_unsure;
  // Once stuck, agreeing by chance is no sign of life.
  const bool stuck = sensor.same_count >= 3 && (sensor.fault == SensorFault::stuck || lifeless ||
                                                std::abs(expected - sensor.same_expected) > enough);

  // Noise turns from reading to reading; what the model gets wrong runs on, so that the second
  // difference has none of it. A leap makes two of them large, noise most.
  const double value = reading - expected;
  double bend = 0.0;
  if (const std::size_t n = sensor.recent.size(); n >= 2)
    bend = value - 2.0 * sensor.recent[n - 1].difference + sensor.recent[n - 2].difference;
  sensor.recent.push_back(
      {time, value, std::abs(bend) > turning * std::sqrt(6.0) * deviation + unknown + sensor.last_unknown});
  sensor.last_unknown = unknown;
  while (sensor.recent.size() > most_samples ||
         time - sensor.recent.front().time > std::max(window_s, window_rows * interval))
    sensor.recent.pop_front();
  int bends = 0;
  for (const Sample& sample : sensor.recent) bends += sample.far;
  const bool noisy = bends >= 3 && 4 * bends >= std::ssize(sensor.recent);

  const bool stays = apart && sensor.leapt_at < time && time - sensor.leapt_at >= confirm_s;
  const bool suspect = stuck || noisy || apart;
  if (suspect)
    sensor.agreed_since = -1.0;
  else if (sensor.agreed_since < 0.0)
    sensor.agreed_since = time;
  if (noisy)
    sensor.fault = SensorFault::noise;
  else if (stuck)
    sensor.fault = SensorFault::stuck;
  else if (stays && sensor.fault == SensorFault::none)
    sensor.fault = SensorFault::offset;
  else if (sensor.fault != SensorFault::none && sensor.agreed_since >= 0.0 && time - sensor.agreed_since >= agreed_s) {
    sensor.fault = SensorFault::none;
    sensor.leapt = sensor.from_start = false;
  }

  sensor.trusted = !suspect && sensor.fault == SensorFault::none;
  if (sensor.trusted) sensor.usual += share * difference;
  sensor.seen_at = time;
  sensor.last_reading = reading;
  sensor.last_difference = reading - expected;
  sensor.last_expected = expected;
}

}  // namespace thermotwin::compensation
