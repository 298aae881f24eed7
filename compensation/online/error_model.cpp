// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/error_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "compensation/online/error_states.h"
#include "core/units.h"
#include "solver/operation/layout.h"
#include "solver/operation/operating_model.h"

namespace thermotwin::compensation {
namespace {

using core::units::hour;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double untold_air_K = 2.0;          ///< standard deviation of the air where nobody tells it
constexpr double correlation_s = 1800.0;      ///< of what the model gets wrong at a sensor
constexpr double untold_memory = 2.0 * hour;  ///< of how fast a drive runs that nobody tells
constexpr double outlier = 4.0;               ///< standard deviations
// What probing may find beside the thermal state: expansions and scales, and what no model has.
constexpr double expansion_share = 0.03, rest_m = 0.8e-6;
constexpr double expansion_memory = 2000.0 * hour, rest_memory = 12.0 * hour;
constexpr double showing_s = 300.0;  ///< time constant with which new findings come into effect

}  // namespace

ErrorModel::ErrorModel(const reduction::ReducedModel& model)
    : model_(model),
      quantities_(uncertain_quantities(model)),
      inputs_of_term_(inputs_of_terms(model)),
      work_before_(model, ambients_of(quantities_)) {
  const solver::OperatingModel operating(model.machine, model.system.layout);
  for (DriveHeat& drive : drive_heats(model, operating, operating.channels().defaults()))
    if (drive.channel >= 0 && drive.heat.squaredNorm() > 0.0) drives_.push_back(std::move(drive));
  untold_.resize(drives_.size());
}

/// The quantities that are an ambient's temperature.
std::vector<WorkBefore::Ambient> ErrorModel::ambients_of(const std::vector<Quantity>& quantities) {
  std::vector<WorkBefore::Ambient> ambients;
  for (const Quantity& quantity : quantities) {
    if (quantity.ambient >= 0) ambients.push_back({quantity.ambient, quantity.ambient_inputs});
  }
  return ambients;
}

void ErrorModel::start(double uniform_K, const std::vector<FirstReading>& readings, const VectorXd& ambient_gap_K) {
  const reduction::ReducedSystem& system = model_.system;
  const Index order = system.order(), sensors = system.sensors.rows(), machine = std::ssize(quantities_);

  const MatrixXd patterns = rested_ ? MatrixXd(order, 0) : work_before_.patterns(uniform_K, readings);
  const Index shapes = patterns.cols();
  start_modes_ = 1 + shapes;

  directions_ = MatrixXd::Zero(order, machine + start_modes_);
  directions_.col(machine) = system.one_kelvin;
  directions_.rightCols(shapes) = patterns;
  sensor_directions_ = system.sensors * directions_;
  last_sensor_directions_ = sensor_directions_;
  start_rate_ = MatrixXd::Zero(order, start_modes_);
  sensor_start_rate_ = MatrixXd::Zero(sensors, start_modes_);
  sensor_rate_ = MatrixXd::Zero(sensors, machine + start_modes_);

  const Index all = machine + start_modes_ + sensors + outputs;
  prior_.resize(all);
  memory_ = VectorXd::Zero(all);
  for (Index k = 0; k < machine; ++k) {
    prior_[k] = quantities_[k].std;
    memory_[k] = quantities_[k].memory;
  }
  prior_[machine] = uniform_K;
  prior_.segment(machine + 1, shapes).setOnes();
  constexpr double no_sensor_K = 1e-6;  // what is observed beside the sensors has no offset
  for (Index s = 0; s < sensors; ++s) {
    const std::size_t i = s;
    prior_[machine + start_modes_ + s] =
        i < model_.machine.sensors.size() ? model_.machine.sensors[i].uncertainty : no_sensor_K;
  }
  memory_.segment(machine + start_modes_, sensors).setConstant(machine_memory_s);
  // Unknown to sensors: they come to life with the first probing.
  prior_.tail(outputs).setZero();
  memory_.tail(outputs).head(outputs - 3).setConstant(expansion_memory);
  memory_.tail(3).setConstant(rest_memory);
  learns_ = false;
  withheld_ = VectorXd::Zero(all);
  mean_ = VectorXd::Zero(all);
  for (Index k = 0; k < machine; ++k) {
    const int ambient = quantities_[k].ambient;
    if (ambient < 0) continue;
    mean_[k] = 0.5 * ambient_gap_K[ambient];
    prior_[k] = std::hypot(prior_[k], mean_[k]);
  }
  theta_ = mean_;
  sigma_ = prior_.cwiseAbs2().asDiagonal();
  factor_duration_ = 0.0;
}

MatrixXd ErrorModel::rates(const Interval& interval) const {
  // The true state is nearer to the corrected one than to the nominal one.
  const VectorXd state = interval.state + directions_ * theta_.head(directions_.cols());
  MatrixXd result = quantity_rates(model_, quantities_, inputs_of_term_, interval.p, interval.q, state);
  for (Index k = 0; k < result.cols(); ++k) {
    const Index drive = quantities_[k].drive;
    if (drive >= 0 && untold_[drive].heat.size() > 0) result.col(k) += untold_[drive].heat;
  }
  return result;
}

void ErrorModel::doubt(Index sensor, double std_K) {
  const Index k = directions_.cols() + sensor;
  if (!(std_K > prior_[k])) return;
  prior_[k] = std_K;
  memory_[k] = 0.0;
  sigma_(k, k) = std_K * std_K;
}

void ErrorModel::air_is_untold() {
  air_is_untold_ = true;
  const mesh::Machine& machine = model_.machine;
  for (Quantity& quantity : quantities_)
    if (quantity.ambient >= 0 && machine.ambients[quantity.ambient].id == "air") quantity.std = untold_air_K;
}

void ErrorModel::set_untold(Index drive, const VectorXd& heat, double nominal) {
  Untold& own = untold_[drive];
  if (heat.size() == 0 && own.heat.size() == 0) return;
  own.heat = heat;
  // Where nobody tells, it may start or stop at any time: x changes at E^-1 of its heat.
  own.rate = heat.size() == 0 ? VectorXd() : VectorXd(model_.system.sensors * model_.system.capacity.llt().solve(heat));
  if (own.quantity < 0) {
    own.quantity = machine_quantities();
    add_quantity({unrecorded_state(drives_[drive].name).name, "1", 1.0, untold_memory, {}, {}, {}, -1, drive});
  }
  Quantity& quantity = quantities_[own.quantity];
  quantity.least = -nominal;
  // What has come from it stays known while the drive is told again.
  quantity.memory = heat.size() > 0 ? untold_memory : machine_memory_s;
  if (theta_.size() > 0) memory_[own.quantity] = quantity.memory;
}

namespace {

template <class Vector>
Vector with_zero(const Vector& values, Index at) {
  Vector longer = Vector::Zero(values.size() + 1);
  longer.head(at) = values.head(at);
  longer.tail(values.size() - at) = values.tail(values.size() - at);
  return longer;
}

MatrixXd with_zero_column(const MatrixXd& values, Index at) {
  MatrixXd wider = MatrixXd::Zero(values.rows(), values.cols() + 1);
  wider.leftCols(at) = values.leftCols(at);
  wider.rightCols(values.cols() - at) = values.rightCols(values.cols() - at);
  return wider;
}

}  // namespace

/// After the others, before the start; nothing of the state has come from it so far.
void ErrorModel::add_quantity(Quantity quantity) {
  const Index at = std::ssize(quantities_);
  const double std = quantity.std, memory = quantity.memory;
  quantities_.push_back(std::move(quantity));
  if (theta_.size() == 0) return;  // start() makes room
  for (MatrixXd* columns : {&directions_, &sensor_directions_, &last_sensor_directions_, &sensor_rate_})
    *columns = with_zero_column(*columns, at);
  for (VectorXd* values : {&theta_, &prior_, &mean_, &memory_, &withheld_}) *values = with_zero(*values, at);
  sigma_ = with_zero_column(with_zero_column(sigma_, at).transpose(), at).eval();
  prior_[at] = std;
  memory_[at] = memory;
  sigma_(at, at) = std * std;
}

void ErrorModel::foresee(const Interval& interval) {
  const reduction::ReducedSystem& system = model_.system;
  const auto start = directions_.rightCols(start_modes_);
  const MatrixXd later = Eigen::PartialPivLU<MatrixXd>(system.capacity + interval.duration * interval.operator_matrix)
                             .solve(system.capacity * start);
  start_rate_ = (later - start) / interval.duration;
  sensor_start_rate_.noalias() = system.sensors * start_rate_;
  sensor_rate_.rightCols(start_modes_) = sensor_start_rate_;
}

void ErrorModel::advance(const Interval& interval) {
  const reduction::ReducedSystem& system = model_.system;
  const double h = interval.duration;
  MatrixXd right = system.capacity * directions_;
  right.leftCols(std::ssize(quantities_)) += h * rates(interval);
  // Backward Euler: first order is enough for a sensitivity, and it damps what it does not resolve.
  if (factor_duration_ != h || factor_p_ != interval.p) {
    factor_.compute(system.capacity + h * interval.operator_matrix);
    factor_duration_ = h;
    factor_p_ = interval.p;
  }
  start_rate_ = -directions_.rightCols(start_modes_) / h;
  directions_.noalias() = factor_.solve(right);
  start_rate_ += directions_.rightCols(start_modes_) / h;
  last_sensor_directions_ = sensor_directions_;
  sensor_directions_.noalias() = system.sensors * directions_;
  sensor_rate_ = (sensor_directions_ - last_sensor_directions_) / h;
  sensor_start_rate_ = sensor_rate_.rightCols(start_modes_);
  fade(h);
}

VectorXd ErrorModel::sensor_rate_std() const {
  const MatrixXd spread = sensor_rate_ * covariance();
  VectorXd variance = spread.cwiseProduct(sensor_rate_).rowwise().sum().cwiseMax(0.0);
  for (const Untold& drive : untold_) {
    if (drive.rate.size() > 0) variance += drive.rate.cwiseAbs2();
  }
  return variance.cwiseSqrt();
}

void ErrorModel::fade(double duration) {
  for (Index k = 0; k < theta_.size(); ++k) {
    if (memory_[k] <= 0.0) continue;
    const double keep = std::exp(-duration / memory_[k]);
    theta_[k] = mean_[k] + keep * (theta_[k] - mean_[k]);
    sigma_.row(k) *= keep;
    sigma_.col(k) *= keep;
    sigma_(k, k) += (1.0 - keep * keep) * prior_[k] * prior_[k];
  }
}

double ErrorModel::reading_std(Index sensor, double deviation_K) const {
  return compensation::reading_std(model_.machine.sensors[sensor].uncertainty, deviation_K);
}

void ErrorModel::observe(const VectorXd& row, double residual, double variance) {
  gain_.noalias() = sigma_ * row;
  variance += row.dot(gain_);
  const double far = residual * residual / (outlier * outlier * variance);
  if (far > 1.0) variance *= far;
  gain_ /= std::sqrt(variance);
  // A heat that may change at any time follows the readings, but keeps its deviation: its past says little of it.
  std::vector<Index> untold;
  for (const Untold& drive : untold_) {
    if (drive.heat.size() > 0) untold.push_back(drive.quantity);
  }
  sigma_.noalias() -= gain_ * gain_.transpose();
  if (!untold.empty()) sigma_(untold, untold) += gain_(untold) * gain_(untold).transpose();
  theta_ += gain_ * (residual / std::sqrt(variance));
}

void ErrorModel::update(const std::vector<Innovation>& innovations, double independent_s) {
  const Index biases = directions_.cols();
  const double inflation = independent_s > 0.0 ? std::max(1.0, correlation_s / independent_s) : 1.0;
  VectorXd row(theta_.size());
  for (const Innovation& innovation : innovations) {
    row.setZero();
    row.head(biases) = (1.0 - innovation.moment) * last_sensor_directions_.row(innovation.sensor) +
                       innovation.moment * sensor_directions_.row(innovation.sensor);
    row[biases + innovation.sensor] = 1.0;
    const double std = reading_std(innovation.sensor, innovation.deviation_K);
    observe(row, innovation.value - row.dot(theta_), std * std * inflation);
  }
  settle();
}

void ErrorModel::settle() {
  sigma_ = (0.5 * (sigma_ + sigma_.transpose())).eval();
  // Beyond three standard deviations the first-order picture ends; a share of -1 would be no machine.
  for (Index k = 0; k < std::ssize(quantities_); ++k) {
    theta_[k] = std::clamp(theta_[k], mean_[k] + quantities_[k].least * prior_[k], mean_[k] + 3.0 * prior_[k]);
  }
  for (Index k = first_output(); learns_ && k < theta_.size(); ++k)
    theta_[k] = std::clamp(theta_[k], -5.0 * prior_[k], 5.0 * prior_[k]);
}

void ErrorModel::learn(const ErrorRows& rows, const VectorXd& nominal, const Eigen::Vector3d& error, double std_m) {
  const Index quantities = directions_.cols(), first = first_output();
  if (!learns_) {
    prior_.tail(outputs).head(outputs - 3).setConstant(expansion_share);
    prior_.tail(3).setConstant(rest_m);
    sigma_.diagonal().tail(outputs) = prior_.tail(outputs).cwiseAbs2();
    learns_ = true;
  }
  const VectorXd before = theta_;
  VectorXd row(theta_.size());
  for (Index i = 0; i < 3; ++i) {
    if (!std::isfinite(error[i])) continue;
    // Linearised at what is known by now: products of shares and state are part of the prediction.
    const VectorXd state = nominal + directions_ * theta_.head(quantities);
    const double tool = rows.tool.row(i).dot(state), table = rows.table.row(i).dot(state);
    const double more_tool = 1.0 + theta_[first + i], more_table = 1.0 + theta_[first + 3 + i];
    row.setZero();
    row.head(quantities).noalias() = (more_tool * rows.tool.row(i) + more_table * rows.table.row(i)) * directions_;
    row[first + i] = tool;
    row[first + 3 + i] = table;
    row[first + 6 + i] = 1.0;
    observe(row, error[i] - more_tool * tool - more_table * table - theta_[first + 6 + i], std_m * std_m);
  }
  settle();
  withheld_ += theta_ - before;
}

ErrorModel::OutputShares ErrorModel::output_shares() const {
  const VectorXd now = shown().tail(outputs);
  return {now.head<3>(), now.segment<3>(3), now.tail<3>()};
}

void ErrorModel::show(double duration) { withheld_ *= std::exp(-duration / showing_s); }

ErrorModel::SensorOffset ErrorModel::offset(Index sensor) const {
  const Index k = directions_.cols() + sensor;
  const double prior = prior_[k] * prior_[k], rest = 1.0 - sigma_(k, k) / prior;
  constexpr double nothing = 1e-6;
  if (!(rest > nothing)) return {0.0, std::numeric_limits<double>::infinity()};
  return {theta_[k] / rest, std::sqrt(sigma_(k, k) / rest)};
}

ErrorModel::SensorOffset ErrorModel::own_offset(Index sensor) const {
  const Index k = directions_.cols() + sensor;
  return {theta_[k], std::sqrt(std::max(0.0, sigma_(k, k)))};
}

void ErrorModel::release(Index sensor) {
  const Index k = directions_.cols() + sensor;
  const double prior = prior_[k] * prior_[k];
  // Never more than a thousandfold: an offset that nothing else tells stays as it is.
  const double rest = std::max(prior - sigma_(k, k), 1e-3 * prior);
  const VectorXd column = sigma_.col(k);
  const VectorXd change = column * (theta_[k] / rest);
  theta_ += change;
  withheld_ += change;
  sigma_ += column * column.transpose() / rest;
  settle();
}

std::vector<ErrorModel::State> ErrorModel::states() const {
  std::vector<State> all;
  const Index machine = machine_quantities(), sensors = sensor_directions_.rows();
  for (Index k = 0; k < theta_.size(); ++k) {
    State state;
    if (k < machine) {
      state.name = quantities_[k].name;
      state.unit = quantities_[k].unit;
    } else if (k < machine + start_modes_) {
      state = start_state(k - machine);
    } else if (const Index s = k - machine - start_modes_; s < sensors) {
      if (s >= std::ssize(model_.machine.sensors)) continue;  // observed beside the sensors: no offset
      state = sensor_offset_state(model_.machine, s);
    } else {
      if (!learns_) break;
      state = output_state(s - sensors);
    }
    state.value = theta_[k];
    state.std = std::sqrt(std::max(0.0, sigma_(k, k)));
    state.prior_std = prior_[k];
    state.memory_s = memory_[k];
    all.push_back(std::move(state));
  }
  return all;
}

VectorXd ErrorModel::sensor_correction() const {
  const VectorXd now = shown();
  return sensor_directions_ * now.head(directions_.cols()) + now.segment(directions_.cols(), sensor_directions_.rows());
}

}  // namespace thermotwin::compensation
