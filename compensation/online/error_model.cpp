// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/error_model.h"

#include "solver/operation/layout.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

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
constexpr double correlation_s = 1800.0;  ///< of what the model gets wrong at a sensor
constexpr double model_error_share = 0.03, model_error_K = 0.01, noise_share = 0.3;
constexpr double outlier = 4.0;  ///< standard deviations
constexpr Index most_patterns = 16;
constexpr double least_pattern = 0.01;  ///< of the largest pattern
// What a machine did before: hours of work, hours since, size of its heat beside that of half speed.
constexpr double on_h[] = {0.5, 2.0, 6.0, 24.0}, idle_h[] = {0.0, 0.25, 1.0, 3.0, 8.0, 24.0};
constexpr Index kinds_of_work = 2 * std::ssize(on_h);  ///< columns of a heat: axes still or swept, hours of work
constexpr double unmeasured_start_K = 2.0;
constexpr double start_sizes[] = {0.03, 0.1, 0.3, 1.0, 3.0};
// What probing may find beside the thermal state: expansions and scales, and what no model has.
constexpr double expansion_share = 0.03, rest_m = 0.8e-6;
constexpr double expansion_memory = 2000.0 * hour, rest_memory = 12.0 * hour;
constexpr double showing_s = 300.0;  ///< time constant with which new findings come into effect

double share(const core::Uncertain& nominal, double least) { return std::max(nominal.std_percent / 100.0, least); }

int root_ambient(const mesh::Machine& machine, int ambient) {
  for (std::size_t steps = 0; steps < machine.ambients.size(); ++steps) {
    const std::string& follows = machine.ambients[ambient].follows;
    if (follows.empty()) break;
    for (std::size_t i = 0; i < machine.ambients.size(); ++i) {
      if (machine.ambients[i].id == follows) ambient = i;
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
    if (layout.inputs[k].term >= 0) inputs_of_term_[layout.inputs[k].term].push_back(k);
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
      if (term.kind == kind && term.item == static_cast<int>(item) && (part < 0 || term.part == part))
        terms.push_back(t);
    }
    return terms;
  };
  const auto add_terms = [&](const std::string& name, double std, std::vector<int> terms) {
    if (!terms.empty()) quantities_.push_back({name, "1", std, machine_memory, std::move(terms), {}, {}, -1});
  };
  for (std::size_t i = 0; i < machine.sources.size(); ++i) {
    Quantity quantity{"power of source " + machine.sources[i].id,
                      "1",
                      share(machine.sources[i].scale, least_source),
                      machine_memory,
                      {},
                      {},
                      {},
                      -1};
    for (std::size_t k = 0; k < layout.inputs.size(); ++k) {
      const solver::Input& input = layout.inputs[k];
      if (input.kind == solver::InputKind::source && input.item == static_cast<int>(i)) quantity.inputs.push_back(k);
    }
    if (!quantity.inputs.empty()) quantities_.push_back(std::move(quantity));
  }
  for (std::size_t i = 0; i < machine.films.size(); ++i) {
    add_terms("film " + machine.films[i].id, share(machine.films[i].coefficient, least_film),
              terms_of(solver::TermKind::film, i, -1));
  }
  for (std::size_t i = 0; i < machine.joints.size(); ++i) {
    add_terms("conductance of joint " + machine.joints[i].id, share(machine.joints[i].conductance, least_contact),
              terms_of(solver::TermKind::contact, i, -1));
  }
  for (std::size_t i = 0; i < machine.coolants.size(); ++i) {
    const mesh::CoolantSpec& coolant = machine.coolants[i];
    for (std::size_t s = 0; s < coolant.segments.size(); ++s) {
      add_terms("wall film of coolant " + coolant.id + ", segment " + coolant.segments[s].id,
                share(coolant.segments[s].film_coefficient, least_wall),
                terms_of(solver::TermKind::coolant_wall, i, s));
    }
    add_terms("flow of coolant " + coolant.id, share(coolant.flow, least_flow),
              terms_of(solver::TermKind::coolant_flow, i, -1));
  }
}

