// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/error_model.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double hour = 3600.0;
// Even a stated certainty leaves the mesh and the laws' form: shares of the nominal.
constexpr double least_source = 0.02, least_film = 0.03, least_contact = 0.05, least_wall = 0.05, least_flow = 0.02;
constexpr double air_std_K = 0.2, ambient_std_K = 0.3, inlet_std_K = 0.2;
constexpr double machine_memory = 200.0 * hour, air_memory = 6.0 * hour, ambient_memory = 24.0 * hour;
constexpr double correlation_s = 1800.0;      ///< of what the model gets wrong at a sensor
constexpr double model_error_share = 0.03, model_error_K = 0.01, noise_share = 0.3;
constexpr double outlier = 4.0;               ///< standard deviations
constexpr Index start_mode_count = 10;

double share(const core::Uncertain& nominal, double least) { return std::max(nominal.std_percent / 100.0, least); }

int root_ambient(const mesh::Machine& machine, int ambient) {
  for (std::size_t steps = 0; steps < machine.ambients.size(); ++steps) {
    const std::string& follows = machine.ambients[static_cast<std::size_t>(ambient)].follows;
    if (follows.empty()) break;
    for (std::size_t i = 0; i < machine.ambients.size(); ++i) {
      if (machine.ambients[i].id == follows) ambient = static_cast<int>(i);
    }
  }
  return ambient;
}

