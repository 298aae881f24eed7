// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/systems/system_reduction.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/progress.h"
#include "core/range.h"
#include "core/text.h"
#include "reduction/linear/lapack.h"
#include "reduction/linear/orthonormal.h"
#include "reduction/systems/rational_krylov.h"
#include "reduction/systems/sparse_solver.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Bases {
  MatrixXd left, right;
  bool converged = true;
};

/// All that is worth keeping of one point while its bases are made.
struct Point {
  std::unique_ptr<const StateSpace> system;  // at an address that stays: the solver refers to it
  std::unique_ptr<SystemSolver> solver;
  GramianFactors gramians;
  lapack::Svd core;
  PointResult result;

  /// More singular values than these are rounding.
  Index usable() const {
    constexpr double rounding = 1e-14;
    return (core.values.array() > rounding * core.values(0)).count();
  }
};

Bases balanced(const Point& point, Index order) {
  const VectorXd scale = point.core.values.head(order).cwiseSqrt().cwiseInverse();
  return {point.gramians.observability * (point.core.left.leftCols(order) * scale.asDiagonal()),
          point.gramians.controllability * (point.core.right.leftCols(order) * scale.asDiagonal())};
}

Bases modal(const Point& point, Index order) {
  const Modes modes = point.solver->dominant_modes(order);
  if (modes.values.size() == 0) throw core::SolverError("modal truncation: no mode converged");
  Bases bases{MatrixXd(point.system->size(), modes.values.size()), MatrixXd(point.system->size(), modes.values.size())};
  for (Index k = 0; k < modes.values.size(); ++k) {
    bases.right.col(k) = modes.right.col(k).real();
    bases.left.col(k) = modes.left.col(k).real();
    if (modes.values(k).imag() == 0.0 || k + 1 == modes.values.size()) continue;
    bases.right.col(k + 1) = modes.right.col(k).imag();
    bases.left.col(k + 1) = modes.left.col(k).imag();
    ++k;
  }
  return bases;
}

Bases bases_of(const Point& point, Method method, Index order) {
  order = std::min(order, point.system->size());
  if (method == Method::balanced) return balanced(point, std::min(order, point.usable()));
  if (method == Method::modal) return modal(point, order);
  KrylovBases krylov = rational_krylov(*point.system, *point.solver, order);
  return {std::move(krylov.left), std::move(krylov.right), krylov.converged};
}

/// The same model with E = 1.
ReducedLinearSystem normalised(ReducedLinearSystem model) {
  const Eigen::PartialPivLU<MatrixXd> e(model.E);
  constexpr double singular = 1e-14;
  if (!(e.rcond() > singular)) {
    throw core::SolverError(fmt::format(
        "the left and right bases of order {} are nearly orthogonal; use another --order or --method balanced",
        model.order()));
  }
  model.A = e.solve(model.A);
  model.B = e.solve(model.B);
  for (MatrixXd& film : model.films) film = e.solve(film);
  model.E.setIdentity();
  return model;
}

/// Columns that span both, without those that add nothing.
MatrixXd joined(const MatrixXd& a, const MatrixXd& b) {
  MatrixXd both(b.rows(), a.cols() + b.cols());
  both << a, b;
  for (Index k = 0; k < both.cols(); ++k) both.col(k).normalize();
  constexpr double independent = 1e-8;
  return orthonormal(both, independent);
}

/// Whether x^T A x < 0 at this point, with E positive definite: any projection stays stable.
bool dissipative(const StateSpace& system) {
  Sparse symmetric = -0.5 * (system.A + Sparse(system.A.transpose()));
  symmetric.makeCompressed();
  const Sparse difference = system.E - Sparse(system.E.transpose());
  return difference.norm() <= 1e-14 * system.E.norm() && is_definite(system.E) && is_definite(symmetric);
}

/// A basis of all points' right and, if asked for, left columns.
MatrixXd all_columns(const std::vector<Bases>& bases, bool right, bool left) {
  MatrixXd all(bases.front().right.rows(), 0);
  for (const Bases& one : bases) {
    if (right) all = joined(all, one.right);
    if (left) all = joined(all, one.left);
  }
  return all;
}

bool stable_at_all(const ReducedLinearSystem& model, const std::vector<Point>& points) {
  return std::all_of(points.begin(), points.end(),
                     [&](const Point& point) { return ReducedResponse(model.at(point.result.films)).stable(); });
}

