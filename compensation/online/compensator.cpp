// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/compensator.h"

#include <fmt/format.h>
#include <iterator>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "compensation/online/drift_watch.h"
#include "compensation/online/error_model.h"
#include "compensation/online/input_mean.h"
#include "compensation/online/offset_guard.h"
#include "compensation/online/output_map.h"
#include "compensation/online/reading_check.h"
#include "compensation/online/sensor_monitor.h"
#include "core/error.h"
#include "core/units.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/simulation.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Standard deviations of the start, K: where nothing is measured, and the least that remains where
// sensors agree with each other.
constexpr double rate_error_share = 0.2;  // of how fast what the start left fades at a sensor
constexpr double least_chance = 1e-4;     // of a first reading that is believed though it is far from all others
constexpr double start_uniform_K = 0.5, least_start_K = 0.03;
/// What the observer does not estimate, as a share of the offset: expansions, stiffness, the mesh.
constexpr double offset_error_share = 0.03;
/// The same once probing has estimated expansions: stiffness, the mesh.
constexpr double probed_error_share = 0.01;
/// An input leaps if it changes by more than this share of itself from row to row.
constexpr double leap_share = 0.2;

/// What the guard takes.
constexpr double largest_offset_um = 1e5, least_rate_um_s = 1e-6, largest_rate_um_s = 1e6;

/// Times differ by rounding; steps that are meant equal must be equal to reuse a factor.
double rounded(double duration) { return duration > 1e-3 ? std::round(duration * 1e6) / 1e6 : duration; }

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

const char* status_text(Status status) {
  switch (status) {
    case Status::ok: return "ok";
    case Status::no_sensors: return "no_sensors";
    case Status::outside_workspace: return "outside_workspace";
    case Status::input_missing: return "input_missing";
    case Status::sensor_failed: return "sensor_failed";
    case Status::limited: return "limited";
    case Status::failed: return "failed";
  }
  return "";
}

struct Compensator::Work {
  const reduction::ReducedModel& model;
  CompensatorOptions options;
  solver::OperatingModel operating;
  reduction::ReducedStepper stepper;
  OutputMap map;
  ErrorModel errors;
  InputMean inputs;
  OffsetLimits limits;
  OffsetGuard guard;
  ReadingCheck check;
  SensorMonitor monitor;
  DriftWatch drift;
  VectorXd sensor_offset;  ///< reading in K above the reference minus state's temperature
  double model_error = 0;  ///< m, of the reduced against the full model

  bool started = false, started_guard = false, inputs_leapt = false;
  std::vector<int> leaping;       ///< channels that may leap: speeds, feeds, powers, states
  double time = 0, step_end = 0;  ///< of the last row; of the last step of the state
  VectorXd row, row_before, given, given_at, reading_C, reading_K, predicted_K;
  std::vector<ReadingFault> named_faults;  ///< (sensors) that failed_sensors tells of
  mesh::Pose guarded_pose;
  std::optional<solver::Chiller> chiller;
  solver::Coefficients coefficients;
  VectorXd state, before, change, corrected;
  VectorXd sensors_state, sensors_change, sensors_start, shift;
  VectorXd bias_K, bias_rate, unsure_rate;  ///< what the observer adds to the predicted readings; K/s; its deviation
  VectorXd correction_rate;                 ///< of the state, K/s
  double corrected_at = 0, started_at = 0;  ///< time of the last correction, of the first row
  double last_step = 0;
  OutputMap::Projected base, slope;
  Offsets offsets;

  /// What happened since the last correction.
  ErrorModel::Interval interval;
  MatrixXd operator_sum;
  bool p_changed = false;
  VectorXd first_p, innovation_sum, moment_sum;
  Eigen::VectorXi innovation_count;
  std::vector<ErrorModel::Innovation> innovations;
  long probed = 0;

  /// Over the whole run, for what its sensors can tell.
  ErrorModel::Interval whole;
  Eigen::VectorXi reading_counts;