void ErrorModel::add_ambient_quantities() {
  const mesh::Machine& machine = model_.machine;
  const solver::Layout& layout = model_.system.layout;
  std::vector<std::vector<int>> of_ambient(machine.ambients.size()), of_coolant(machine.coolants.size());
  for (std::size_t k = 0; k < layout.inputs.size(); ++k) {
    const solver::Input& input = layout.inputs[k];
    const std::size_t item = input.item;
    int ambient = -1;
    if (input.kind == solver::InputKind::film_ambient) ambient = ambient_index(machine, machine.films[item].ambient);
    if (input.kind == solver::InputKind::contact_ambient)
      ambient = ambient_index(machine, machine.joints[item].ambient);
    if (ambient >= 0) of_ambient[root_ambient(machine, ambient)].push_back(k);
    if (input.kind == solver::InputKind::coolant_inlet) of_coolant[item].push_back(k);
  }
  for (std::size_t i = 0; i < machine.ambients.size(); ++i) {
    if (of_ambient[i].empty()) continue;
    const mesh::AmbientSpec& ambient = machine.ambients[i];
    const bool air = ambient.id == "air";
    // The air is measured, its stated default then does not matter; others mostly are not.
    const double std =
        air ? air_std_K
            : std::max(ambient_std_K, std::abs(ambient.default_C.value) * ambient.default_C.std_percent / 100.0);
    quantities_.push_back({"temperature of ambient " + ambient.id,
                           "K",
                           std,
                           air ? air_memory : ambient_memory,
                           {},
                           {},
                           of_ambient[i],
                           static_cast<int>(i)});
  }
  for (std::size_t i = 0; i < of_coolant.size(); ++i) {
    if (of_coolant[i].empty()) continue;
    quantities_.push_back({"inlet temperature of coolant " + machine.coolants[i].id,
                           "K",
                           inlet_std_K,
                           ambient_memory,
                           {},
                           {},
                           of_coolant[i],
                           -1});
  }
}

std::vector<MatrixXd> ErrorModel::left_behind(const VectorXd& row) const {
  const reduction::ReducedSystem& system = model_.system;
  const mesh::Machine& machine = model_.machine;
  const solver::OperatingModel operating(machine, system.layout);
  const solver::Channels& channels = operating.channels();
  const VectorXd inlet = VectorXd::Zero(std::ssize(machine.coolants));
  const auto set = [&](VectorXd row, const std::string& name, double value) {
    if (const int channel = channels.index(name); channel >= 0) row[channel] = value;
    return row;
  };
  const auto source_heat = [&](const VectorXd& row) {
    const solver::Coefficients c = operating.coefficients(row, inlet);
    VectorXd heat = VectorXd::Zero(system.order());
    for (std::size_t k = 0; k < system.layout.inputs.size(); ++k) {
      if (system.layout.inputs[k].kind == solver::InputKind::source) heat += c.q[k] * system.inputs.col(k);
    }
    return heat;
  };
  struct Modes {
    MatrixXd shapes;
    VectorXd decay;
  };
  const auto modes_of = [&](const solver::Coefficients& c) {
    MatrixXd conduction = system.conduction;
    for (Index j = 0; j < c.p.size(); ++j) {
      if (c.p[j] != 0.0) conduction += c.p[j] * system.terms[j];
    }
    const MatrixXd symmetric = 0.5 * (conduction + conduction.transpose());
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(symmetric, system.capacity);
    return Modes{modes.eigenvectors(), modes.eigenvalues().cwiseMax(0.0)};
  };
  // Causes, each of the size that a day's work has it: half speed, standing losses, some kelvin around.
  constexpr double half = 0.5, air_K = 2.0, other_K = 2.0;
  std::vector<VectorXd> heats;
  VectorXd rest = channels.defaults(), swept = rest;
  for (const mesh::Axis& axis : machine.axes) {
    const bool linear = axis.kind == mesh::AxisKind::linear;
    const std::string id = "axis." + axis.id + ".", unit = linear ? "mm" : "deg";
    const double to_unit = linear ? 1e3 : 180.0 / std::numbers::pi;
    const int position = channels.index(id + "position_" + unit);
    if (std::isfinite(row[position])) rest[position] = swept[position] = row[position];
    swept = set(set(swept, id + "low_" + unit, axis.low * to_unit), id + "high_" + unit, axis.high * to_unit);
  }
  VectorXd off = set(rest, "machine.on", 0.0);
  for (const mesh::CoolantSpec& coolant : machine.coolants) off = set(off, "coolant." + coolant.id + ".on", 0.0);
  const VectorXd resting = source_heat(rest);
  // Standing: its losses, and surroundings that are warmer than the hall.
  heats.push_back(system.inputs * operating.coefficients(rest, inlet).q - source_heat(off));
  heats.push_back(source_heat(set(rest, "spindle.speed_rpm", half * machine.spindle_max_rpm)) - resting);
  for (const mesh::Axis& axis : machine.axes) {
    const bool linear = axis.kind == mesh::AxisKind::linear;
    const double feed = half * axis.rapid * (linear ? 6e4 : 180.0 / std::numbers::pi * 60.0);
    heats.push_back(source_heat(set(rest, "axis." + axis.id + (linear ? ".feed_mm_min" : ".feed_deg_min"), feed)) -
                    resting);
  }
  const solver::Coefficients wet = operating.coefficients(set(rest, "cutting_fluid.on", 1.0), inlet);
  for (const Quantity& quantity : quantities_) {
    if (quantity.ambient < 0) continue;
    const double kelvin = machine.ambients[quantity.ambient].id == "air" ? air_K : other_K;
    VectorXd heat = VectorXd::Zero(system.order());
    for (const int input : quantity.ambient_inputs) {
      const int term = system.layout.inputs[input].term;
      heat += kelvin * wet.p[term] * system.inputs.col(input);
    }
    heats.push_back(std::move(heat));
  }
  // Axes stood where they stand now, or went from end to end: heat crossed the joints elsewhere.
  const Modes at_work[] = {modes_of(operating.coefficients(rest, inlet)),
                           modes_of(operating.coefficients(swept, inlet))};
  const Modes cooling = modes_of(operating.coefficients(off, inlet));
  constexpr Index kinds = kinds_of_work;
  static_assert(kinds == std::ssize(on_h) * std::ssize(at_work));
  std::vector<MatrixXd> columns(std::size(idle_h), MatrixXd(system.order(), kinds * std::ssize(heats)));
  Index column = 0;
  for (const VectorXd& heat : heats) {
    for (const Modes& working : at_work) {
      const VectorXd modal = working.shapes.transpose() * heat;
      for (const double on : on_h) {
        // (1 - exp(-d t)) / d, also for a part that keeps its heat.
        const VectorXd grown = working.decay.unaryExpr(
            [&](double d) { return d * on * hour > 1e-9 ? -std::expm1(-d * on * hour) / d : on * hour; });
        const VectorXd warm =
            cooling.shapes.transpose() * (system.capacity * (working.shapes * modal.cwiseProduct(grown)));
        for (std::size_t idle = 0; idle < std::size(idle_h); ++idle) {
          const VectorXd left = warm.cwiseProduct((-cooling.decay * idle_h[idle] * hour).array().exp().matrix());
          columns[idle].col(column) = cooling.shapes * left / std::sqrt(kinds);
        }
        ++column;
      }
    }
  }
  return columns;
}

