// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/sensor_monitor.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/statistics.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;

constexpr double absent_s = 300.0, agreed_s = 1800.0;
constexpr double window_s = 900.0, window_rows = 8.0;  ///< that noise is looked for in
constexpr double memory_s = 600.0;                     ///< of the usual difference; at least four rows
constexpr double leap_factor = 12.0, scatter = 4.0, turning = 3.5, moved = 5.0, same = 0.1;
constexpr double unsure_factor = 3.0;  ///< deviations of how fast an expected reading changes
constexpr double start_K = 1.0, start_factor = 6.0, least_deviation_K = 0.03, model_share = 0.1;
constexpr double confirm_s = 30.0;               ///< that a leap has to stay
constexpr double outlast_s = 150.0;              ///< the same beside quick rows, behind a jump of an input
constexpr double quick_s = 30.0, late_s = 90.0;  ///< how late the expected reading follows rows that come quicker
constexpr double known_readings = 60.0, most_repeats = 0.2, by_chance = 1e-12,
                 lifeless_s = 300.0;      ///< of one that scatters
constexpr double least_scatter = 0.05;    ///< of readings whose repeating says anything, over their deviation
constexpr double normal_median = 0.6745;  ///< of the absolute value of a standard normal number
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

void SensorMonitor::Sensor::start(double time, double reading, double expected) {
  known = true;
  seen_at = time;
  last_reading = same_value = reading;
  same_expected = expected_memory = expected;
  same_count = 1;
  same_since = time;
  usual = last_difference = reading - expected;
  last_expected = expected;
}

