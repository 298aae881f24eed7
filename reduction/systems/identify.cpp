// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/systems/identify.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/error.h"
#include "core/first_order_lag.h"
#include "core/range.h"
#include "reduction/linear/lapack.h"
#include "reduction/linear/matrix_exponential.h"
#include "reduction/systems/system_solver.h"
#include "solver/campaign/load_result.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double ridges[] = {1e-6, 1e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1};
constexpr Index tried_orders[] = {5, 10, 15, 20, 30, 40, 60, 80, 120, 160};
/// The first row of a load is the even machine, which is known exactly: it weighs as so many others.
constexpr double first_row_weight = 1e4;
constexpr double sensor_um_per_K = 5.0, rotation_lever_m = 0.3;  ///< as in basis/responses.cpp
constexpr double still = 1e-9;                                   ///< of an input's largest value: it did not move
constexpr double enough_better = 1.02;                           ///< a larger order has to gain more than this

}  // namespace

void IdentifyOptions::validate() const {
  core::require_option(order >= 0, "identification order", order, "0 (chosen) or more");
  core::require_option(lags >= 1, "identification lags", lags, "one or more");
}

Samples make_samples(const CampaignInputs& inputs, const CampaignTables& tables, double reference_C) {
  return {tables.load,
          tables.inputs.column("time_s"),
          inputs.of(tables),
          campaign_outputs(tables, reference_C),
          campaign_poses(tables),
          inputs.initial_K(tables)};
}

/// Sums of the normal equations over loads; each load counts the same, however long.
struct Identification::Fit {
  MatrixXd gram, moments;
  VectorXd diagonal;

  Fit(Index states, Index outputs) : gram(MatrixXd::Zero(states, states)), moments(MatrixXd::Zero(states, outputs)) {}
  void add(const MatrixXd& states, const MatrixXd& outputs, Index rows) {
    if (rows == 0) return;
    VectorXd weight = VectorXd::Constant(rows, 1.0 / rows);
    weight(0) *= first_row_weight;
    const MatrixXd weighted = weight.asDiagonal() * states.topRows(rows);
    gram.noalias() += weighted.transpose() * states.topRows(rows);
    moments.noalias() += weighted.transpose() * outputs.topRows(rows);
    const double count = rows;
    const VectorXd plain =
        states.bottomRows(states.rows() - 1).topRows(rows - 1).colwise().squaredNorm().transpose() / count;
    diagonal = diagonal.size() == 0 ? plain : VectorXd(diagonal + plain);
  }
  /// (outputs x states)
  MatrixXd solve(double ridge) const {
    MatrixXd a = gram;
    const double least = 1e-12 * diagonal.maxCoeff();
    a.diagonal() += ridge * diagonal.cwiseMax(least);
    const Eigen::LDLT<MatrixXd> factor(a);
    if (factor.info() != Eigen::Success)
      throw core::SolverError("identification: the normal equations cannot be solved");
    return factor.solve(moments).transpose();
  }
};

struct Identification::Split {
  std::vector<Index> seen;  ///< first rows of each load that a fit sees; the others are kept out
  std::string kept_out;
};

Identification::Identification(const std::vector<Samples>& training, const std::vector<bool>& even,
                               const IdentifyOptions& options)
    : even_(even) {
  options.validate();
  check(training);
  const Spans spans = find_ranges(training);
  find_active(training.front().inputs.cols());
  set_constants(options.lags, spans);
  set_weights(training.front());

  std::vector<MatrixXd> states, weighted;
  for (const Samples& load : training) {
    states.push_back(lag_states(load));
    weighted.push_back(load.outputs * weight_.asDiagonal());
  }
  const Split split = keep_out(training);
  kept_out_ = split.kept_out;
  Fit part(states.front().cols(), weight_.size()), whole = part;
  for (std::size_t l = 0; l < training.size(); ++l) {
    part.add(states[l], weighted[l], split.seen[l]);
    whole.add(states[l], weighted[l], training[l].time.size());
  }
  balance(best_ridge(part, states, weighted, split.seen));
  choose_order(options.order, training, split.seen);
  balance(whole.solve(ridge_));
  order_ = std::min(order_, usable_);
}

