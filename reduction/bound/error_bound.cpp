// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/bound/error_bound.h"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>

#include "core/error.h"
#include "reduction/basis/error_estimate.h"
#include "reduction/model/reduced_simulation.h"
#include "solver/operation/layout.h"
#include "solver/thermal/integrator.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double gamma_ = solver::sdirk_gamma;
constexpr double share = (1.0 - gamma_) / gamma_;  ///< of the first stage's increment in the second
constexpr double root2 = std::numbers::sqrt2;
/// Pairing of the adjoint stages (first, second); its determinant is 4.
constexpr double a11 = 4.0 - 2.0 * root2, a12 = 2.0 - 2.0 * root2, a22 = 4.0;
constexpr double rounding = 1e-6;  ///< of a bound, for sums in floating point
constexpr double um = 1e6;

/// Galerkin's trajectory in U and the norm of its residuals.
class Primal {
public:
  Primal(const BoundModel& bound, double initial_K) : bound_(bound), state_(bound.one_kelvin * initial_K) {}

  const VectorXd& state() const { return state_; }
  double square() const { return square_; }

  /// New coefficients or another step.
  void prepare(const BoundSum& k, double step) {
    const Index m = bound_.terms.order();
    lu_.compute(MatrixXd::Identity(m, m) + gamma_ * step * k.conduction());
    residual_ = k.residual();
  }

  void advance(const VectorXd& q, double step) {
    const double scale = gamma_ * step;
    const VectorXd heat = scale * (bound_.inputs * q), fixed = bound_.primal_inputs * q;
    const VectorXd first = lu_.solve(state_ + heat);
    const VectorXd second = lu_.solve((1.0 - share) * state_ + share * first + heat);
    const VectorXd r1 = residual_ * first - fixed, r2 = residual_ * second - fixed;
    // The inverse of the pairing; its determinant is 4.
    square_ += 0.25 * scale * (a22 * r1.squaredNorm() - 2.0 * a12 * r1.dot(r2) + a11 * r2.squaredNorm());
    state_ = second;
  }

private:
  const BoundModel& bound_;
  VectorXd state_;
  double square_ = 0.0;
  Eigen::PartialPivLU<MatrixXd> lu_;
  MatrixXd residual_;
};

/// D^2 of an output with the row c at the last step: c^T F c and what its part beside E W adds.
class Dual {
public:
  explicit Dual(const BoundModel& bound)
      : form_(MatrixXd::Zero(bound.terms.dual(), bound.terms.dual())),
        marked_(form_),
        since_mark_(MatrixXd::Identity(form_.rows(), form_.rows())) {}

  void prepare(const BoundSum& k, double step) {
    const Index d = form_.rows();
    scale_ = gamma_ * step;
    const MatrixXd back =
        (MatrixXd::Identity(d, d) + scale_ * k.conduction().topLeftCorner(d, d).transpose()).inverse();
    second_ = scale_ * (k.dual_residual() * back);
    first_ = share * (second_ * back);
    moved_ = (1.0 - share) * back + share * (back * back);
    const MatrixXd cross = first_.transpose() * second_;
    seen_ = (a11 * (first_.transpose() * first_) + a12 * (cross + cross.transpose()) +
             a22 * (second_.transpose() * second_)) /
            scale_;
    runs_.assign(1, {1, moved_, seen_});
  }

  /// Steps of the coefficients prepared last.
  void advance(std::size_t steps) {
    for (std::size_t power = 0; steps > 0; ++power, steps /= 2) {
      if (power == runs_.size()) {
        const Run& half = runs_.back();
        MatrixXd moved = half.moved * half.moved, seen = half.seen + half.moved.transpose() * half.seen * half.moved;
        runs_.push_back({2 * half.steps, std::move(moved), std::move(seen)});
      }
      if (steps % 2 == 0) continue;
      const Run& run = runs_[power];
      form_ = (run.seen + run.moved.transpose() * form_ * run.moved).eval();
      since_mark_ = (since_mark_ * run.moved).eval();
    }
  }

  /// Squares of D over the steps since the mark, and over those before it.
  /// @param c  (dual) the row in W   @param rest  (probes) its part beside E W
  struct Squares {
    double recent, older;
  };
  Squares squares(const VectorXd& c, const VectorXd& rest) const {
    const VectorXd second = second_ * c, before = since_mark_ * c;
    const double beside = a22 * (rest.squaredNorm() + 2.0 * rest.dot(second)) + 2.0 * a12 * rest.dot(first_ * c);
    const double older = std::max(0.0, before.dot(marked_ * before));
    return {std::max(0.0, c.dot(form_ * c) + beside / scale_ - older), older};
  }

  void mark() {
    marked_ = form_;
    since_mark_.setIdentity();
  }

private:
  struct Run {
    std::size_t steps;
    MatrixXd moved, seen;
  };  // 2^k steps of the same coefficients
  MatrixXd form_, marked_, since_mark_;
  double scale_ = 1.0;
  MatrixXd first_, second_, moved_, seen_;  // residuals of both stages and the step's map of a row
  std::vector<Run> runs_;
};