int ambient_index(const mesh::Machine& machine, const std::string& id) {
  for (std::size_t i = 0; i < machine.ambients.size(); ++i) {
    if (machine.ambients[i].id == id) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace

ErrorModel::ErrorModel(const reduction::ReducedModel& model) : model_(model) {
  const solver::Layout& layout = model.system.layout;
  inputs_of_term_.resize(layout.terms.size());
  for (std::size_t k = 0; k < layout.inputs.size(); ++k) {
    if (layout.inputs[k].term >= 0) inputs_of_term_[static_cast<std::size_t>(layout.inputs[k].term)].push_back(static_cast<int>(k));
  }
  add_machine_quantities();
  add_ambient_quantities();
}

void ErrorModel::add_machine_quantities() {
  const mesh::Machine& machine = model_.machine;
  const solver::Layout& layout = model_.system.layout;
  const auto terms_of = [&](solver::TermKind kind, std::size_t item, int part) {
    std::vector<int> terms;
    for (std::size_t t = 0; t < layout.terms.size(); ++t) {
      const solver::Term& term = layout.terms[t];
      if (term.kind == kind && term.item == static_cast<int>(item) && (part < 0 || term.part == part)) terms.push_back(static_cast<int>(t));
    }
    return terms;
  };
  const auto add_terms = [&](double std, std::vector<int> terms) {
    if (!terms.empty()) quantities_.push_back({std, machine_memory, std::move(terms), {}, {}, -1});
  };
  for (std::size_t i = 0; i < machine.sources.size(); ++i) {
    Quantity quantity{share(machine.sources[i].scale, least_source), machine_memory, {}, {}, {}, -1};
    for (std::size_t k = 0; k < layout.inputs.size(); ++k) {
      const solver::Input& input = layout.inputs[k];
      if (input.kind == solver::InputKind::source && input.item == static_cast<int>(i)) quantity.inputs.push_back(static_cast<int>(k));
    }
    if (!quantity.inputs.empty()) quantities_.push_back(std::move(quantity));
  }
  for (std::size_t i = 0; i < machine.films.size(); ++i) {
    add_terms(share(machine.films[i].coefficient, least_film), terms_of(solver::TermKind::film, i, -1));
  }
  for (std::size_t i = 0; i < machine.joints.size(); ++i) {
    add_terms(share(machine.joints[i].conductance, least_contact), terms_of(solver::TermKind::contact, i, -1));
  }
  for (std::size_t i = 0; i < machine.coolants.size(); ++i) {
    const mesh::CoolantSpec& coolant = machine.coolants[i];
    for (std::size_t s = 0; s < coolant.segments.size(); ++s) {
      add_terms(share(coolant.segments[s].film_coefficient, least_wall), terms_of(solver::TermKind::coolant_wall, i, static_cast<int>(s)));
    }
    add_terms(share(coolant.flow, least_flow), terms_of(solver::TermKind::coolant_flow, i, -1));
  }
}

void ErrorModel::add_ambient_quantities() {
  const mesh::Machine& machine = model_.machine;
  const solver::Layout& layout = model_.system.layout;
  std::vector<std::vector<int>> of_ambient(machine.ambients.size()), of_coolant(machine.coolants.size());
  for (std::size_t k = 0; k < layout.inputs.size(); ++k) {
    const solver::Input& input = layout.inputs[k];
    const auto item = static_cast<std::size_t>(input.item);
    int ambient = -1;
    if (input.kind == solver::InputKind::film_ambient) ambient = ambient_index(machine, machine.films[item].ambient);
    if (input.kind == solver::InputKind::contact_ambient) ambient = ambient_index(machine, machine.joints[item].ambient);
    if (ambient >= 0) of_ambient[static_cast<std::size_t>(root_ambient(machine, ambient))].push_back(static_cast<int>(k));
    if (input.kind == solver::InputKind::coolant_inlet) of_coolant[item].push_back(static_cast<int>(k));
  }
  for (std::size_t i = 0; i < machine.ambients.size(); ++i) {
    if (of_ambient[i].empty()) continue;
    const mesh::AmbientSpec& ambient = machine.ambients[i];
    const bool air = ambient.id == "air";
    // The air is measured, its stated default then does not matter; others mostly are not.
    const double std = air ? air_std_K : std::max(ambient_std_K, std::abs(ambient.default_C.value) * ambient.default_C.std_percent / 100.0);
    quantities_.push_back({std, air ? air_memory : ambient_memory, {}, {}, of_ambient[i], static_cast<int>(i)});
  }
  for (const std::vector<int>& inputs : of_coolant) {
    if (!inputs.empty()) quantities_.push_back({inlet_std_K, ambient_memory, {}, {}, inputs, -1});
  }
}

void ErrorModel::start(const solver::Coefficients& coefficients, double uniform_K, double shape_K, const VectorXd& ambient_gap_K) {
  const reduction::ReducedSystem& system = model_.system;
  const Index order = system.order(), sensors = system.sensors.rows(), machine = static_cast<Index>(quantities_.size());

  // Slowest modes of the symmetric part: what a machine that was used before still carries.
  MatrixXd conduction = system.conduction;
  for (Index j = 0; j < coefficients.p.size(); ++j) {
    if (coefficients.p[j] != 0.0) conduction += coefficients.p[j] * system.terms[static_cast<std::size_t>(j)];
  }
  const MatrixXd symmetric = 0.5 * (conduction + conduction.transpose());
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(symmetric, system.capacity);
  const Index shapes = std::min(start_mode_count, order);
  start_modes_ = 1 + shapes;

  directions_ = MatrixXd::Zero(order, machine + start_modes_);
  directions_.col(machine) = system.one_kelvin;
  const double kelvin = std::sqrt(system.one_kelvin.dot(system.capacity * system.one_kelvin));  // rms 1 K
  directions_.rightCols(shapes) = kelvin * modes.eigenvectors().leftCols(shapes);
  sensor_directions_ = system.sensors * directions_;
  last_sensor_directions_ = sensor_directions_;

  const Index all = machine + start_modes_ + sensors;
  prior_.resize(all);
  memory_ = VectorXd::Zero(all);
  for (Index k = 0; k < machine; ++k) {
    prior_[k] = quantities_[static_cast<std::size_t>(k)].std;
    memory_[k] = quantities_[static_cast<std::size_t>(k)].memory;
  }
  prior_[machine] = uniform_K;
  prior_.segment(machine + 1, shapes).setConstant(shape_K);
  constexpr double no_sensor_K = 1e-6;  // what is observed beside the sensors has no offset
  for (Index s = 0; s < sensors; ++s) {
    const auto i = static_cast<std::size_t>(s);
    prior_[machine + start_modes_ + s] = i < model_.machine.sensors.size() ? model_.machine.sensors[i].uncertainty : no_sensor_K;
  }
  memory_.tail(sensors).setConstant(machine_memory);
  mean_ = VectorXd::Zero(all);
  for (Index k = 0; k < machine; ++k) {
    const int ambient = quantities_[static_cast<std::size_t>(k)].ambient;
    if (ambient < 0) continue;
    mean_[k] = 0.5 * ambient_gap_K[ambient];
    prior_[k] = std::hypot(prior_[k], mean_[k]);
  }
  theta_ = mean_;
  sigma_ = prior_.cwiseAbs2().asDiagonal();
  factor_duration_ = 0.0;
}

void ErrorModel::advance(const Interval& interval) {
  const reduction::ReducedSystem& system = model_.system;
  const double h = interval.duration;
  const Index machine = static_cast<Index>(quantities_.size());
  // The true state is nearer to the corrected one than to the nominal one.
  const VectorXd state = interval.state + correction();

  MatrixXd right = system.capacity * directions_;
  VectorXd rate(system.order());
  for (Index k = 0; k < machine; ++k) {
    const Quantity& quantity = quantities_[static_cast<std::size_t>(k)];
    rate.setZero();
    const auto add_input = [&](int input, double amount) {
      if (amount != 0.0) rate += amount * system.inputs.col(input);
    };
    for (const int term : quantity.terms) {
      if (interval.p[term] == 0.0) continue;
      const MatrixXd& matrix = system.terms[static_cast<std::size_t>(term)];
      if (system.layout.terms[static_cast<std::size_t>(term)].kind == solver::TermKind::coolant_flow) {
        rate.noalias() -= interval.p[term] * (matrix * state);
      } else {
        rate.noalias() -= interval.p[term] * (matrix.selfadjointView<Eigen::Lower>() * state);  // half the memory
      }
      for (const int input : inputs_of_term_[static_cast<std::size_t>(term)]) add_input(input, interval.q[input]);
    }
    for (const int input : quantity.inputs) add_input(input, interval.q[input]);
    for (const int input : quantity.ambient_inputs) add_input(input, interval.p[system.layout.inputs[static_cast<std::size_t>(input)].term]);
    right.col(k) += h * rate;
  }
  // Backward Euler: first order is enough for a sensitivity, and it damps what it does not resolve.
  if (factor_duration_ != h || factor_p_ != interval.p) {
    factor_.compute(system.capacity + h * interval.operator_matrix);
    factor_duration_ = h;
    factor_p_ = interval.p;
  }
  directions_.noalias() = factor_.solve(right);
  last_sensor_directions_ = sensor_directions_;
  sensor_directions_.noalias() = system.sensors * directions_;
  fade(h);
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
  const double noise = noise_share * model_.machine.sensors[static_cast<std::size_t>(sensor)].uncertainty;
  const double model = model_error_K + model_error_share * std::abs(deviation_K);
  return std::sqrt(noise * noise + model * model);
}

void ErrorModel::update(const std::vector<Innovation>& innovations, double independent_s) {
  const Index biases = directions_.cols();
  const double inflation = independent_s > 0.0 ? std::max(1.0, correlation_s / independent_s) : 1.0;
  VectorXd row(theta_.size()), gain(theta_.size());
  for (const Innovation& innovation : innovations) {
    row.setZero();
    row.head(biases) = (1.0 - innovation.moment) * last_sensor_directions_.row(innovation.sensor) +
                       innovation.moment * sensor_directions_.row(innovation.sensor);
    row[biases + innovation.sensor] = 1.0;
    gain.noalias() = sigma_ * row;
    const double residual = innovation.value - row.dot(theta_);
    const double std = reading_std(innovation.sensor, innovation.deviation_K);
    double variance = row.dot(gain) + std * std * inflation;
    const double far = residual * residual / (outlier * outlier * variance);
    if (far > 1.0) variance *= far;
    gain /= std::sqrt(variance);
    theta_ += gain * (residual / std::sqrt(variance));
    sigma_.noalias() -= gain * gain.transpose();
  }
  sigma_ = (0.5 * (sigma_ + sigma_.transpose())).eval();
  // Beyond three standard deviations the first-order picture ends; a share of -1 would be no machine.
  for (Index k = 0; k < static_cast<Index>(quantities_.size()); ++k) {
    theta_[k] = std::clamp(theta_[k], mean_[k] - 3.0 * prior_[k], mean_[k] + 3.0 * prior_[k]);
  }
}

VectorXd ErrorModel::sensor_correction() const {
  return sensor_directions_ * theta_.head(directions_.cols()) + theta_.tail(sensor_directions_.rows());
}

}  // namespace thermotwin::compensation