Index ErrorModel::columns_of_heat() const { return kinds_of_work; }

template <class Visit>
void ErrorModel::each_work_before(const MatrixXd& rest, const MatrixXd& rows, const Visit& visit) const {
  for (std::size_t idle = 0; idle < left_behind_.size(); ++idle) {
    const MatrixXd seen = rows * left_behind_[idle], whole = seen * seen.transpose();
    const Index heats = seen.cols() / columns_of_heat();
    for (Index heat = -1; heat < heats; ++heat) {
      MatrixXd spread = whole;
      if (heat >= 0) {
        const auto own = seen.middleCols(heat * columns_of_heat(), columns_of_heat());
        spread = own * own.transpose();
      }
      const double log_prior = heat < 0 ? 0.0 : -std::log(heats);
      for (const double size : start_sizes) {
        MatrixXd covariance = rest + size * size * spread;
        if (heat >= 0) covariance += start_sizes[0] * start_sizes[0] * whole;
        visit(idle, heat, size, log_prior, covariance);
      }
    }
  }
}

MatrixXd ErrorModel::first_covariance(double uniform_K, const std::vector<FirstReading>& readings) const {
  const auto count = std::ssize(readings);
  MatrixXd rest = MatrixXd::Constant(count, count, uniform_K * uniform_K);
  for (Index i = 0; i < count; ++i) {
    const FirstReading& reading = readings[i];
    const double own = model_.machine.sensors[reading.sensor].uncertainty;
    rest(i, i) += std::pow(std::hypot(own, reading_std(reading.sensor, reading.value)), 2);
  }
  return rest;
}

MatrixXd ErrorModel::first_rows(const std::vector<FirstReading>& readings) const {
  MatrixXd rows(std::ssize(readings), model_.system.order());
  for (Index i = 0; i < rows.rows(); ++i) rows.row(i) = model_.system.sensors.row(readings[i].sensor);
  return rows;
}