/// The most that sum X_w P_w over two windows can be where sum X_w^2 <= sum X_w D_w.
double product(const Dual::Squares& d, double recent, double older) {
  return 0.5 * (std::sqrt(d.recent * recent) + std::sqrt(d.older * older) +
                std::sqrt((d.recent + d.older) * (recent + older)));
}

/// K(p) >= K(least) * this, for all terms but flows.
double above_least(const BoundModel& bound, const VectorXd& p) {
  double smallest = 1.0;
  for (Index j = 0; j < p.size(); ++j) {
    if (bound.layout.terms[j].kind == solver::TermKind::coolant_flow || bound.least(j) <= 0.0) continue;
    smallest = std::min(smallest, std::max(0.0, p(j)) / bound.least(j));
  }
  return smallest;
}

void require_fit(const ReducedModel& model, const BoundModel& bound, const RunRecord& run) {
  if (model.machine.hash != bound.machine_hash || model.full_size != bound.full_size) {
    throw core::InputError("bound of the reduced model", "made for another machine or mesh",
                           "bound.rom.h5 of the same `thermotwin reduce --bound`");
  }
  const auto terms = bound.terms.count();
  for (const RunRecord::Step& step : run.steps) {
    if (step.c.p.size() != terms || step.c.q.size() != bound.inputs.cols()) {
      throw core::InputError("bound of the reduced model", "other terms or inputs than the run's",
                             "a run of the same model");
    }
  }
  if (!run.sdirk) {
    throw core::InputError("bound of the reduced model", "a run without time error (--exact)",
                           "a run that steps as the full model does");
  }
}

}  // namespace

ErrorBound error_bound(const ReducedModel& model, const BoundModel& bound, const mesh::Machine& machine,
                       const RunRecord& run) {
  require_fit(model, bound, run);
  const Index poses = std::ssize(bound.poses), values = value_rows(model, {bound.poses.front()}).rows();
  const MatrixXd own_rows = value_rows(model, bound.poses);
  ErrorBound result;
  core::Table& table = result.table;
  table.source = "error bound";
  table.columns = {"time_s"};
  for (const std::string& name : mesh::pose_columns(machine)) table.columns.push_back(name);
  const std::vector<std::string> names = solver::tcp_columns();
  table.columns.insert(table.columns.end(), names.begin(), names.begin() + estimated_values);
  table.values.resize(std::ssize(run.outputs) * poses, std::ssize(table.columns));

  for (const RunRecord::Step& step : run.steps) result.scale = std::min(result.scale, above_least(bound, step.c.p));
  result.scale = result.scale > 0.0 ? 1.0 / result.scale : std::numeric_limits<double>::infinity();

  Primal primal(bound, run.initial_K);
  Dual dual(bound);
  BoundSum k(bound.terms);
  const VectorXd* p = nullptr;
  double length = 0.0, before = 0.0;  // before: square of the primal norm at the output before
  std::size_t done = 0, waiting = 0;  // steps that the dual has not taken yet, all alike
  Index row = 0;
  for (const RunRecord::Output& output : run.outputs) {
    for (; done < output.steps; ++done) {
      const RunRecord::Step& step = run.steps[done];
      if (!p || *p != step.c.p || std::abs(step.length_s - length) > 1e-11 * length) {
        dual.advance(waiting);
        waiting = 0;
        p = &step.c.p;
        length = step.length_s;
        k.set(*p);
        primal.prepare(k, length);
        dual.prepare(k, length);
      }
      primal.advance(step.c.q, step.length_s);
      ++waiting;
    }
    dual.advance(waiting);
    waiting = 0;
    const VectorXd own = own_rows * output.state;
    for (Index i = 0; i < poses; ++i, ++row) {
      const MatrixXd& rows = bound.rows[i];
      const VectorXd beside = um * (rows * primal.state()) - own.segment(i * values, estimated_values);
      VectorXd remainder = VectorXd::Zero(estimated_values);
      if (done > 0) {
        for (Index o = 0; o < estimated_values; ++o) {
          if (const double both = product(dual.squares(rows.row(o).head(bound.terms.dual()), bound.rest[i].col(o)),
                                          primal.square() - before, before);
              both > 0.0)
            remainder(o) = um * result.scale * both;
        }
      }
      const VectorXd total = (1.0 + rounding) * (beside.cwiseAbs() + remainder);
      table.values.row(row) << output.time, mesh::pose_values(machine, bound.poses[i]).transpose(), total.transpose();
      result.largest_um = std::max(result.largest_um, total.head(3).norm());
      result.remainder_um = std::max(result.remainder_um, remainder.head(3).norm());
    }
    dual.mark();
    before = primal.square();
  }
  // Two norms of the trajectory for each output time, and of each output's adjoint.
  result.failure = std::min(1.0, 2.0 * bound.failure * run.outputs.size() * (1 + estimated_values * poses));
  return result;
}

}  // namespace thermotwin::reduction
