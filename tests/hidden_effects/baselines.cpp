// SPDX-License-Identifier: GPL-3.0-or-later
#include "baselines.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "diagnosis/causes/parameter.h"

namespace thermotwin::hidden {

using diagnosis::ObservedChannel;
using diagnosis::Kind;
using diagnosis::Parameter;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double delays_s[] = {0.0, 600.0, 1800.0, 5400.0, 18000.0};

bool is_displacement(const ObservedChannel& channel) { return !channel.is_temperature(); }

/// Inputs that move in the record (of another record: the same ones), and what its sensors show above the start.
Library library(const Seen& seen, const compensation::Measurement& measurement, std::vector<Index>& moving) {
  const diagnosis::Observations& obs = seen.problem().observations;
  MatrixXd rows = obs.rows;
  for (double& value : rows.reshaped())
    if (!std::isfinite(value)) value = 0.0;
  if (moving.empty()) {
    for (Index c = 0; c < rows.cols(); ++c)
      if (rows.col(c).maxCoeff() - rows.col(c).minCoeff() > 1e-6) moving.push_back(c);
  }
  Library result;
  result.time = obs.points;
  result.inputs.resize(obs.points.size(), std::ssize(moving));
  for (Index i = 0; i < result.time.size(); ++i)
    for (std::size_t c = 0; c < moving.size(); ++c) result.inputs(i, c) = rows(std::max<Index>(i - 1, 0), moving[c]);
  const VectorXd time = measurement.time();
  for (const compensation::MeasuredChannel& channel : measurement.channels) {
    if (channel.sensor.empty()) continue;
    const VectorXd values = measurement.values(channel);
    std::vector<double> at, value;
    for (Index i = 0; i < values.size(); ++i)
      if (std::isfinite(values[i])) at.push_back(time[i]), value.push_back(values[i] - obs.start_C);
    result.sensors.conservativeResize(result.time.size(), result.sensors.cols() + 1);
    result.sensors.rightCols(1) = Library::at(Eigen::Map<VectorXd>(at.data(), std::ssize(at)),
                                              Eigen::Map<VectorXd>(value.data(), std::ssize(value)), result.time);
  }
  return result;
}

/// Inputs behind first-order elements.
MatrixXd filtered(const Library& library) {
  MatrixXd all(library.time.size(), 0);
  for (const double delay : delays_s) {
    MatrixXd values = library.inputs;
    for (Index i = 1; i < values.rows() && delay > 0.0; ++i) {
      const double keep = std::exp(-(library.time[i] - library.time[i - 1]) / delay);
      values.row(i) = keep * values.row(i - 1) + (1.0 - keep) * library.inputs.row(i);
    }
    // What a filter adds beyond its start.
    if (delay > 0.0) values.rowwise() -= library.inputs.row(0).eval();
    all.conservativeResize(Eigen::NoChange, all.cols() + values.cols());
    all.rightCols(values.cols()) = values;
  }
  return all;
}

MatrixXd joined(const MatrixXd& a, const MatrixXd& b) {
  MatrixXd both(a.rows(), a.cols() + b.cols());
  both << a, b;
  return both;
}

/// Zero mean and unit deviation by the fitted part; what does not move there is dropped to zero.
struct Scale {
  Eigen::RowVectorXd mean, width;
  explicit Scale(const MatrixXd& x)
      : mean(x.colwise().mean()),
        width((x.rowwise() - mean).colwise().norm() / std::sqrt(std::max<Index>(x.rows(), 1))) {}
  MatrixXd operator()(const MatrixXd& x) const {
    MatrixXd result = x.rowwise() - mean;
    for (Index c = 0; c < x.cols(); ++c) result.col(c) *= width[c] > 1e-9 ? 1.0 / width[c] : 0.0;
    return result;
  }
};

VectorXd sparse_sum(const MatrixXd& x, const VectorXd& y, const MatrixXd& other) {
  const Index n = y.size(), first = n - n / 3;
  const auto fit = [](const MatrixXd& own, const VectorXd& values, const MatrixXd& there, double penalty) {
    const Scale scale(own);
    const double mean = values.mean();
    return VectorXd((scale(there) * lasso(scale(own), values.array() - mean, penalty)).array() + mean);
  };
  const double most = std::sqrt((y.array() - y.mean()).square().mean());
  double best = std::numeric_limits<double>::infinity(), chosen = most;
  for (double penalty = most; penalty > 1e-3 * most; penalty *= 0.6) {
    const double left =
        (fit(x.topRows(first), y.head(first), x.bottomRows(n - first), penalty) - y.tail(n - first)).squaredNorm();
    if (left < best) best = left, chosen = penalty;
  }
  return fit(x, y, other, chosen);
}

/// All parameters of the machine's heat at once.
struct Refit {
  std::vector<Parameter> parameters;
  VectorXd values;
};

Refit refit(const Seen& seen, const mesh::Machine& machine) {
  const diagnosis::Problem& problem = seen.problem();
  Refit fit;
  for (const Parameter& p : problem.parameters) {
    if (std::find(std::begin(refitted_kinds), std::end(refitted_kinds), p.kind) != std::end(refitted_kinds))
      fit.parameters.push_back(p);
  }
  const auto count = std::ssize(fit.parameters);
  // Means weigh by their noise; zero: the last third of what may be fitted.
  VectorXd early = VectorXd::Zero(problem.measured.size()), late = early;
  for (std::size_t k = 0; k < problem.observations.channels.size(); ++k) {
    const Index first = problem.first_row(k), n = problem.observations.channels[k].fitted, third = n / 3;
    const VectorXd weight = problem.covariance[k].noise_variance.head(n).cwiseSqrt().cwiseInverse();
    early.segment(first, n - third) = weight.head(n - third);
    late.segment(first + n - third, third) = weight.tail(third);
  }
  const auto fitted = [&](const VectorXd& weight, double width) {
    VectorXd at = VectorXd::Ones(count);
    for (int iteration = 0; iteration < 3; ++iteration) {
      const diagnosis::Response::Linear linear = seen.response().linearise(machine, fit.parameters, at, false);
      const MatrixXd a = weight.asDiagonal() * linear.sensitivity;
      const VectorXd b =
          weight.cwiseProduct(problem.measured - linear.predicted + linear.sensitivity * (at - VectorXd::Ones(count)));
      MatrixXd normal = a.transpose() * a;
      normal.diagonal().array() += 1.0 / (width * width);
      at = (VectorXd::Ones(count) + normal.llt().solve(a.transpose() * b)).cwiseMax(0.05).cwiseMin(8.0);
    }
    return at;
  };
  double best = std::numeric_limits<double>::infinity(), chosen = 0.1;
  for (const double width : {0.03, 0.1, 0.3}) {
    const VectorXd at = fitted(early, width);
    const double left = late.cwiseProduct(problem.measured - seen.response().predict(diagnosis::with_parameters(
                                                                 machine, fit.parameters, at)))
                            .squaredNorm();
    if (left < best) best = left, chosen = width;
  }
  fit.values = fitted(early + late, chosen);
  return fit;
}

}  // namespace