  Work(const reduction::ReducedModel& m, const CompensatorOptions& o)
      : model(m),
        options(o),
        operating(m.machine, m.system.layout),
        stepper(m.system),
        map(m),
        errors(m),
        inputs(m.machine, operating.channels()),
        limits(chosen_limits(m, map, o)),
        guard(std::ssize(map.axes()), guard_options(limits)),
        check(m.machine, operating.channels()),
        monitor(stated_deviations(m)),
        drift(stated_deviations(m)) {
    const Index sensors = m.system.sensors.rows(), order = m.system.order();
    sensor_offset = solver::sensor_offsets(m.machine, m.system.layout);
    for (const reduction::ReductionErrors& error : m.errors)
      model_error = std::max(model_error, error.rms_um * core::units::um);
    row = operating.channels().defaults();
    for (std::size_t k = 0; k < operating.channels().names().size(); ++k) {
      const std::string& name = operating.channels().names()[k];
      const auto ends = [&](const char* ending) { return name.ends_with(ending); };
      if (ends("_rpm") || ends("_min") || ends(".power_W") || ends(".on") || ends(".open")) leaping.push_back(k);
    }
    given_at = VectorXd::Constant(row.size(), -std::numeric_limits<double>::infinity());
    reading_K = VectorXd::Constant(sensors, solver::not_given);
    named_faults.assign(m.machine.sensors.size(), ReadingFault::none);
    state = before = change = corrected = VectorXd::Zero(order);
    sensors_change = shift = bias_K = bias_rate = unsure_rate = VectorXd::Zero(sensors);
    correction_rate = VectorXd::Zero(order);
    innovation_sum = moment_sum = VectorXd::Zero(sensors);
    innovation_count = Eigen::VectorXi::Zero(sensors);
    innovations.reserve(sensors);
    const auto axes = std::ssize(map.axes());
    offsets.offset_um = offsets.std_um = VectorXd::Zero(axes);
    set_state(m.system.one_kelvin * (options.start_C - m.machine.reference_C));
    map.project(change, slope);
    clear_interval();
    whole = interval;
    reading_counts = Eigen::VectorXi::Zero(sensors);
  }

  static OffsetLimits chosen_limits(const reduction::ReducedModel& m, const OutputMap& output,
                                    const CompensatorOptions& o) {
    OffsetLimits chosen = offset_limits(m, output);
    if (o.largest_um > 0.0) chosen.largest_um = o.largest_um;
    if (o.rate_um_s > 0.0) {
      chosen.rate_um_s = o.rate_um_s;
      chosen.slope_um.setZero();
    }
    chosen.largest_um = std::min(chosen.largest_um, largest_offset_um);
    chosen.rate_um_s = std::clamp(chosen.rate_um_s, least_rate_um_s, largest_rate_um_s);
    return chosen;
  }

  static GuardOptions guard_options(const OffsetLimits& limits) {
    GuardOptions options;
    options.largest_um = limits.largest_um;
    options.rate_um_s = limits.rate_um_s;
    return options;
  }

  static VectorXd stated_deviations(const reduction::ReducedModel& m) {
    VectorXd deviation = VectorXd::Constant(m.system.sensors.rows(), 1.0);
    for (Index s = 0; s < std::min(deviation.size(), std::ssize(m.machine.sensors)); ++s) {
      deviation[s] = m.machine.sensors[s].uncertainty;
    }
    return deviation;
  }

  /// Finds sensors that have failed. @param expected_K  above the reference, biases included
  void watch_sensors(const VectorXd& expected_K) {
    bool changed = monitor.judge(time, reading_K - sensor_offset, expected_K, inputs_leapt, unsure_rate);
    for (std::size_t s = 0; s < named_faults.size(); ++s) {
      const ReadingFault fault = check.sensor(s);
      changed = changed || fault != named_faults[s];
      named_faults[s] = fault;
    }
    if (changed) name_failed();
  }