/// One model from the bases of several points. Dissipative systems: one-sided in the inner product of E,
/// which any projection leaves dissipative. Others: one-sided in the sum of the points' observability
/// Gramians (each point's own makes the model stable there), then both sides apart; the first that is
/// stable at all points.
ReducedLinearSystem joined_model(const LinearSystem& system, const std::vector<Point>& points,
                                 const std::vector<Bases>& bases) {
  const Sparse& e = system.base.E;
  if (std::all_of(points.begin(), points.end(), [](const Point& point) { return dissipative(*point.system); })) {
    MatrixXd v = all_columns(bases, true, true);
    const Eigen::LLT<MatrixXd> metric(v.transpose() * (e * v));
    v = metric.matrixU().solve<Eigen::OnTheRight>(v);
    return normalised(project(system, v, v));
  }
  const MatrixXd right = all_columns(bases, true, false), e_right = e * right;
  MatrixXd weighted = MatrixXd::Zero(right.rows(), right.cols());
  for (const Point& point : points)
    weighted += point.gramians.observability * (point.gramians.observability.transpose() * e_right);
  const MatrixXd left = all_columns(bases, false, true);
  const Index width = std::min(left.cols(), right.cols());
  weighted = joined(MatrixXd(right.rows(), 0), weighted);
  if (weighted.cols() == right.cols()) {
    ReducedLinearSystem model = normalised(project(system, weighted, right));
    if (stable_at_all(model, points)) return model;
  }
  return normalised(project(system, left.leftCols(width), right.leftCols(width)));
}

Point open_point(const LinearSystem& system, const std::vector<double>& films, const SystemReductionOptions& options) {
  Point point;
  point.system = std::make_unique<const StateSpace>(system.at(films));
  std::string place = system.folder.string();
  for (std::size_t j = 0; j < films.size(); ++j)
    place += fmt::format("{}{}={:.6g}", j == 0 ? " at " : ", ", system.films[j].name, films[j]);
  point.solver = make_system_solver(*point.system, place, options.solver);
  point.gramians = point.solver->gramians();
  point.core = lapack::svd(point.gramians.core);
  PointResult& result = point.result;
  result.films = films;
  result.hankel = point.core.values;
  result.complete = point.gramians.complete;
  result.unknown_sum = point.gramians.unknown_sum;
  result.gramian_steps = point.gramians.steps;
  result.gramian_residual = point.gramians.residual;
  result.proved_stable = point.solver->proved_stable();
  result.dense = point.solver->dense();
  if (!(result.hankel(0) > 0.0)) {
    throw core::InputError(system.folder.string(), "no input reaches an output: all Hankel singular values are 0",
                           "B and C that act on the same states");
  }
  return point;
}

/// A sparse system is looked at through its own balanced model of high order.
FrequencySweep sweep_of(const LinearSystem& system, const Point& point) {
  if (point.result.dense) return {*point.solver, std::nullopt};
  constexpr Index widest = 200;
  constexpr double enough = 1e-12;
  const Index order = std::min<Index>(widest, (point.core.values.array() > enough * point.core.values(0)).count());
  const Bases bases = balanced(point, order);
  return {*point.solver, normalised(project(system, bases.left, bases.right)).at(point.result.films)};
}

/// Orders of the table: up to the one chosen and half as much again.
std::vector<Index> orders_to_compare(Index order, Index most) {
  std::vector<Index> orders;
  for (const Index eighths : {2, 4, 6, 8, 12}) {
    const Index r = std::clamp<Index>((order * eighths + 4) / 8, 1, most);
    if (orders.empty() || r > orders.back()) orders.push_back(r);
  }
  return orders;
}

std::vector<Comparison> compare(const LinearSystem& system, const Point& point, FrequencySweep& sweep) {
  std::vector<Comparison> table;
  for (const Method method : {Method::balanced, Method::modal, Method::krylov}) {
    for (const Index order : orders_to_compare(point.result.order, point.usable())) {
      const Bases bases = bases_of(point, method, order);
      Comparison row{method, bases.right.cols()};
      try {
        const ReducedResponse reduced(normalised(project(system, bases.left, bases.right)).at(point.result.films));
        row.stable = reduced.stable();
        row.error = sweep.error(reduced).value;
      } catch (const core::SolverError&) {
        row.error = std::numeric_limits<double>::quiet_NaN();
      }
      if (table.empty() || table.back().method != method || table.back().order != row.order) table.push_back(row);
    }
  }
  return table;
}

}  // namespace

const char* word(Method method) {
  return method == Method::balanced ? "balanced" : method == Method::modal ? "modal" : "krylov";
}