MatrixXd Library::at(const VectorXd& time, const MatrixXd& values, const VectorXd& when) {
  MatrixXd result(when.size(), values.cols());
  for (Index i = 0; i < when.size(); ++i) {
    const double* next = std::upper_bound(time.data() + 1, time.data() + time.size() - 1, when[i]);
    const Index right = next - time.data();
    const double share = std::clamp((when[i] - time[right - 1]) / (time[right] - time[right - 1]), 0.0, 1.0);
    result.row(i) = (1.0 - share) * values.row(right - 1) + share * values.row(right);
  }
  return result;
}

VectorXd gaussian_process(const MatrixXd& x, const VectorXd& y, const MatrixXd& other) {
  const Index n = x.rows();
  const double mean = y.mean();
  const VectorXd centred = y.array() - mean;
  const auto distances = [&](const MatrixXd& a) {
    MatrixXd d(a.rows(), n);
    for (Index i = 0; i < a.rows(); ++i)
      for (Index j = 0; j < n; ++j) d(i, j) = (a.row(i) - x.row(j)).squaredNorm();
    return d;
  };
  const MatrixXd own = distances(x);
  double best = -std::numeric_limits<double>::infinity(), length = 1.0;
  VectorXd weights = VectorXd::Zero(n);
  for (const double l : {0.5, 1.0, 2.0, 4.0, 8.0, 16.0}) {
    for (const double noise : {0.03, 0.1, 0.3, 1.0}) {
      MatrixXd k = (-0.5 / (l * l) * own.array()).exp();
      k.diagonal().array() += noise * noise;
      const Eigen::LLT<MatrixXd> factor(k);
      const VectorXd solved = factor.solve(centred);
      const double variance = std::max(centred.dot(solved) / n, 1e-12);  // its best
      const double log = -0.5 * n * std::log(variance) - factor.matrixLLT().diagonal().array().log().sum();
      if (log > best) best = log, length = l, weights = solved;
    }
  }
  const MatrixXd cross = (-0.5 / (length * length) * distances(other).array()).exp();
  return (cross * weights).array() + mean;
}

VectorXd lasso(const MatrixXd& x, const VectorXd& y, double penalty) {
  const double n = x.rows();
  VectorXd b = VectorXd::Zero(x.cols()), left = y;
  const VectorXd square = x.colwise().squaredNorm().transpose() / n;
  for (int sweep = 0; sweep < 500; ++sweep) {
    double moved = 0.0;
    for (Index c = 0; c < x.cols(); ++c) {
      if (square[c] <= 1e-12) continue;
      const double z = x.col(c).dot(left) / n + square[c] * b[c],
                   next = std::copysign(std::max(std::abs(z) - penalty, 0.0), z) / square[c];
      if (next == b[c]) continue;
      left -= (next - b[c]) * x.col(c);
      moved = std::max(moved, std::abs(next - b[c]));
      b[c] = next;
    }
    if (moved < 1e-6 * (penalty + 1e-12)) break;
  }
  return b;
}