  /// Why a sensor is left out; nullptr: it is not.
  const char* fault_of(Index s) const {
    if (check.sensor(s) != ReadingFault::none) return fault_text(check.sensor(s));
    if (monitor.fault(s) == SensorFault::offset && check.looks_fahrenheit(s))
      return fault_text(ReadingFault::fahrenheit);
    if (monitor.fault(s) != SensorFault::none) return fault_text(monitor.fault(s));
    return drift.drifts(s) ? "drift" : nullptr;
  }

  bool trusted(Index s) const { return monitor.trusted(s) && !drift.drifts(s); }

  void name_failed() {
    offsets.failed_sensors.clear();
    for (Index s = 0; s < std::ssize(model.machine.sensors); ++s) {
      if (const char* fault = fault_of(s); fault != nullptr)
        add_name(offsets.failed_sensors, model.machine.sensors[s].id, fault);
    }
  }

  void name_failed_inputs() {
    offsets.failed_inputs.clear();
    if (!check.any_input()) return;
    for (Index k = 0; k < row.size(); ++k) {
      if (check.input(k) != ReadingFault::none)
        add_name(offsets.failed_inputs, operating.channels().names()[k], fault_text(check.input(k)));
    }
  }

  static void add_name(std::string& list, const std::string& name, const char* fault) {
    list += fmt::format("{}{}={}", list.empty() ? "" : " ", name, fault);
  }

  /// Finds sensors that drift, and takes out of the estimate what they had put into it.
  void watch_drift() {
    const auto sensors = std::ssize(model.machine.sensors);
    VectorXd value = VectorXd::Constant(sensors, solver::not_given), deviation = value;
    for (Index s = 0; s < sensors; ++s) {
      if (!trusted(s)) continue;
      const ErrorModel::SensorOffset seen = errors.offset(s);
      value[s] = seen.value;
      deviation[s] = seen.std;
    }
    if (const Index s = drift.judge(time, value, deviation); s >= 0) {
      errors.release(s);
      name_failed();
    }
  }

  void set_state(const VectorXd& value) {
    state = value;
    sensors_state = model.system.sensors * state;
  }

  void clear_interval() {
    interval.duration = 0.0;
    interval.p = VectorXd::Zero(std::ssize(model.system.terms));
    interval.q = VectorXd::Zero(model.system.inputs.cols());
    interval.state = VectorXd::Zero(model.system.order());
    operator_sum.setZero(model.system.order(), model.system.order());
    p_changed = false;
    innovation_sum.setZero();
    moment_sum.setZero();
    innovation_count.setZero();
  }

  /// Readings that the chillers see: measured ones where there are and are trusted, else predicted. A reading that has leapt is taken
  /// for the fault of its way here; if the chiller follows it, the other sensors see the coolant change.
  void guide_readings(VectorXd& readings) const {
    readings = sensors_state + errors.sensor_correction() + sensor_offset;
    take_trusted(readings);
  }

  void take_trusted(VectorXd& readings) const {
    for (Index s = 0; s < readings.size(); ++s) {
      if (std::isfinite(reading_K[s]) && trusted(s)) readings[s] = reading_K[s];
    }
  }

  using UniformStart = ErrorModel::UniformStart;

  /// Of a rested machine sensors agree in the middle; one at work rests on the coldest of them, or on the air.
  /// @param without  a sensor that is left out
  std::vector<UniformStart> uniform_starts(Index without = -1) const {
    std::vector<double> known;
    for (const ErrorModel::FirstReading& reading : first_readings(0.0, without)) known.push_back(reading.value);
    const double middle = median(known), lowest = *std::min_element(known.begin(), known.end());
    std::vector<double> distances;
    for (const double value : known) distances.push_back(std::abs(value - middle));
    const auto std_of = [](double distance) { return std::max(least_start_K, distance); };
    std::vector<UniformStart> offered{{middle, std_of(1.5 * median(distances))},
                                      {lowest, std_of(0.25 * (middle - lowest))}};
    if (const int air = operating.channels().index("air.T_C"); air >= 0 && std::isfinite(row[air])) {
      const double surroundings = row[air] - model.machine.reference_C;
      offered.push_back({surroundings, std_of(start_uniform_K + 0.25 * std::abs(lowest - surroundings))});
    }
    return offered;
  }

