// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/observer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "compensation/online/compensator.h"
#include "compensation/online/drive_heats.h"
#include "core/error.h"
#include "core/statistics.h"
#include "solver/campaign/simulation.h"

namespace thermotwin::compensation {
namespace {

using core::median;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Standard deviations of the start, K: where nothing is measured, and the least that remains where
// sensors agree with each other.
constexpr double start_uniform_K = 0.5, least_start_K = 0.03;
constexpr double rate_error_share = 0.2;   // of how fast what the start left fades at a sensor
constexpr double least_chance = 1e-4;      // of a first reading that is believed though it is far from all others
constexpr std::size_t enough_sensors = 3;  // to tell which of them is off

}  // namespace

Observer::Observer(const reduction::ReducedModel& model, const solver::OperatingModel& operating,
                   const CompensatorOptions& options, StateClock& clock)
    : model_(model),
      options_(options),
      clock_(clock),
      operating_(operating),
      defaults_(operating.channels().defaults()),
      air_(operating.channels().index("air.T_C")),
      sensor_offset_(solver::sensor_offsets(model.machine, model.system.layout)),
      trust_(model, operating.channels()),
      errors_(model) {
  for (const mesh::AmbientSpec& ambient : model.machine.ambients)
    ambients_.push_back(operating.channels().index(ambient.id + ".T_C"));
  const Index sensors = model.system.sensors.rows(), order = model.system.order();
  reading_K_ = VectorXd::Constant(sensors, solver::not_given);
  shift_ = bias_K_ = bias_rate_ = unsure_rate_ = own_offset_ = VectorXd::Zero(sensors);
  corrected_ = correction_rate_ = VectorXd::Zero(order);
  innovation_sum_ = moment_sum_ = VectorXd::Zero(sensors);
  innovation_count_ = reading_counts_ = Eigen::VectorXi::Zero(sensors);
  innovations_.reserve(sensors);
  untold_.resize(errors_.drives().size());
  whole_ = clock.no_interval();
}

void Observer::read(const VectorXd& sensors_C, const VectorXd& row) {
  const auto sensors = std::ssize(model_.machine.sensors);
  if (sensors_C.size() > 0)
    reading_C_ = sensors_C;
  else
    reading_C_.setConstant(sensors, solver::not_given);
  trust_.take_out_sensors(reading_C_, row);
  // What coefficients follow beside the sensors is never measured.
  for (Index s = 0; s < sensors; ++s) reading_K_[s] = reading_C_[s] - model_.machine.reference_C;
}

const VectorXd& Observer::guide_readings() {
  guide_K_ = clock_.sensors_state() + errors_.sensor_correction() + sensor_offset_;
  take_trusted(guide_K_);
  return guide_K_;
}

void Observer::take_trusted(VectorXd& readings_K) const {
  for (Index s = 0; s < readings_K.size(); ++s) {
    if (!std::isfinite(reading_K_[s]) || !trust_.trusted(s)) continue;
    readings_K[s] = reading_K_[s];
    if (errors_.doubts(s)) readings_K[s] -= own_offset_[s];
  }
}

/// The temperature of the air; of a machine without air that of the ambient next to a reading, or the reading where it
/// lies between two.
double Observer::surroundings_near(const VectorXd& row, double value) const {
  if (air_ >= 0 && std::isfinite(row[air_])) return row[air_] - model_.machine.reference_C;
  double coldest = std::numeric_limits<double>::infinity(), warmest = -coldest;
  for (const int ambient : ambients_) {
    const double around = row[ambient] - model_.machine.reference_C;
    if (!std::isfinite(around)) continue;
    coldest = std::min(coldest, around);
    warmest = std::max(warmest, around);
  }
  return coldest > warmest ? value : std::clamp(value, coldest, warmest);
}

/// The offset that a first reading may have because too few others speak against it: one sensor cannot tell a warm
/// machine from its own error, of two the one that is further off may be wrong.
double Observer::doubt_of(const VectorXd& row, const std::vector<FirstReading>& readings, std::size_t i) const {
  if (readings.size() >= enough_sensors) return 0.0;
  const double value = readings[i].value, far = std::abs(value - surroundings_near(row, value));
  return readings.size() == 1 ? far : std::min(far, std::abs(readings[0].value - readings[1].value));
}

/// One sensor alone says nothing of the temperature of the others: far from the surroundings it counts as a part that
/// work has warmed, or as wrong.
Observer::UniformStart Observer::start_of_one(const VectorXd& row, double value) const {
  const double around = surroundings_near(row, value), far = std::abs(value - around);
  if (far > start_uniform_K) return {around, start_uniform_K + 0.5 * far};
  return {value, std::max(least_start_K, far)};
}

/// Of a rested machine sensors agree in the middle; one at work rests on the coldest of them, or on the air.
/// @param without  a sensor that is left out
std::vector<Observer::UniformStart> Observer::uniform_starts(const VectorXd& row, Index without) const {
  const std::vector<FirstReading> readings = first_readings(0.0, without);
  std::vector<double> known;
  for (const FirstReading& reading : readings) known.push_back(reading.value);
  const double middle = median(known), lowest = *std::min_element(known.begin(), known.end());
  std::vector<double> distances;
  for (const double value : known) distances.push_back(std::abs(value - middle));
  const auto std_of = [](double distance) { return std::max(least_start_K, distance); };
  std::vector<UniformStart> offered{{middle, std_of(1.5 * median(distances))},
                                    {lowest, std_of(0.25 * (middle - lowest))}};
  if (readings.size() == 1) offered[0] = offered[1] = start_of_one(row, middle);
  if (air_ >= 0 && std::isfinite(row[air_])) {
    const double surroundings = row[air_] - model_.machine.reference_C;
    offered.push_back({surroundings, std_of(start_uniform_K + 0.25 * std::abs(lowest - surroundings))});
  }
  return offered;
}

Observer::UniformStart Observer::uniform_start(const VectorXd& row) const {
  UniformStart best{0.0, start_uniform_K};
  double most = -std::numeric_limits<double>::infinity();
  for (const UniformStart& start : uniform_starts(row)) {
    const double evidence = errors_.before().log_evidence(start.std, first_readings(start.middle));
    if (evidence <= most) continue;
    best = start;
    most = evidence;
  }
  return best;
}

/// An input that stands at its default is one that nobody gives, see ErrorModel::start. Too few sensors to check each
/// other are checked by the air, where there is a column of it.
VectorXd Observer::ambient_gap(const VectorXd& row, const UniformStart& uniform) const {
  const bool air_counts = first_readings(0.0).size() < enough_sensors && !errors_.is_air_untold();
  VectorXd gap = VectorXd::Zero(std::ssize(ambients_));
  for (Index i = 0; i < gap.size(); ++i) {
    if (ambients_[i] == air_ && air_counts) continue;
    const double standard = defaults_[ambients_[i]];
    if (row[ambients_[i]] == standard) gap[i] = uniform.middle + model_.machine.reference_C - standard;
  }
  return gap;
}

/// Of the sensors that gave one and are trusted, without their own offsets.
std::vector<ErrorModel::FirstReading> Observer::first_readings(double zero_K, Index without) const {
  std::vector<FirstReading> readings;
  for (Index s = 0; s < std::ssize(model_.machine.sensors); ++s) {
    if (s != without && std::isfinite(reading_K_[s]) && trust_.trusted(s))
      readings.push_back({s, reading_K_[s] - sensor_offset_[s] - zero_K});
  }
  return readings;
}

/// Sensors whose first reading a machine at work may have, by what all others read: (sensors) 1 or 0.
std::vector<char> Observer::explained_by_others(const VectorXd& row) const {
  std::vector<char> explained(reading_K_.size(), 0);
  const std::vector<FirstReading> readings = first_readings(0.0);
  if (readings.size() < enough_sensors) return explained;
  // A part that work has not reached is as warm as what surrounds it.
  double coldest = clock_.sensors_state().head(std::ssize(model_.machine.sensors)).mean(), warmest = coldest;
  for (const int ambient : ambients_) {
    const double value = row[ambient] - model_.machine.reference_C;
    if (!std::isfinite(value)) continue;
    coldest = std::min(coldest, value);
    warmest = std::max(warmest, value);
  }
  for (const FirstReading& reading : readings) {
    char& one = explained[reading.sensor];
    one = reading.value > coldest - start_uniform_K && reading.value < warmest + start_uniform_K;
    if (one != 0) continue;
    const double chance =
        errors_.before().chance(uniform_starts(row, reading.sensor), first_readings(0.0, reading.sensor), reading);
    one = chance > least_chance;
  }
  return explained;
}

void Observer::start(double time, const VectorXd& row) {
  const bool by_sensors = options_.start_from_sensors && !first_readings(0.0).empty();
  UniformStart uniform{0.0, start_uniform_K};
  errors_.work_ends_at(row);
  const auto start_uniformly = [&] {
    uniform = uniform_start(row);
    clock_.set_state(model_.system.one_kelvin * uniform.middle);
  };
  if (by_sensors) {
    start_uniformly();
    trust_.explain_first(explained_by_others(row));
  }
  trust_.watch(time, reading_K_ - sensor_offset_, clock_.sensors_state(), false, unsure_rate_);
  if (by_sensors && !first_readings(0.0).empty()) start_uniformly();  // without those that are off
  sensors_start_ = clock_.sensors_state();
  VectorXd readings_K = clock_.sensors_state() + sensor_offset_;
  take_trusted(readings_K);
  clock_.start(time, row, readings_K);
  corrected_at_ = time;

  const std::vector<FirstReading> readings = by_sensors ? first_readings(uniform.middle) : std::vector<FirstReading>{};
  errors_.start(uniform.std, readings,
                by_sensors ? ambient_gap(row, uniform) : VectorXd(VectorXd::Zero(std::ssize(ambients_))));
  const std::vector<FirstReading> whole = by_sensors ? first_readings(0.0) : std::vector<FirstReading>{};
  for (std::size_t i = 0; i < whole.size(); ++i) errors_.doubt(whole[i].sensor, doubt_of(row, whole, i));
  innovations_.clear();
  for (const FirstReading& reading : readings)
    innovations_.push_back({reading.sensor, reading.value, 1.0, reading.value});
  if (!innovations_.empty()) errors_.update(innovations_, 0.0);
  ErrorModel::Interval ahead;
  ahead.duration = std::min(options_.step_s, options_.correction_s);
  ahead.operator_matrix = clock_.operator_at(clock_.coefficients().p);
  errors_.foresee(ahead);
  settle();
}

void Observer::add_readings(bool inputs_leapt) {
  const double time = clock_.time(), ahead = clock_.ahead();
  const VectorXd &state = clock_.sensors_state(), &change = clock_.sensors_change();
  const double moment = clock_.interval_s() + (time - clock_.step_end());
  trust_.watch(time, reading_K_ - sensor_offset_,
               state + ahead * change + bias_K_ + (time - corrected_at_) * bias_rate_, inputs_leapt, unsure_rate_);
  for (Index s = 0; s < reading_K_.size(); ++s) {
    if (!trust_.trusted(s)) continue;
    innovation_sum_[s] += reading_K_[s] - sensor_offset_[s] - state[s] - ahead * change[s];
    moment_sum_[s] += moment;
    ++innovation_count_[s];
  }
}

/// What work before has left changes fast at first: then the observer corrects at each end of a step.
double Observer::correction_after() const {
  return std::min(options_.correction_s, std::max(options_.step_s, 0.25 * (clock_.step_end() - clock_.started_at())));
}

void Observer::add_drives(const std::vector<char>& untold, const VectorXd& row, double duration) {
  if (drives_taken_) {
    for (Untold& drive : untold_) drive = {};
    drives_s_ = 0.0;
    drives_taken_ = false;
  }
  drives_s_ += duration;
  for (Index d = 0; d < std::ssize(untold_); ++d) {
    if (untold[d] == 0) continue;
    const DriveHeat& known = errors_.drives()[d];
    if (untold_[d].energy.size() == 0) untold_[d] = {VectorXd::Zero(model_.system.order()), 0.0};
    untold_[d].energy += duration * heat_at_half_speed(model_.system, operating_, known, row);
    untold_[d].way += duration * std::abs(row[known.channel]);
  }
}

void Observer::advance_errors() {
  const ErrorModel::Interval& interval = clock_.take_interval();
  for (Index d = 0; d < std::ssize(untold_); ++d) {
    const Untold& untold = untold_[d];
    const bool told = untold.energy.size() == 0;
    errors_.set_untold(d, told ? VectorXd() : VectorXd(untold.energy / drives_s_),
                       told ? 0.0 : untold.way / drives_s_ / errors_.drives()[d].half_speed);
  }
  drives_taken_ = true;
  errors_.advance(interval);
  const double duration = interval.duration;
  whole_.duration += duration;
  whole_.p += duration * interval.p;
  whole_.q += duration * interval.q;
  whole_.state += duration * interval.state;
  reading_counts_ += innovation_count_;
  innovation_sum_.setZero();
  moment_sum_.setZero();
  innovation_count_.setZero();
}

void Observer::correct() {
  const double duration = clock_.interval_s();
  innovations_.clear();
  for (Index s = 0; s < reading_K_.size(); ++s) {
    if (innovation_count_[s] == 0) continue;
    const double count = innovation_count_[s];
    innovations_.push_back({s, innovation_sum_[s] / count, std::clamp(moment_sum_[s] / count / duration, 0.0, 1.0),
                            clock_.sensors_state()[s] + bias_K_[s] - sensors_start_[s]});
  }
  advance_errors();
  shift_ = errors_.sensor_correction();
  if (!innovations_.empty()) {
    errors_.update(innovations_, duration);
    trust_.watch_drift(clock_.time(), errors_);
  }
  settle();
}

void Observer::learn(const ErrorModel::ErrorRows& rows, const Eigen::Vector3d& error, double std_m) {
  errors_.learn(rows, clock_.state() + clock_.share_ahead() * clock_.change(), error, std_m);
  settle();
}

/// Something was learnt: readings and the state are corrected by it from the end of the last step on.
void Observer::settle() {
  const double step_end = clock_.step_end();
  const VectorXd expected = bias_K_ + (step_end - corrected_at_) * bias_rate_;
  bias_K_ = errors_.sensor_correction();
  bias_rate_ = errors_.sensor_correction_rate();
  unsure_rate_ = errors_.sensor_rate_std() + rate_error_share * bias_rate_.cwiseAbs();
  for (Index s = 0; s < own_offset_.size(); ++s) own_offset_[s] = errors_.own_offset(s).value;
  correction_rate_ = errors_.correction_rate();
  corrected_at_ = step_end;
  trust_.correct(bias_K_ - expected);
  set_corrected();
}

void Observer::set_corrected() {
  corrected_ = clock_.state() + errors_.correction() + (clock_.step_end() - corrected_at_) * correction_rate_;
}

VectorXd Observer::predicted_sensors_C() const {
  return (clock_.sensors_state() + clock_.share_ahead() * clock_.sensors_change() + shift_ + sensor_offset_).array() +
         model_.machine.reference_C;
}

Detectability Observer::detectability() const {
  if (!(whole_.duration > 0.0))
    throw core::InputError("detectability", "no step of the thermal state has ended", "a run of some minutes");
  ErrorModel::Interval mean = whole_;
  mean.p /= whole_.duration;
  mean.q /= whole_.duration;
  mean.state /= whole_.duration;
  const MatrixXd matrix = clock_.operator_at(mean.p);
  const auto sensors = std::ssize(model_.machine.sensors);
  std::vector<ErrorModel::State> constants;
  const std::vector<ErrorModel::State> known = errors_.states();
  for (Index k = 0; k < errors_.machine_quantities(); ++k) constants.push_back(known[k]);
  const Index first = errors_.directions().cols();
  for (Index s = 0; s < sensors; ++s) constants.push_back(known[first + s]);
  VectorXd deviations(sensors);
  for (Index s = 0; s < sensors; ++s)
    deviations[s] = reading_counts_[s] > 0 && !trust_.drifts(s) ? errors_.reading_std(s, 0.0) : solver::not_given;
  return compensation::detectability(model_.system.capacity, matrix, errors_.rates(mean),
                                     model_.system.sensors.topRows(sensors), constants, deviations);
}

}  // namespace thermotwin::compensation