Method method_of(const std::string& word_in) {
  for (const Method method : {Method::balanced, Method::modal, Method::krylov})
    if (word_in == word(method)) return method;
  throw core::UsageError("unknown method '" + word_in + "' of --matrices; one of: balanced, modal, krylov");
}

double bound_of(const VectorXd& hankel, Index order) {
  double sum = 0;
  for (Index k = hankel.size() - 1; k >= order; --k) sum += hankel(k);
  return 2.0 * sum;
}

Index order_for(const VectorXd& hankel, double allowed) {
  Index order = hankel.size();
  double bound = 0;
  while (order > 1 && bound + 2.0 * hankel(order - 1) <= allowed) bound += 2.0 * hankel(--order);
  constexpr double equal = 1e-8;
  while (order < hankel.size() && hankel(order) >= (1.0 - equal) * hankel(order - 1)) ++order;
  return order;
}

bool SystemReduction::stable() const {
  return std::all_of(points.begin(), points.end(), [](const PointResult& point) { return point.stable; });
}

void SystemReductionOptions::validate() const {
  core::require_option(tolerance > 0.0 && std::isfinite(tolerance), "--tolerance", tolerance, "a positive number");
  core::require_option(order >= 0, "--order", order, "0 (by the tolerance) or more");
  solver.validate();
}

void SystemReductionOptions::validate_for(const LinearSystem& system) const {
  validate();
  if (order > system.base.size()) {
    throw core::InputError("--order", fmt::format("{}", order),
                           fmt::format("1 to {}, the number of states", system.base.size()));
  }
  for (const auto& values : points) {
    if (values.size() != system.films.size()) {
      throw core::InputError("values of films", fmt::format("{}", values.size()),
                             fmt::format("{}, one per A_film_NAME.mtx", system.films.size()));
    }
  }
}

SystemReduction reduce_system(const LinearSystem& system, const SystemReductionOptions& options) {
  options.validate_for(system);
  std::vector<std::vector<double>> values = options.points;
  if (values.empty()) values.push_back(std::vector<double>(system.films.size(), 1.0));
  SystemReduction reduction;
  reduction.method = options.method;
  reduction.joined = values.size() > 1;

  std::vector<Point> points;
  points.reserve(values.size());
  std::vector<FrequencySweep> sweeps;
  sweeps.reserve(values.size());
  std::vector<Bases> bases;
  for (const auto& films : values) {
    points.push_back(open_point(system, films, options));
    Point& point = points.back();
    core::log_line(fmt::format("{} states: {} Hankel singular values, the largest {:.6g}", point.system->size(),
                               point.result.hankel.size(), point.result.hankel(0)));
    sweeps.push_back(sweep_of(system, point));
    point.result.norm = sweeps.back().norm();
    Index order = options.order;
    if (order == 0) {
      const double allowed = options.tolerance * (options.absolute ? 1.0 : point.result.norm.value);
      order = order_for(point.result.hankel, allowed);
    }
    const Index usable = point.usable();
    if (order > usable && options.method == Method::balanced) {
      core::warn(fmt::format(
          "order {} is more than the {} Hankel singular values above rounding (1e-14 of the largest): order {}", order,
          usable, usable));
      order = usable;
    }
    bases.push_back(bases_of(point, options.method, order));
    reduction.converged = reduction.converged && bases.back().converged;
    point.result.order = bases.back().right.cols();
    point.result.bound = bound_of(point.result.hankel, point.result.order);
  }

  reduction.model = reduction.joined ? joined_model(system, points, bases)
                                     : normalised(project(system, bases.front().left, bases.front().right));
  for (std::size_t k = 0; k < points.size(); ++k) {
    PointResult& result = points[k].result;
    const ReducedResponse reduced(reduction.model.at(result.films));
    result.poles = reduced.poles();
    result.stable = reduced.stable();
    result.error = sweeps[k].error(reduced);
  }
  if (options.compare) reduction.comparison = compare(system, points.front(), sweeps.front());
  for (std::size_t k = 0; k < points.size(); ++k) {
    points[k].result.samples = sweeps[k].samples();
    reduction.points.push_back(std::move(points[k].result));
  }
  if (!reduction.stable()) {
    throw core::SolverError(fmt::format(
        "the reduced model of order {} by --method {} is not stable; use another --order or --method balanced",
        reduction.model.order(), word(options.method)));
  }
  return reduction;
}

}  // namespace thermotwin::reduction