  UniformStart uniform_start() const {
    UniformStart best{0.0, start_uniform_K};
    double most = -std::numeric_limits<double>::infinity();
    for (const UniformStart& start : uniform_starts()) {
      const double evidence = errors.start_evidence(start.std, first_readings(start.middle));
      if (evidence <= most) continue;
      best = start;
      most = evidence;
    }
    return best;
  }

  /// Of the sensors that gave one and are trusted, without their own offsets. @param zero  K  @param without  left out
  std::vector<ErrorModel::FirstReading> first_readings(double zero, Index without = -1) const {
    std::vector<ErrorModel::FirstReading> readings;
    for (Index s = 0; s < std::ssize(model.machine.sensors); ++s)
      if (s != without && std::isfinite(reading_K[s]) && trusted(s))
        readings.push_back({s, reading_K[s] - sensor_offset[s] - zero});
    return readings;
  }

  /// Sensors whose first reading a machine at work may have, by what all others read: (sensors) 1 or 0.
  std::vector<char> explained_by_others() const {
    std::vector<char> explained(reading_K.size(), 0);
    const std::vector<ErrorModel::FirstReading> readings = first_readings(0.0);
    if (readings.size() < 3) return explained;
    // A part that work has not reached is as warm as what surrounds it.
    double coldest = sensors_state.head(std::ssize(model.machine.sensors)).mean(), warmest = coldest;
    for (const mesh::AmbientSpec& ambient : model.machine.ambients) {
      const double value = row[operating.channels().index(ambient.id + ".T_C")] - model.machine.reference_C;
      if (!std::isfinite(value)) continue;
      coldest = std::min(coldest, value);
      warmest = std::max(warmest, value);
    }
    for (const ErrorModel::FirstReading& reading : readings) {
      char& one = explained[reading.sensor];
      one = reading.value > coldest - start_uniform_K && reading.value < warmest + start_uniform_K;
      if (one != 0) continue;
      const double chance =
          errors.first_reading_chance(uniform_starts(reading.sensor), first_readings(0.0, reading.sensor), reading);
      one = chance > least_chance;
    }
    return explained;
  }

  void start(double at) {
    const bool by_sensors = options.start_from_sensors && !first_readings(0.0).empty();
    UniformStart uniform{0.0, start_uniform_K};
    errors.work_ends_at(row);
    VectorXd ambient_gap = VectorXd::Zero(std::ssize(model.machine.ambients));
    const auto start_uniformly = [&] {
      uniform = uniform_start();
      set_state(model.system.one_kelvin * uniform.middle);
      for (Index i = 0; i < ambient_gap.size(); ++i) {
        // An input that stands at its default is one that nobody gives.
        const int channel = operating.channels().index(model.machine.ambients[i].id + ".T_C");
        const double standard = operating.channels().defaults()[channel];
        if (row[channel] == standard) ambient_gap[i] = uniform.middle + model.machine.reference_C - standard;
      }
    };
    if (by_sensors) {
      start_uniformly();
      monitor.explain_first(explained_by_others());
    }
    time = step_end = corrected_at = started_at = at;
    watch_sensors(sensors_state);
    if (by_sensors && !first_readings(0.0).empty()) start_uniformly();  // without those that are off
    sensors_start = sensors_state;
    predicted_K = sensors_state;
    VectorXd readings = sensors_state + sensor_offset;
    take_trusted(readings);
    const VectorXd outlet =
        solver::chiller_set_points(model.machine, model.system.layout, readings, operating.guide_K(row));
    chiller.emplace(model.machine, model.system.layout, operating.channels(), outlet);
    operating.coefficients(row, outlet, readings, coefficients);
    const std::vector<ErrorModel::FirstReading> readings_now =
        by_sensors ? first_readings(uniform.middle) : std::vector<ErrorModel::FirstReading>{};
    errors.start(uniform.std, readings_now, ambient_gap);
    innovations.clear();
    for (const ErrorModel::FirstReading& reading : readings_now)
      innovations.push_back({reading.sensor, reading.value, 1.0, reading.value});
    if (!innovations.empty()) errors.update(innovations, 0.0);
    ErrorModel::Interval ahead;
    ahead.duration = std::min(options.step_s, options.correction_s);
    ahead.operator_matrix = operator_at(coefficients.p);
    errors.foresee(ahead);
    started = true;
    after_correction();
  }