void Identification::check(const std::vector<Samples>& training) const {
  if (training.empty()) throw core::InputError("identification", "no load", "the tables of at least one");
  const Index inputs = training.front().inputs.cols(), outputs = training.front().outputs.cols();
  if (std::ssize(even_) != inputs)
    throw core::InputError("identification", fmt::format("{} inputs", even_.size()), fmt::format("{} inputs", inputs));
  for (const Samples& load : training) {
    if (load.inputs.cols() != inputs || load.outputs.cols() != outputs || load.poses != training.front().poses ||
        load.inputs.rows() != load.outputs.rows() || load.time.size() != load.inputs.rows()) {
      throw core::InputError("identification, load '" + load.load + "'", fmt::format("{} outputs", load.outputs.cols()),
                             fmt::format("{}, as the first load has: one campaign, the same poses", outputs));
    }
  }
}

/// Between which values inputs move, and how long loads last.
Identification::Spans Identification::find_ranges(const std::vector<Samples>& training) {
  const Index inputs = training.front().inputs.cols();
  low_ = VectorXd::Constant(inputs, std::numeric_limits<double>::infinity());
  high_ = -low_;
  Spans spans{low_(0), 0.0};
  for (const Samples& load : training) {
    low_ = low_.cwiseMin(load.inputs.colwise().minCoeff().transpose());
    high_ = high_.cwiseMax(load.inputs.colwise().maxCoeff().transpose());
    for (Index k = 0; k < inputs; ++k)
      if (even_[k]) low_(k) = std::min(low_(k), load.initial_K), high_(k) = std::max(high_(k), load.initial_K);
    spans.longest = std::max(spans.longest, load.time(load.time.size() - 1) - load.time(0));
    for (Index i = 1; i < load.time.size(); ++i)
      spans.shortest = std::min(spans.shortest, load.time(i) - load.time(i - 1));
  }
  return spans;
}

void Identification::find_active(Index inputs) {
  scale_ = low_.cwiseAbs().cwiseMax(high_.cwiseAbs());
  bool any = false;
  for (Index k = 0; k < inputs; ++k) {
    const bool moves = high_(k) - low_(k) > still * scale_(k);
    any = any || moves;
    if (scale_(k) > 0.0) active_.push_back(k);
    // Heat that always flows begins with the load; a temperature that is always the start's has shown no effect of
    // its own.
    if (!moves && (even_[k] || scale_(k) == 0.0)) never_moved_.push_back(k);
  }
  if (!any) {
    throw core::InputError("identification", "no input that varies",
                           "loads that heat the machine or change its surroundings");
  }
}

void Identification::set_constants(int lags, const Spans& spans) {
  constants_.resize(lags);
  for (int i = 0; i < lags; ++i) {
    const double place = i;
    constants_(i) = lags == 1 ? spans.longest / 4
                              : 0.5 * spans.shortest * std::pow(spans.longest / spans.shortest, place / (lags - 1));
  }
}

void Identification::set_weights(const Samples& load) {
  poses_ = load.poses;
  weight_ = VectorXd::Constant(load.outputs.cols(), sensor_um_per_K);
  for (Index i = 0; i < poses_ * values_of_pose; ++i) weight_(i) = i % values_of_pose < 3 ? 1.0 : rotation_lever_m;
}

/// The load that moves most inputs which the others move too; without one, the last quarter of each.
Identification::Split Identification::keep_out(const std::vector<Samples>& training) const {
  std::vector<std::vector<bool>> moves(training.size(), std::vector<bool>(active_.size()));
  for (std::size_t l = 0; l < training.size(); ++l) {
    for (std::size_t k = 0; k < active_.size(); ++k) {
      const auto column = training[l].inputs.col(active_[k]);
      moves[l][k] = column.maxCoeff() - column.minCoeff() > 1e-6 * scale_(active_[k]);
    }
  }
  std::size_t chosen = training.size();
  long most = 0;
  for (std::size_t l = 0; l < training.size(); ++l) {
    bool elsewhere = true;
    for (std::size_t k = 0; k < active_.size(); ++k) {
      bool other = !moves[l][k];
      for (std::size_t m = 0; m < training.size(); ++m) other = other || (m != l && moves[m][k]);
      elsewhere = elsewhere && other;
    }
    const long count = std::count(moves[l].begin(), moves[l].end(), true);
    if (elsewhere && count > most) most = count, chosen = l;
  }
  Split split;
  split.kept_out = chosen < training.size() ? "load '" + training[chosen].load + "'" : "the last quarter of each load";
  for (std::size_t l = 0; l < training.size(); ++l) {
    const Index rows = training[l].time.size();
    split.seen.push_back(chosen == training.size() ? std::max<Index>(1, 3 * rows / 4) : l == chosen ? 0 : rows);
  }
  return split;
}

