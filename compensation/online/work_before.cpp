// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/work_before.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "compensation/online/drive_heats.h"
#include "core/units.h"
#include "solver/operation/operating_model.h"

namespace thermotwin::compensation {
namespace {

using core::units::hour;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double model_error_share = 0.03, model_error_K = 0.01, noise_share = 0.3;
constexpr Index most_patterns = 16;
constexpr double least_pattern = 0.01;  ///< of the largest pattern
// What a machine did before: hours of work, hours since, size of its heat beside that of half speed.
constexpr double on_h[] = {0.5, 2.0, 6.0, 24.0}, idle_h[] = {0.0, 0.25, 1.0, 3.0, 8.0, 24.0};
constexpr Index kinds_of_work = 2 * std::ssize(on_h);  ///< columns of a heat: axes still or swept, hours of work
constexpr double unmeasured_start_K = 2.0;
constexpr double start_sizes[] = {0.03, 0.1, 0.3, 1.0, 3.0};
// Causes, each of the size that a day's work has it: half speed, standing losses, some kelvin around.
constexpr double air_K = 2.0, other_K = 2.0;

struct Modes {
  MatrixXd shapes;
  VectorXd decay;
};

/// A machine at work, and switched off, where its axes stand.
class DayOfWork {
public:
  DayOfWork(const reduction::ReducedModel& model, const VectorXd& row)
      : model_(model),
        machine_(model.machine),
        system_(model.system),
        operating_(model.machine, model.system.layout),
        inlet_(VectorXd::Zero(std::ssize(model.machine.coolants))),
        rest_(operating_.channels().defaults()),
        swept_(rest_) {
    for (const mesh::Axis& axis : machine_.axes) {
      const bool linear = axis.kind == mesh::AxisKind::linear;
      const std::string id = "axis." + axis.id + ".", unit = linear ? "mm" : "deg";
      const double to_unit = linear ? 1e3 : 180.0 / std::numbers::pi;
      const int position = operating_.channels().index(id + "position_" + unit);
      if (std::isfinite(row[position])) rest_[position] = swept_[position] = row[position];
      swept_ = set(set(swept_, id + "low_" + unit, axis.low * to_unit), id + "high_" + unit, axis.high * to_unit);
    }
    off_ = set(rest_, "machine.on", 0.0);
    for (const mesh::CoolantSpec& coolant : machine_.coolants) off_ = set(off_, "coolant." + coolant.id + ".on", 0.0);
  }

  /// Of each cause, W on the basis.
  std::vector<VectorXd> heats(const std::vector<WorkBefore::Ambient>& ambients) const {
    std::vector<VectorXd> heats;
    // Standing: its losses, and surroundings that are warmer than the hall.
    heats.push_back(system_.inputs * operating_.coefficients(rest_, inlet_).q - source_heat(system_, operating_, off_));
    for (DriveHeat& drive : drive_heats(model_, operating_, rest_)) heats.push_back(std::move(drive.heat));
    const solver::Coefficients wet = operating_.coefficients(set(rest_, "cutting_fluid.on", 1.0), inlet_);
    for (const WorkBefore::Ambient& ambient : ambients) {
      const double kelvin = machine_.ambients[ambient.ambient].id == "air" ? air_K : other_K;
      VectorXd heat = VectorXd::Zero(system_.order());
      for (const int input : ambient.inputs) {
        const int term = system_.layout.inputs[input].term;
        heat += kelvin * wet.p[term] * system_.inputs.col(input);
      }
      heats.push_back(std::move(heat));
    }
    return heats;
  }

  /// Axes stood where they stand now.
  Modes still() const { return modes_of(rest_); }
  /// Axes went from end to end: heat crossed the joints elsewhere.
  Modes swept() const { return modes_of(swept_); }
  Modes cooling() const { return modes_of(off_); }

private:
  VectorXd set(VectorXd row, const std::string& name, double value) const {
    if (const int channel = operating_.channels().index(name); channel >= 0) row[channel] = value;
    return row;
  }