namespace {

VectorXd values_of(const std::vector<ErrorModel::FirstReading>& readings) {
  VectorXd values(std::ssize(readings));
  for (Index i = 0; i < values.size(); ++i) values[i] = readings[i].value;
  return values;
}

double log_density(const Eigen::LLT<MatrixXd>& factor, const VectorXd& values) {
  const MatrixXd lower = factor.matrixL();
  return -0.5 * values.dot(factor.solve(values)) - lower.diagonal().array().log().sum();
}

}  // namespace

ErrorModel::WorkBefore ErrorModel::work_before(double uniform_K, const std::vector<FirstReading>& readings) const {
  const Index times = std::ssize(left_behind_), heats = left_behind_.front().cols() / columns_of_heat();
  if (readings.empty()) {
    // Nothing measured: as much as makes sensors differ by some kelvin.
    const auto sensors = std::ssize(model_.machine.sensors);
    double square = 0.0;
    for (const MatrixXd& left : left_behind_)
      square += (model_.system.sensors.topRows(sensors) * left).squaredNorm() / times;
    const double typical_K = std::sqrt(square / std::max(1.0, static_cast<double>(sensors)));
    const double size = typical_K > 0.0 ? std::min(1.0, unmeasured_start_K / typical_K) : 1.0;
    return {MatrixXd::Constant(heats, times, size / std::sqrt(times)), 0.0};
  }
  struct Offered {
    std::size_t idle;
    Index heat;
    double size, log_evidence;
  };
  const VectorXd values = values_of(readings);
  std::vector<Offered> offered;
  double best = -std::numeric_limits<double>::infinity(), sum = 0.0;
  each_work_before(
      first_covariance(uniform_K, readings), first_rows(readings),
      [&](std::size_t idle, Index heat, double size, double log_prior, const MatrixXd& covariance) {
        offered.push_back({idle, heat, size, log_prior + log_density(Eigen::LLT<MatrixXd>(covariance), values)});
        best = std::max(best, offered.back().log_evidence);
      });
  // Mean squares over all that was offered are what columns of one heat and time stand for.
  MatrixXd squares = MatrixXd::Zero(heats, times);
  for (const Offered& each : offered) {
    const double weight = std::exp(each.log_evidence - best);
    sum += weight;
    auto column = squares.col(each.idle);
    if (each.heat < 0) {
      column.array() += weight * each.size * each.size;
    } else {
      column[each.heat] += weight * each.size * each.size;
      column.array() += weight * start_sizes[0] * start_sizes[0];
    }
  }
  return {(squares / sum).cwiseSqrt(), best + std::log(sum)};
}

double ErrorModel::start_evidence(double uniform_K, const std::vector<FirstReading>& readings) const {
  return work_before(uniform_K, readings).log_evidence;
}

double ErrorModel::first_reading_chance(const std::vector<UniformStart>& starts, std::vector<FirstReading> others,
                                        const FirstReading& reading) const {
  const Index count = std::ssize(others);
  others.push_back(reading);
  const MatrixXd rows = first_rows(others);
  struct Offered {
    double log_evidence, chance;
  };
  std::vector<Offered> offered;
  double best = -std::numeric_limits<double>::infinity();
  for (const UniformStart& start : starts) {
    std::vector<FirstReading> from_start = others;
    for (FirstReading& each : from_start) each.value -= start.middle;
    const VectorXd values = values_of(from_start);
    each_work_before(first_covariance(start.std, from_start), rows,
                     [&](std::size_t, Index, double, double log_prior, const MatrixXd& covariance) {
                       const Eigen::LLT<MatrixXd> factor(covariance.topLeftCorner(count, count));
                       const VectorXd share = factor.solve(covariance.col(count).head(count));
                       const double variance = covariance(count, count) - covariance.col(count).head(count).dot(share);
                       const double off = std::abs(values[count] - share.dot(values.head(count)));
                       offered.push_back({log_prior + log_density(factor, values.head(count)),
                                          std::erfc(off / std::sqrt(2.0 * std::max(variance, 1e-12)))});
                       best = std::max(best, offered.back().log_evidence);
                     });
  }
  double sum = 0.0, chance = 0.0;
  for (const Offered& each : offered) {
    const double weight = std::exp(each.log_evidence - best);
    sum += weight;
    chance += weight * each.chance;
  }
  return chance / sum;
}