/// Chooses the ridge on what is kept out. @return (outputs x states) with it, of a fit that did not see that
MatrixXd Identification::best_ridge(const Fit& part, const std::vector<MatrixXd>& states,
                                    const std::vector<MatrixXd>& weighted, const std::vector<Index>& seen) {
  double best = std::numeric_limits<double>::infinity();
  MatrixXd c;
  for (const double ridge : ridges) {
    const MatrixXd tried = part.solve(ridge);
    double squares = 0.0;
    for (std::size_t l = 0; l < states.size(); ++l) {
      const Index rows = states[l].rows() - seen[l];
      if (rows > 0)
        squares += (states[l].bottomRows(rows) * tried.transpose() - weighted[l].bottomRows(rows)).squaredNorm() / rows;
    }
    if (squares < best) best = squares, ridge_ = ridge, c = tried;
  }
  return c;
}

/// @param wanted  0: the smallest that is as good as any on what is kept out
void Identification::choose_order(Index wanted, const std::vector<Samples>& training, const std::vector<Index>& seen) {
  double least = std::numeric_limits<double>::infinity();
  std::vector<Index> orders;
  for (const Index order : tried_orders)
    if (order < usable_) orders.push_back(order);
  orders.push_back(usable_);
  for (const Index order : orders) {
    order_error_um_.emplace_back(order, rms_um(model(order), training, seen));
    least = std::min(least, order_error_um_.back().second);
  }
  order_ = wanted;
  if (order_ == 0) {
    order_ = std::find_if(order_error_um_.begin(), order_error_um_.end(), [&](const auto& tried) {
               return tried.second <= enough_better * least;
             })->first;
  }
}

/// x of each lag behind each input at the load's times, inputs in units of their largest.
MatrixXd Identification::lag_states(const Samples& load) const {
  const Index lags = constants_.size(), states = std::ssize(active_) * lags;
  MatrixXd all(load.time.size(), states);
  VectorXd x(states);
  for (Index k = 0; k < std::ssize(active_); ++k)
    x.segment(k * lags, lags).setConstant(even_[active_[k]] ? load.initial_K / scale_(active_[k]) : 0.0);
  all.row(0) = x.transpose();
  for (Index i = 1; i < load.time.size(); ++i) {
    for (Index l = 0; l < lags; ++l) {
      const core::LagStep step(load.time(i) - load.time(i - 1), constants_(l));
      for (Index k = 0; k < std::ssize(active_); ++k) {
        double& state = x(k * lags + l);
        state = step.standing(state, load.inputs(i, active_[k]) / scale_(active_[k]));
      }
    }
    all.row(i) = x.transpose();
  }
  return all;
}

/// Balances the lags with the weighted outputs c.
void Identification::balance(const MatrixXd& c) {
  const Index lags = constants_.size(), states = c.cols();
  StateSpace& base = lags_.base;
  base = {};
  base.identity = base.symmetric = true;
  base.E.resize(states, states);
  base.E.setIdentity();
  base.A.resize(states, states);
  base.A.setIdentity();
  base.B = MatrixXd::Zero(states, std::ssize(active_));
  for (Index s = 0; s < states; ++s) {
    base.A.coeffRef(s, s) = -1.0 / constants_(s % lags);
    base.B(s, s / lags) = 1.0 / constants_(s % lags);
  }
  base.C = c;
  base.D = MatrixXd::Zero(c.rows(), base.B.cols());
  lags_.folder = "identified lags";
  const auto solver = make_system_solver(base, "identified lags");
  const GramianFactors gramians = solver->gramians();
  const lapack::Svd core = lapack::svd(gramians.core);
  if (!(core.values(0) > 0.0)) {
    throw core::InputError("identification", "no input that affects an output",
                           "tables of a campaign with loads that heat the machine");
  }
  constexpr double rounding = 1e-10;
  usable_ = (core.values.array() > rounding * core.values(0)).count();
  const VectorXd scale = core.values.head(usable_).cwiseSqrt().cwiseInverse();
  left_ = gramians.observability * (core.left.leftCols(usable_) * scale.asDiagonal());
  right_ = gramians.controllability * (core.right.leftCols(usable_) * scale.asDiagonal());
}