void SensorMonitor::correct(const Eigen::VectorXd& change) {
  for (Index s = 0; s < std::min(change.size(), std::ssize(sensors_)); ++s) {
    Sensor& sensor = sensors_[s];
    if (!sensor.known) continue;
    sensor.last_difference -= change[s];
    sensor.last_expected += change[s];
    sensor.expected_memory += change[s];
    sensor.same_learnt += change[s];
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
  const double usual = differences.empty() ? 0.0 : core::median(std::move(differences));
  bool changed = false;
  for (Index s = 0; s < reading.size(); ++s) {
    Sensor& sensor = sensors_[s];
    const SensorFault before = sensor.fault;
    if (std::isfinite(reading[s])) {
      sensor.judge(deviation_[s], reading[s],
                   {time, expected[s], usual, unsure.size() > s ? unsure[s] : 0.0, inputs_leapt,
                    s < std::ssize(explained_) && explained_[s] != 0});
    } else {
      sensor.trusted = false;
      if (sensor.known && sensor.fault == SensorFault::none && time - sensor.seen_at > absent_s)
        sensor.fault = SensorFault::absent;
    }
    changed = changed || sensor.fault != before;
  }
  return changed;
}

/// The first reading, or one after a long silence.
void SensorMonitor::Sensor::arrive(double deviation, double reading, const Row& row) {
  if (!known) {
    start(row.time, reading, row.expected);
    // A sensor far off from the start has nothing usual to leap from.
    const double off = std::abs(reading - row.expected);
    if (!row.explained && off > start_K && off > start_factor * (row.others + deviation)) {
      from_start = true;
      usual = 0.0;
      leapt = true;
      leapt_at = row.time;
      leap = std::abs(reading - row.expected);
    }
  } else if (fault == SensorFault::absent) {
    fault = SensorFault::none;
    usual = last_difference = reading - row.expected;
    last_expected = row.expected;
    recent.clear();
  }
}

/// @return whether the reading stands apart from what was usual before it leapt
bool SensorMonitor::Sensor::stands_apart(const Judged& now) {
  const double expected = now.row.expected, deviation = now.deviation;
  const double sigma = deviation + model_share * std::abs(expected - expected_memory) +
                       now.row.unsure_K_s * std::max(memory_s, 4.0 * now.interval);
  // An expected reading that jumps alone has followed late.
  const double jump =
      std::min(std::abs(now.reading - expected - last_difference), std::abs(now.reading - last_reading));
  if (!leapt && jump > leap_factor * deviation + std::max(model_share * now.step, now.unknown)) {
    leapt = true;
    leapt_at = now.row.time;
    leap = jump;
  }
  const bool apart =
      leapt && std::abs(now.difference) > std::min(scatter * sigma, std::max(scatter * deviation, 0.5 * leap));
  // A spike is over at once; what has its name stays until it has agreed for long.
  if (fault != SensorFault::offset && !apart) leapt = false;
  return apart;
}

/// Standard deviation of the reading about a smooth course, from the median of its second differences.
double SensorMonitor::Sensor::scatter_K() const {
  std::array<double, std::tuple_size_v<decltype(turns)>> sorted = turns;
  const auto count = std::min(turn_count, sorted.size());
  if (count == 0) return 0.0;
  const auto middle = sorted.begin() + count / 2;
  std::nth_element(sorted.begin(), middle, sorted.begin() + count);
  return *middle / (normal_median * std::sqrt(6.0));
}

/// Stuck: the reading repeats while the machine moves on. Coarse digits repeat too.
bool SensorMonitor::Sensor::is_stuck(const Judged& now) {
  if (const double digits = std::abs(now.reading - last_reading); digits > 0.0) {
    smallest_step = smallest_step > 0.0 ? std::min(smallest_step, digits) : digits;
  }
  if (std::abs(now.reading - same_value) <= same * now.deviation) {
    ++same_count;
  } else {
    if (fault != SensorFault::stuck) {
      readings += same_count;
      repeats += same_count - 1;
    }
    same_value = now.reading;
    same_count = 1;
    same_since = now.row.time;
    held = false;
  }
  if (same_count == 1 || (now.interval < quick_s && now.row.time - same_since < late_s)) {
    same_expected = now.row.expected;
    same_unsure = same_learnt = 0.0;
  }
  same_unsure += now.unsure;
  // What the observer expects follows a stuck sensor for a while; that readings no longer scatter tells sooner.
  // Digits coarser than the scatter repeat too often to say anything.
  const double chance = (repeats + 1.0) / (readings + 2.0);
  const bool lifeless =
      readings >= known_readings && chance <= most_repeats && now.row.time - same_since >= lifeless_s &&
      (same_count - 1) * std::log(chance) <= std::log(by_chance) && scatter_K() > least_scatter * now.deviation;
  const double enough = std::max(moved * now.deviation, 1.5 * smallest_step) + same_unsure;
  const double since = now.row.expected - same_expected;
  const bool has_moved = std::min(std::abs(since), std::abs(since - same_learnt)) > enough;
  // Once stuck, agreeing by chance is no sign of life; another reading is.
  held = held || (same_count >= 3 && (lifeless || has_moved));
  return held;
}

/// Noise turns from reading to reading; what the model gets wrong runs on, so that the second
/// difference has none of it, and what the model does at once is not in the reading. A leap makes two of them large,
/// noise most.
bool SensorMonitor::Sensor::is_noisy(const Judged& now) {
  const double time = now.row.time, value = now.reading - now.row.expected;
  double bend = 0.0;
  if (const std::size_t n = recent.size(); n >= 2) {
    const Sample &last = recent[n - 1], &other = recent[n - 2];
    bend = std::min(std::abs(value - 2.0 * last.difference + other.difference),
                    std::abs(now.reading - 2.0 * last.reading + other.reading));
  }
  recent.push_back(
      {time, value, now.reading, bend > turning * std::sqrt(6.0) * now.deviation + now.unknown + last_unknown});
  if (!now.row.inputs_leapt && same_count == 1 && recent.size() > 2) turns[turn_count++ % turns.size()] = bend;
  last_unknown = now.unknown;
  while (recent.size() > most_samples || time - recent.front().time > std::max(window_s, window_rows * now.interval))
    recent.pop_front();
  int bends = 0;
  for (const Sample& sample : recent) bends += sample.far;
  return bends >= 3 && 4 * bends >= std::ssize(recent);
}

void SensorMonitor::Sensor::name_fault(const Judged& now, bool apart, bool stuck, bool noisy) {
  const double time = now.row.time;
  // The expected reading may follow late: what leapt with the inputs waits for it.
  const bool follows = now.interval < quick_s && leapt_at - inputs_leapt_at <= late_s;
  const bool stays = apart && leapt_at < time && time - leapt_at >= (follows ? outlast_s : confirm_s);
  const bool suspect = stuck || noisy || apart;
  if (suspect)
    agreed_since = -1.0;
  else if (agreed_since < 0.0)
    agreed_since = time;
  if (noisy)
    fault = SensorFault::noise;
  else if (stuck)
    fault = SensorFault::stuck;
  else if (stays && fault == SensorFault::none)
    fault = SensorFault::offset;
  else if (fault != SensorFault::none && agreed_since >= 0.0 && time - agreed_since >= agreed_s) {
    fault = SensorFault::none;
    leapt = from_start = false;
  }
  trusted = !suspect && fault == SensorFault::none;
}

void SensorMonitor::Sensor::judge(double deviation, double reading, const Row& row) {
  const double interval = known ? row.time - seen_at : 0.0;
  if (row.inputs_leapt) inputs_leapt_at = row.time;
  arrive(deviation, reading, row);
  const double share = 1.0 - std::exp(-interval / std::max(memory_s, 4.0 * interval));
  expected_memory += share * (row.expected - expected_memory);
  // The reading may have moved as far as expected at once, or not yet at all.
  const double step = std::abs(row.expected - last_expected), unsure = unsure_factor * row.unsure_K_s * interval;
  const double unknown = (row.inputs_leapt ? step : 0.0) + unsure;
  const Judged now{row, deviation, reading, interval, reading - row.expected - usual, step, unsure, unknown};
  const bool apart = stands_apart(now), stuck = is_stuck(now), noisy = is_noisy(now);
  name_fault(now, apart, stuck, noisy);
  if (trusted) usual += share * now.difference;
  seen_at = row.time;
  last_reading = reading;
  last_difference = reading - row.expected;
  last_expected = row.expected;
}

}  // namespace thermotwin::compensation