  /// K0 + sum p K
  MatrixXd operator_at(const VectorXd& p) const {
    MatrixXd matrix = model.system.conduction;
    for (Index j = 0; j < p.size(); ++j) matrix += p[j] * model.system.terms[j];
    return matrix;
  }

  void after_correction() {
    const VectorXd expected = bias_K + (step_end - corrected_at) * bias_rate;
    bias_K = errors.sensor_correction();
    bias_rate = errors.sensor_correction_rate();
    unsure_rate = errors.sensor_rate_std() + rate_error_share * bias_rate.cwiseAbs();
    correction_rate = errors.correction_rate();
    corrected_at = step_end;
    monitor.correct(bias_K - expected);
    set_corrected();
    if (!errors.learns()) {
      map.set_covariance(errors.directions(), errors.covariance());
      return;
    }
    const Index quantities = errors.directions().cols(), outputs = errors.first_output(),
                count = errors.all_covariance().rows() - outputs;
    MatrixXd covariance(quantities + count, quantities + count);
    const MatrixXd& all = errors.all_covariance();
    covariance.topLeftCorner(quantities, quantities) = all.topLeftCorner(quantities, quantities);
    covariance.topRightCorner(quantities, count) = all.block(0, outputs, quantities, count);
    covariance.bottomLeftCorner(count, quantities) = all.block(outputs, 0, count, quantities);
    covariance.bottomRightCorner(count, count) = all.bottomRightCorner(count, count);
    map.set_covariance(errors.directions(), covariance, base);
  }

  solver::TcpError tcp(const mesh::Pose& pose) const {
    if (base.tool.size() == 0) return {solver::Vector6::Zero(), solver::Vector6::Zero(), solver::Vector6::Zero()};
    solver::TcpError error = map.tcp(base, slope, share_ahead(), pose);
    if (!errors.learns()) return error;
    const ErrorModel::OutputShares shares = errors.output_shares();
    for (int i = 0; i < 3; ++i) {
      error.tool[i] *= 1.0 + shares.tool[i];
      error.table[i] *= 1.0 + shares.table[i];
      error.error[i] = error.tool[i] - error.table[i] + shares.rest[i];
    }
    return error;
  }

  void set_corrected() {
    corrected = state + errors.correction() + (step_end - corrected_at) * correction_rate;
    map.project(corrected, base);
  }

  /// Moves the state on by one step in which the row stands.
  void advance(const VectorXd& mean, double duration) {
    guide_readings(predicted_K);
    const VectorXd& outlet = chiller->advance(mean, predicted_K, operating.guide_K(mean), duration);
    operating.coefficients(mean, outlet, predicted_K, coefficients);
    before = state;
    stepper.advance(state, coefficients, duration);
    change = state - before;
    last_step = duration;
    sensors_change = -sensors_state;
    sensors_state.noalias() = model.system.sensors * state;
    sensors_change += sensors_state;

    if (interval.duration == 0.0) first_p = coefficients.p;
    p_changed = p_changed || coefficients.p != first_p;
    interval.duration += duration;
    interval.p += duration * coefficients.p;
    interval.q += duration * coefficients.q;
    interval.state += (0.5 * duration) * (before + state);
    operator_sum += duration * stepper.operator_matrix();
  }