ReducedLinearSystem Identification::model(Index order) const {
  const Index r = std::min(order, usable_);
  ReducedLinearSystem model = project(lags_, left_.leftCols(r), right_.leftCols(r));
  model.E.setIdentity();
  const MatrixXd b = model.B;
  model.B = MatrixXd::Zero(r, scale_.size());
  for (std::size_t k = 0; k < active_.size(); ++k) model.B.col(active_[k]) = b.col(k) / scale_(active_[k]);
  model.C = weight_.cwiseInverse().asDiagonal() * model.C;
  model.D = MatrixXd::Zero(model.C.rows(), model.B.cols());
  return model;
}

MatrixXd Identification::predict(const ReducedLinearSystem& model, const Samples& load) const {
  const Index r = model.order(), times = load.time.size();
  VectorXd before = VectorXd::Zero(model.B.cols());
  for (Index k = 0; k < before.size(); ++k)
    if (even_[k]) before(k) = load.initial_K;
  VectorXd x = -model.A.partialPivLu().solve(model.B * before);
  std::map<double, std::pair<MatrixXd, MatrixXd>> steps;  // of x, of B u
  MatrixXd outputs(times, model.C.rows());
  outputs.row(0) = (model.C * x).transpose();
  for (Index i = 1; i < times; ++i) {
    const double length = load.time(i) - load.time(i - 1);
    auto step = steps.find(length);
    if (step == steps.end()) {
      MatrixXd both = MatrixXd::Zero(2 * r, 2 * r);
      both.topLeftCorner(r, r) = length * model.A;
      both.topRightCorner(r, r) = length * MatrixXd::Identity(r, r);
      const MatrixXd moved = matrix_exponential(both);
      step = steps.emplace(length, std::pair{MatrixXd(moved.topLeftCorner(r, r)), MatrixXd(moved.topRightCorner(r, r))})
                 .first;
    }
    x = (step->second.first * x + step->second.second * (model.B * load.inputs.row(i).transpose())).eval();
    outputs.row(i) = (model.C * x).transpose();
  }
  return outputs;
}

solver::LoadResult Identification::predicted(const ReducedLinearSystem& model, const Samples& load,
                                             const CampaignTables& tables) const {
  const MatrixXd outputs = predict(model, load);
  const Index poses = campaign_poses(tables);
  solver::LoadResult result;
  result.load = load.load;
  result.tcp = {load.load, {"time_s", "dx_um", "dy_um", "dz_um"}, MatrixXd(outputs.rows() * poses, 4)};
  for (Index i = 0; i < result.tcp.rows(); ++i) {
    result.tcp.values(i, 0) = load.time(i / poses);
    result.tcp.values.row(i).tail(3) = outputs.row(i / poses).segment((i % poses) * values_of_pose, 3);
  }
  return result;
}

double Identification::rms_um(const ReducedLinearSystem& model, const std::vector<Samples>& loads,
                              const std::vector<Index>& from) const {
  double squares = 0.0, count = 0.0;
  for (std::size_t l = 0; l < loads.size(); ++l) {
    const Index rows = loads[l].time.size() - from[l];
    if (rows <= 0) continue;
    const MatrixXd off = (predict(model, loads[l]) - loads[l].outputs).bottomRows(rows);
    for (Index pose = 0; pose < poses_; ++pose) {
      squares += off.middleCols(pose * values_of_pose, 3).squaredNorm();
      count += rows;
    }
  }
  return std::sqrt(squares / std::max(1.0, count));
}

std::vector<Index> Identification::beyond(const Samples& load) const {
  std::vector<Index> found;
  for (Index k = 0; k < scale_.size(); ++k) {
    const double room = 0.1 * (high_(k) - low_(k)) + still * (1.0 + scale_(k));
    if (load.inputs.col(k).maxCoeff() > high_(k) + room || load.inputs.col(k).minCoeff() < low_(k) - room)
      found.push_back(k);
  }
  return found;
}

}  // namespace thermotwin::reduction