double displacement_rms(const Seen& seen, const VectorXd& predicted, bool heldout, PoseRange poses) {
  const diagnosis::Problem& problem = seen.problem();
  double sum = 0.0, count = 0.0;
  for (std::size_t k = 0; k < problem.observations.channels.size(); ++k) {
    const ObservedChannel& channel = problem.observations.channels[k];
    if (!is_displacement(channel)) continue;
    const std::string& id = channel.channel.id;
    if (const std::size_t pose = std::stoul(id.substr(id.find('@') + 1)); pose < poses.first || pose > poses.last)
      continue;
    const Index from = heldout ? channel.fitted : 0, n = channel.size() - from;
    sum += (problem.measured - predicted).segment(problem.first_row(k) + from, n).squaredNorm();
    count += n;
  }
  return std::sqrt(sum / std::max(count, 1.0));
}

std::vector<Corrected> baselines(const Seen& seen, const compensation::Measurement& record, const Seen& program,
                                 const compensation::Measurement& unseen, const mesh::Machine& machine) {
  const std::size_t poses = [&] {
    std::size_t most = 0;
    for (const ObservedChannel& c : seen.problem().observations.channels) {
      if (is_displacement(c))
        most = std::max<std::size_t>(most, std::stoul(c.channel.id.substr(c.channel.id.find('@') + 1)));
    }
    return most;
  }();
  std::vector<Corrected> all;
  const auto add = [&](const char* method, const VectorXd& here, const VectorXd& there) -> Corrected& {
    return all.emplace_back(Corrected{method, displacement_rms(seen, here, true, {1, poses}),
                                      displacement_rms(program, there, false, {1, poses}), "", ""});
  };
  const Refit fit = refit(seen, machine);
  const mesh::Machine refitted = diagnosis::with_parameters(machine, fit.parameters, fit.values);
  Corrected& named = add("refit", seen.response().predict(refitted), program.response().predict(refitted));
  double most = 0.0;
  for (std::size_t i = 0; i < fit.parameters.size(); ++i) {
    if (const double change = std::abs(fit.values[i] - 1.0) / fit.parameters[i].nominal_std; change > most)
      most = change, named.kind = name_of(fit.parameters[i].kind), named.where = fit.parameters[i].where;
  }

  std::vector<Index> moving;
  const Library own = library(seen, record, moving), other = library(program, unseen, moving);
  const MatrixXd own_filtered = filtered(own), other_filtered = filtered(other);
  const MatrixXd own_seen = joined(own.inputs, own.sensors), other_seen = joined(other.inputs, other.sensors);
  const diagnosis::Problem &here = seen.problem(), &there = program.problem();
  VectorXd process = here.predicted, process_there = there.predicted, sparse = here.predicted,
           sparse_there = there.predicted;
  for (std::size_t k = 0; k < here.observations.channels.size(); ++k) {
    const ObservedChannel& channel = here.observations.channels[k];
    if (!is_displacement(channel)) continue;
    std::size_t twin = 0;
    while (twin < there.observations.channels.size() &&
           there.observations.channels[twin].channel.id != channel.channel.id)
      ++twin;
    if (twin == there.observations.channels.size()) continue;
    const Index row = here.first_row(k), n = channel.size(), other_row = there.first_row(twin);
    const VectorXd &when = channel.time, &other_when = there.observations.channels[twin].time;
    const VectorXd left = (here.measured - here.predicted).segment(row, channel.fitted);
    const auto both = [&](const MatrixXd& a, const MatrixXd& b) {
      return std::pair(Library::at(own.time, a, when), Library::at(other.time, b, other_when));
    };
    const auto correct = [&](const std::pair<MatrixXd, MatrixXd>& x, const auto& learn, VectorXd& at,
                             VectorXd& at_other) {
      const MatrixXd fitted = x.first.topRows(channel.fitted);
      at.segment(row, n) += learn(fitted, left, x.first);
      at_other.segment(other_row, other_when.size()) += learn(fitted, left, x.second);
    };
    correct(
        both(own_seen, other_seen),
        [](const MatrixXd& x, const VectorXd& y, const MatrixXd& elsewhere) {
          const Scale scale(x);
          return gaussian_process(scale(x), y, scale(elsewhere));
        },
        process, process_there);
    correct(both(own_filtered, other_filtered), sparse_sum, sparse, sparse_there);
  }
  add("process", process, process_there);
  add("sparse", sparse, sparse_there);
  return all;
}

}  // namespace thermotwin::hidden