  /// Ends the step of the state at the last row's time.
  void close_step() {
    constexpr double nothing = 1e-6;  // s: no heat flows, but a step's matrix would overflow
    const double duration = inputs.duration();
    const VectorXd& mean = inputs.take();
    if (duration < nothing) {
      step_end = time;
      return;
    }
    const int parts = std::max(1, static_cast<int>(std::ceil(duration / options.step_s * (1.0 - 1e-9))));
    const double part = rounded(duration / parts);
    for (int i = 0; i < parts; ++i) {
      // A row that lasts for hours is no reason for sensitivities in one step.
      if (interval.duration >= correction_after()) correct();
      advance(mean, part);
      step_end += part;
    }
    step_end = time;
    errors.show(duration);
    set_corrected();
    map.project(change + last_step * correction_rate, slope);
  }

  void advance_errors() {
    const double duration = interval.duration;
    // Equal coefficients stay equal to the last bit, so that their factor is found again.
    if (p_changed) {
      interval.p /= duration;
    } else {
      interval.p = coefficients.p;
    }
    interval.q /= duration;
    interval.state /= duration;
    interval.operator_matrix = p_changed ? MatrixXd(operator_sum / duration) : stepper.operator_matrix();
    errors.advance(interval);
    whole.duration += duration;
    whole.p += duration * interval.p;
    whole.q += duration * interval.q;
    whole.state += duration * interval.state;
    reading_counts += innovation_count;
    clear_interval();
  }

  /// What work before has left changes fast at first: then the observer corrects at each end of a step.
  double correction_after() const {
    return std::min(options.correction_s, std::max(options.step_s, 0.25 * (step_end - started_at)));
  }

  void correct() {
    const double duration = interval.duration;
    innovations.clear();
    for (Index s = 0; s < reading_K.size(); ++s) {
      if (innovation_count[s] == 0) continue;
      const auto count = static_cast<double>(innovation_count[s]);
      innovations.push_back({s, innovation_sum[s] / count, std::clamp(moment_sum[s] / count / duration, 0.0, 1.0),
                             sensors_state[s] + bias_K[s] - sensors_start[s]});
    }
    advance_errors();
    shift = errors.sensor_correction();
    if (!innovations.empty()) {
      errors.update(innovations, duration);
      watch_drift();
    }
    after_correction();
  }

  void probe(const mesh::Pose& pose, const Eigen::Vector3d& error, double std) {
    if (!started) throw core::InputError("compensator probe", "no row yet", "probing after the first row");
    constexpr double largest_um = 1e5;
    for (const double value : error) {
      if (std::abs(value) > largest_um)
        throw core::InputError("compensator probe", fmt::format("{} um", value),
                               fmt::format("at most {} um, or NaN", largest_um));
    }
    if (!(std >= 1e-3 && std <= largest_um))
      throw core::InputError("compensator probe std_um", fmt::format("{}", std),
                             fmt::format("0.001 to {}", largest_um));
    if (!error.array().isFinite().any()) return;
    if (interval.duration > 0.0) correct();  // sensitivities of now
    ErrorModel::ErrorRows rows;
    map.rows(pose, rows.tool, rows.table);
    const double all = std::hypot(std * core::units::um, model_error);
    errors.learn(rows, state + share_ahead() * change, error * core::units::um, all);
    for (const double value : error) probed += std::isfinite(value);
    after_correction();
  }

  Detectability detectability() const {
    if (!(whole.duration > 0.0))
      throw core::InputError("detectability", "no step of the thermal state has ended", "a run of some minutes");
    ErrorModel::Interval mean = whole;
    mean.p /= whole.duration;
    mean.q /= whole.duration;
    mean.state /= whole.duration;
    const MatrixXd matrix = operator_at(mean.p);
    const auto sensors = std::ssize(model.machine.sensors);
    std::vector<ErrorModel::State> constants;
    const std::vector<ErrorModel::State> known = errors.states();
    for (Index k = 0; k < errors.machine_quantities(); ++k) constants.push_back(known[k]);
    const Index first = errors.directions().cols();
    for (Index s = 0; s < sensors; ++s) constants.push_back(known[first + s]);
    VectorXd deviations(sensors);
    for (Index s = 0; s < sensors; ++s)
      deviations[s] = reading_counts[s] > 0 && !drift.drifts(s) ? errors.reading_std(s, 0.0) : solver::not_given;
    return compensation::detectability(model.system.capacity, matrix, errors.rates(mean),
                                       model.system.sensors.topRows(sensors), constants, deviations);
  }