  Modes modes_of(const VectorXd& row) const {
    const solver::Coefficients c = operating_.coefficients(row, inlet_);
    MatrixXd conduction = system_.conduction;
    for (Index j = 0; j < c.p.size(); ++j) {
      if (c.p[j] != 0.0) conduction += c.p[j] * system_.terms[j];
    }
    const MatrixXd symmetric = 0.5 * (conduction + conduction.transpose());
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(symmetric, system_.capacity);
    return {modes.eigenvectors(), modes.eigenvalues().cwiseMax(0.0)};
  }

  const reduction::ReducedModel& model_;
  const mesh::Machine& machine_;
  const reduction::ReducedSystem& system_;
  solver::OperatingModel operating_;
  VectorXd inlet_, rest_, swept_, off_;
};

VectorXd values_of(const std::vector<FirstReading>& readings) {
  VectorXd values(std::ssize(readings));
  for (Index i = 0; i < values.size(); ++i) values[i] = readings[i].value;
  return values;
}

double log_density(const Eigen::LLT<MatrixXd>& factor, const VectorXd& values) {
  const MatrixXd lower = factor.matrixL();
  return -0.5 * values.dot(factor.solve(values)) - lower.diagonal().array().log().sum();
}

}  // namespace

double reading_std(double uncertainty_K, double deviation_K) {
  const double noise = noise_share * uncertainty_K;
  const double model = model_error_K + model_error_share * std::abs(deviation_K);
  return std::sqrt(noise * noise + model * model);
}

WorkBefore::WorkBefore(const reduction::ReducedModel& model, std::vector<Ambient> ambients)
    : model_(model),
      ambients_(std::move(ambients)) {}

void WorkBefore::ends_at(const VectorXd& row) {
  const reduction::ReducedSystem& system = model_.system;
  const DayOfWork day(model_, row);
  const std::vector<VectorXd> heats = day.heats(ambients_);
  const Modes at_work[] = {day.still(), day.swept()};
  const Modes cooling = day.cooling();
  static_assert(kinds_of_work == std::ssize(on_h) * std::ssize(at_work));
  left_.assign(std::size(idle_h), MatrixXd(system.order(), kinds_of_work * std::ssize(heats)));
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
          left_[idle].col(column) = cooling.shapes * left / std::sqrt(kinds_of_work);
        }
        ++column;
      }
    }
  }
}