MatrixXd ErrorModel::start_patterns(double uniform_K, const std::vector<FirstReading>& readings) const {
  const MatrixXd sizes = work_before(uniform_K, readings).sizes;
  const Index wide = left_behind_.front().cols();
  MatrixXd columns(model_.system.order(), wide * std::ssize(left_behind_));
  for (Index idle = 0; idle < sizes.cols(); ++idle)
    for (Index column = 0; column < wide; ++column)
      columns.col(idle * wide + column) = sizes(column / columns_of_heat(), idle) * left_behind_[idle].col(column);
  const Eigen::BDCSVD<MatrixXd> parts(columns, Eigen::ComputeThinU);
  Index kept = 0;
  while (kept < std::min(most_patterns, parts.singularValues().size()) &&
         parts.singularValues()[kept] > least_pattern * parts.singularValues()[0])
    ++kept;
  return parts.matrixU().leftCols(kept) * parts.singularValues().head(kept).asDiagonal();
}

void ErrorModel::start(double uniform_K, const std::vector<FirstReading>& readings, const VectorXd& ambient_gap_K) {
  const reduction::ReducedSystem& system = model_.system;
  const Index order = system.order(), sensors = system.sensors.rows(), machine = std::ssize(quantities_);

  const MatrixXd patterns = start_patterns(uniform_K, readings);
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
  memory_.segment(machine + start_modes_, sensors).setConstant(machine_memory);
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
  const reduction::ReducedSystem& system = model_.system;
  const Index machine = std::ssize(quantities_);
  // The true state is nearer to the corrected one than to the nominal one.
  const VectorXd state = interval.state + directions_ * theta_.head(directions_.cols());
  MatrixXd result(system.order(), machine);
  VectorXd rate(system.order());
  for (Index k = 0; k < machine; ++k) {
    const Quantity& quantity = quantities_[k];
    rate.setZero();
    const auto add_input = [&](int input, double amount) {
      if (amount != 0.0) rate += amount * system.inputs.col(input);
    };
    for (const int term : quantity.terms) {
      if (interval.p[term] == 0.0) continue;
      const MatrixXd& matrix = system.terms[term];
      if (system.layout.terms[term].kind == solver::TermKind::coolant_flow) {
        rate.noalias() -= interval.p[term] * (matrix * state);
      } else {
        rate.noalias() -= interval.p[term] * (matrix.selfadjointView<Eigen::Lower>() * state);  // half the memory
      }
      for (const int input : inputs_of_term_[term]) add_input(input, interval.q[input]);
    }
    for (const int input : quantity.inputs) add_input(input, interval.q[input]);
    for (const int input : quantity.ambient_inputs) add_input(input, interval.p[system.layout.inputs[input].term]);
    result.col(k) = rate;
  }
  return result;
}

void ErrorModel::work_ends_at(const VectorXd& row) { left_behind_ = left_behind(row); }

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
  return spread.cwiseProduct(sensor_rate_).rowwise().sum().cwiseMax(0.0).cwiseSqrt();
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
  const double noise = noise_share * model_.machine.sensors[sensor].uncertainty;
  const double model = model_error_K + model_error_share * std::abs(deviation_K);
  return std::sqrt(noise * noise + model * model);
}

void ErrorModel::observe(const VectorXd& row, double residual, double variance) {
  gain_.noalias() = sigma_ * row;
  variance += row.dot(gain_);
  const double far = residual * residual / (outlier * outlier * variance);
  if (far > 1.0) variance *= far;
  gain_ /= std::sqrt(variance);
  theta_ += gain_ * (residual / std::sqrt(variance));
  sigma_.noalias() -= gain_ * gain_.transpose();
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
    theta_[k] = std::clamp(theta_[k], mean_[k] - 3.0 * prior_[k], mean_[k] + 3.0 * prior_[k]);
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
    state.unit = "K";
    if (k < machine) {
      state.name = quantities_[k].name;
      state.unit = quantities_[k].unit;
    } else if (k < machine + start_modes_) {
      state.name = k == machine ? "start, uniform" : "start, pattern " + std::to_string(k - machine);
      if (k > machine) state.unit = "1";
    } else if (k < machine + start_modes_ + sensors) {
      const std::size_t s = k - machine - start_modes_;
      if (s >= model_.machine.sensors.size()) continue;  // observed beside the sensors: no offset
      state.name = "offset of sensor " + model_.machine.sensors[s].id;
    } else {
      if (!learns_) break;
      const Index i = k - machine - start_modes_ - sensors;
      const std::string axis(1, "xyz"[i % 3]);
      state.name = i < 3   ? "motion of the tool side along " + axis
                   : i < 6 ? "motion of the table side along " + axis
                           : "rest along " + axis;
      state.unit = i < 6 ? "1" : "m";
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