  void add_readings() {
    const double ahead = last_step > 0.0 ? (time - step_end) / last_step : 0.0;
    const double moment = interval.duration + (time - step_end);
    watch_sensors(sensors_state + ahead * sensors_change + bias_K + (time - corrected_at) * bias_rate);
    for (Index s = 0; s < reading_K.size(); ++s) {
      if (!trusted(s)) continue;
      innovation_sum[s] += reading_K[s] - sensor_offset[s] - sensors_state[s] - ahead * sensors_change[s];
      moment_sum[s] += moment;
      ++innovation_count[s];
    }
  }

  double share_ahead() const { return last_step > 0.0 ? std::min(1.0, (time - step_end) / last_step) : 0.0; }

  void write_offsets(bool missing_input) {
    const mesh::Pose pose = operating.pose(row);
    const VectorXd offset = map.offsets(tcp(pose));
    const VectorXd variance = map.variance(pose);
    const double share_not_estimated = errors.learns() ? probed_error_share : offset_error_share;
    const VectorXd wanted_um = offset / core::units::um;
    const double motion_um = started_guard ? limits.motion_um(guarded_pose, pose, time - offsets.time) : 0.0;
    offsets.offset_um = guard.step(time, wanted_um, motion_um);
    started_guard = true;
    guarded_pose = pose;
    offsets.time = time;
    bool held_back = false, has_failed = false;
    for (Index a = 0; a < offset.size(); ++a) {
      const double share = share_not_estimated * offset[a];
      const double deviation_um = std::sqrt(variance[a] + share * share + model_error * model_error) / core::units::um;
      const double back_um = wanted_um[a] - offsets.offset_um[a];
      has_failed = has_failed || !std::isfinite(deviation_um) || !std::isfinite(back_um);
      held_back = held_back || std::abs(back_um) > deviation_um;
      offsets.std_um[a] = std::hypot(deviation_um, back_um);
    }
    if (has_failed) offsets.std_um.setConstant(limits.largest_um);
    const bool sensed = reading_K.array().isFinite().any();
    offsets.status = has_failed                        ? Status::failed
                     : missing_input                   ? Status::input_missing
                     : map.outside(pose)               ? Status::outside_workspace
                     : !sensed && !check.any_sensor()  ? Status::no_sensors
                     : !offsets.failed_sensors.empty() ? Status::sensor_failed
                     : held_back                       ? Status::limited
                                                       : Status::ok;
  }

  const Offsets& step(double at, const VectorXd& told, const VectorXd& sensors_C) {
    if (told.size() != row.size()) {
      throw core::InputError("compensator row", fmt::format("{} values", told.size()),
                             fmt::format("{}, one for each channel", row.size()));
    }
    const auto sensors = std::ssize(model.machine.sensors);
    if (sensors_C.size() != 0 && sensors_C.size() != sensors) {
      throw core::InputError("compensator sensors", fmt::format("{} readings", sensors_C.size()),
                             fmt::format("none or {}, one for each sensor", sensors));
    }
    if (!std::isfinite(at) || (started && !(at > time))) {
      throw core::InputError("compensator time",
                             started ? fmt::format("{} s after {} s", at, time) : fmt::format("{} s", at),
                             "times that rise from row to row");
    }
    if (started && at - time > longest_gap_s) {
      throw core::InputError("compensator time", fmt::format("{} s after {} s", at, time),
                             fmt::format("rows at most {} s apart", longest_gap_s));
    }
    given = told;
    check.take_out_inputs(given);
    name_failed_inputs();
    bool missing_input = check.any_input();
    const VectorXd& defaults = operating.channels().defaults();
    row_before = row;
    operating.channels().update(given, row);
    inputs_leapt =
        started && std::any_of(leaping.begin(), leaping.end(), [&](int k) {
          return std::abs(row[k] - row_before[k]) > leap_share * std::max(std::abs(row[k]), std::abs(row_before[k]));
        });
    for (Index k = 0; k < given.size(); ++k) {
      if (!std::isnan(given[k])) {
        given_at[k] = at;
      } else {
        // The last value holds for a while; then it is no longer news.
        missing_input = missing_input || (!std::isnan(defaults[k]) && at - given_at[k] > options.correction_s);
      }
    }
    const bool sensing = options.use_sensors && sensors_C.size() > 0;
    if (sensing)
      reading_C = sensors_C;
    else
      reading_C.setConstant(sensors, solver::not_given);
    check.take_out_sensors(reading_C, row);
    // What coefficients follow beside the sensors is never measured.
    for (Index s = 0; s < sensors; ++s) reading_K[s] = reading_C[s] - model.machine.reference_C;

    if (!started) {
      start(at);
    } else {
      const double duration = at - time;
      // What came before this row is closed first if both together would be too long a step.
      if (inputs.duration() > 0.0 && inputs.duration() + duration > options.step_s * (1.0 + 1e-9)) {
        close_step();
        if (interval.duration >= correction_after()) correct();
      }
      time = at;
      inputs.add(row, duration);
      if (inputs.duration() >= options.step_s * (1.0 - 1e-9)) close_step();
      add_readings();
      if (step_end == time && interval.duration >= correction_after()) correct();
    }
    write_offsets(missing_input);
    return offsets;
  }
};