template <class Visit>
void WorkBefore::each(const MatrixXd& rest, const MatrixXd& rows, const Visit& visit) const {
  for (Index idle = 0; idle < std::ssize(left_); ++idle) {
    const MatrixXd seen = rows * left_[idle], whole = seen * seen.transpose();
    const Index heats = seen.cols() / kinds_of_work;
    for (Index heat = -1; heat < heats; ++heat) {
      MatrixXd spread = whole;
      if (heat >= 0) {
        const auto own = seen.middleCols(heat * kinds_of_work, kinds_of_work);
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

MatrixXd WorkBefore::covariance(double uniform_K, const std::vector<FirstReading>& readings) const {
  const auto count = std::ssize(readings);
  MatrixXd rest = MatrixXd::Constant(count, count, uniform_K * uniform_K);
  for (Index i = 0; i < count; ++i) {
    const FirstReading& reading = readings[i];
    const double own = model_.machine.sensors[reading.sensor].uncertainty;
    rest(i, i) += std::pow(std::hypot(own, reading_std(own, reading.value)), 2);
  }
  return rest;
}

MatrixXd WorkBefore::rows_of(const std::vector<FirstReading>& readings) const {
  MatrixXd rows(std::ssize(readings), model_.system.order());
  for (Index i = 0; i < rows.rows(); ++i) rows.row(i) = model_.system.sensors.row(readings[i].sensor);
  return rows;
}

/// As much as makes sensors differ by some kelvin.
WorkBefore::Weighed WorkBefore::unmeasured() const {
  const Index times = std::ssize(left_), heats = left_.front().cols() / kinds_of_work;
  const auto sensors = std::ssize(model_.machine.sensors);
  double square = 0.0;
  for (const MatrixXd& left : left_) square += (model_.system.sensors.topRows(sensors) * left).squaredNorm() / times;
  const double typical_K = std::sqrt(square / std::max<double>(1.0, sensors));
  const double size = typical_K > 0.0 ? std::min(1.0, unmeasured_start_K / typical_K) : 1.0;
  return {MatrixXd::Constant(heats, times, size / std::sqrt(times)), 0.0};
}

/// All heats alike or one alone, each size, each time since: as probable as it makes the readings.
WorkBefore::Weighed WorkBefore::weigh(double uniform_K, const std::vector<FirstReading>& readings) const {
  if (readings.empty()) return unmeasured();
  const Index times = std::ssize(left_), heats = left_.front().cols() / kinds_of_work;
  struct Offered {
    Index idle, heat;
    double size, log_evidence;
  };
  const VectorXd values = values_of(readings);
  std::vector<Offered> offered;
  double best = -std::numeric_limits<double>::infinity(), sum = 0.0;
  each(covariance(uniform_K, readings), rows_of(readings),
       [&](Index idle, Index heat, double size, double log_prior, const MatrixXd& spread) {
         offered.push_back({idle, heat, size, log_prior + log_density(Eigen::LLT<MatrixXd>(spread), values)});
         best = std::max(best, offered.back().log_evidence);
       });
  // Mean squares over all that was offered are what columns of one heat and time stand for.
  MatrixXd squares = MatrixXd::Zero(heats, times);
  for (const Offered& one : offered) {
    const double weight = std::exp(one.log_evidence - best);
    sum += weight;
    auto column = squares.col(one.idle);
    if (one.heat < 0) {
      column.array() += weight * one.size * one.size;
    } else {
      column[one.heat] += weight * one.size * one.size;
      column.array() += weight * start_sizes[0] * start_sizes[0];
    }
  }
  return {(squares / sum).cwiseSqrt(), best + std::log(sum)};
}

double WorkBefore::chance(const std::vector<UniformStart>& starts, std::vector<FirstReading> others,
                          const FirstReading& reading) const {
  const Index count = std::ssize(others);
  others.push_back(reading);
  const MatrixXd rows = rows_of(others);
  struct Offered {
    double log_evidence, chance;
  };
  std::vector<Offered> offered;
  double best = -std::numeric_limits<double>::infinity();
  for (const UniformStart& start : starts) {
    std::vector<FirstReading> from_start = others;
    for (FirstReading& one : from_start) one.value -= start.middle;
    const VectorXd values = values_of(from_start);
    each(covariance(start.std, from_start), rows, [&](Index, Index, double, double log_prior, const MatrixXd& spread) {
      const Eigen::LLT<MatrixXd> factor(spread.topLeftCorner(count, count));
      const VectorXd share = factor.solve(spread.col(count).head(count));
      const double variance = spread(count, count) - spread.col(count).head(count).dot(share);
      const double off = std::abs(values[count] - share.dot(values.head(count)));
      offered.push_back({log_prior + log_density(factor, values.head(count)),
                         std::erfc(off / std::sqrt(2.0 * std::max(variance, 1e-12)))});
      best = std::max(best, offered.back().log_evidence);
    });
  }
  double sum = 0.0, chance = 0.0;
  for (const Offered& one : offered) {
    const double weight = std::exp(one.log_evidence - best);
    sum += weight;
    chance += weight * one.chance;
  }
  return chance / sum;
}

MatrixXd WorkBefore::patterns(double uniform_K, const std::vector<FirstReading>& readings) const {
  const MatrixXd sizes = weigh(uniform_K, readings).sizes;
  const Index wide = left_.front().cols();
  MatrixXd columns(model_.system.order(), wide * std::ssize(left_));
  for (Index idle = 0; idle < sizes.cols(); ++idle) {
    for (Index column = 0; column < wide; ++column)
      columns.col(idle * wide + column) = sizes(column / kinds_of_work, idle) * left_[idle].col(column);
  }
  const Eigen::BDCSVD<MatrixXd> parts(columns, Eigen::ComputeThinU);
  Index kept = 0;
  while (kept < std::min(most_patterns, parts.singularValues().size()) &&
         parts.singularValues()[kept] > least_pattern * parts.singularValues()[0])
    ++kept;
  return parts.matrixU().leftCols(kept) * parts.singularValues().head(kept).asDiagonal();
}

}  // namespace thermotwin::compensation