Compensator::Compensator(const reduction::ReducedModel& model, const CompensatorOptions& options) {
  const auto require_duration = [](const char* name, double value) {
    if (!(value >= 1e-3 && value <= 86400.0))
      throw core::InputError(std::string("compensator ") + name, fmt::format("{}", value), "0.001 s to 86400 s");
  };
  require_duration("step_s", options.step_s);
  require_duration("correction_s", options.correction_s);
  const auto require_limit = [](const char* name, double value, double low, double high) {
    if (!(value == 0.0 || (value >= low && value <= high)))
      throw core::InputError(std::string("compensator ") + name, fmt::format("{}", value),
                             fmt::format("{} to {}, or 0 (by the model)", low, high));
  };
  require_limit("largest_um", options.largest_um, 1e-3, largest_offset_um);
  require_limit("rate_um_s", options.rate_um_s, least_rate_um_s, largest_rate_um_s);
  work_ = std::make_unique<Work>(model, options);
}
Compensator::~Compensator() = default;
Compensator::Compensator(Compensator&&) noexcept = default;

const solver::Channels& Compensator::channels() const { return work_->operating.channels(); }
const std::vector<std::string>& Compensator::axes() const { return work_->map.axes(); }
const OffsetLimits& Compensator::limits() const { return work_->limits; }

const Offsets& Compensator::step(double time, const Eigen::VectorXd& row, const Eigen::VectorXd& sensors_C) {
  return work_->step(time, row, sensors_C);
}

solver::TcpError Compensator::tcp(const mesh::Pose& pose) const { return work_->tcp(pose); }

void Compensator::probe(const mesh::Pose& pose, const Eigen::Vector3d& error_um, double std_um) {
  work_->probe(pose, error_um, std_um);
}

void Compensator::probe_compensated(const mesh::Pose& pose, const Eigen::Vector3d& left_um,
                                    const Eigen::VectorXd& applied_um, double std_um) {
  work_->probe(pose, left_um - work_->map.motion(applied_um), std_um);
}

long Compensator::probed() const { return work_->probed; }
std::vector<ErrorModel::State> Compensator::learned() const { return work_->errors.states(); }
Detectability Compensator::detectability() const { return work_->detectability(); }

mesh::Pose Compensator::pose() const { return work_->operating.pose(work_->row); }
const Eigen::VectorXd& Compensator::state() const { return work_->corrected; }

Eigen::VectorXd Compensator::predicted_sensors_C() const {
  const Work& work = *work_;
  return (work.sensors_state + work.share_ahead() * work.sensors_change + work.shift + work.sensor_offset).array() +
         work.model.machine.reference_C;
}

}  // namespace thermotwin::compensation
