// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/analysis.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "compensation/chain/location_offsets.h"
#include "core/error.h"
#include "core/text.h"
#include "core/toml_place.h"
#include "core/units.h"
#include "metrology/rtest/error_terms.h"

namespace thermotwin::metrology {

using compensation::LocationOffsets;
using core::InputError;
using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

constexpr double same_nominal = 1e-6;  ///< m

/// Positions of a rotary axis count modulo a turn.
bool same_place(const mesh::KinematicChain& chain, const RTestPoint& a, const RTestPoint& b) {
  if ((a.nominal - b.nominal).norm() > same_nominal) return false;
  return std::all_of(a.positions.begin(), a.positions.end(), [&](const auto& at) {
    double apart = at.second - b.positions.at(at.first);
    if (chain.find(at.first)->rotary) apart = std::remainder(apart, 2.0 * std::numbers::pi);
    return std::abs(apart) < 1e-6;
  });
}

/// (points) the first point at the same place
std::vector<Index> places_of(const mesh::KinematicChain& chain, const RTestCycle& cycle) {
  const auto x = [&](Index i) { return cycle.points[i].nominal[0]; };
  std::vector<Index> order(cycle.points.size()), places(order.size());
  std::iota(order.begin(), order.end(), Index{0});
  places = order;
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return x(a) < x(b); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (std::size_t k = i; k-- > 0 && x(order[i]) - x(order[k]) <= same_nominal;) {
      if (!same_place(chain, cycle.points[order[i]], cycle.points[order[k]])) continue;
      const Index first = std::min(places[order[i]], places[order[k]]);
      places[order[i]] = places[order[k]] = first;
    }
  }
  return places;
}

/// The axis whose component errors the harmonics are, its branch and its place there.
struct Turning {
  const std::vector<mesh::ChainAxis>* branch = nullptr;
  int index = -1;
};
Turning outermost(const RTestRecord& record) {
  const std::vector<std::string> moved = record.moved_axes();
  Turning found;
  for (const auto* branch : {&record.chain.tool, &record.chain.table}) {
    for (int i = 0; i < std::ssize(*branch); ++i)
      if (std::find(moved.begin(), moved.end(), (*branch)[i].id) != moved.end()) found = {branch, i};
    if (branch == &record.chain.table || found.branch == nullptr) continue;
    const bool table_moves = std::any_of(record.chain.table.begin(), record.chain.table.end(), [&](const auto& axis) {
      return std::find(moved.begin(), moved.end(), axis.id) != moved.end();
    });
    if (table_moves) found = {};
  }
  return found;
}

/// Directions across the table's axis, table's home frame, along which its surface may shift against the axis. None
/// where the points have one place on the table: it would not be distinguished from C0C and R0T.
MatrixXd table_shifts(const RTestRecord& record, const RTestCycle& cycle) {
  const auto& branch = record.chain.table;
  auto last = std::ssize(branch) - 1;
  while (last >= 0 && !branch[last].rotary) --last;
  if (last < 0) return MatrixXd(3, 0);
  const auto on_table = [&](const RTestPoint& point) {
    const Vector3d place = mesh::KinematicChain::frame(branch, last, point.positions).inverse() * point.nominal;
    return Vector3d(place - branch[last].direction * branch[last].direction.dot(place));
  };
  constexpr double apart = 1e-3;  // m
  const Vector3d first = on_table(cycle.points.front());
  if (std::all_of(cycle.points.begin(), cycle.points.end(),
                  [&](const RTestPoint& point) { return (on_table(point) - first).norm() < apart; })) {
    return MatrixXd(3, 0);
  }
  const Vector3d direction = branch[last].direction, across = direction.unitOrthogonal();
  MatrixXd shifts(3, 2);
  shifts << across, direction.cross(across);
  return shifts;
}

struct Equations {
  MatrixXd rows;  ///< (3 points x parameters): errors, harmonics, shifts of the table
  VectorXd deviation;
  Index harmonics = 0;  ///< columns
};

Equations equations_of(const RTestRecord& record, const RTestCycle& cycle, const LocationOffsets& map,
                       const std::vector<ErrorTerm>& terms) {
  const Index errors = std::ssize(record.errors), points = std::ssize(cycle.points);
  Equations result;
  const int orders = std::max(0, record.harmonics - 1);
  const Turning axis = orders > 0 ? outermost(record) : Turning();
  const MatrixXd shifts = record.table_shift ? table_shifts(record, cycle) : MatrixXd(3, 0);
  const auto last = static_cast<int>(std::ssize(record.chain.table)) - 1;
  result.harmonics = 6 * orders;
  result.rows = MatrixXd::Zero(3 * points, errors + result.harmonics + shifts.cols());
  result.deviation.resize(3 * points);
  for (Index i = 0; i < points; ++i) {
    const RTestPoint& point = cycle.points[i];
    result.deviation.segment<3>(3 * i) = point.deviation;
    for (Index e = 0; e < errors; ++e) {
      result.rows.block<3, 1>(3 * i, e) = shift_of(terms[e], map, point.positions, point.nominal);
    }
    if (shifts.cols() > 0) {
      const Matrix3d table = mesh::KinematicChain::frame(record.chain.table, last, point.positions).linear();
      result.rows.block(3 * i, result.rows.cols() - shifts.cols(), 3, shifts.cols()) = -table * shifts;
    }
    if (axis.branch == nullptr) continue;
    const mesh::ChainAxis& turning = (*axis.branch)[axis.index];
    const Matrix3d frame = mesh::KinematicChain::frame(*axis.branch, axis.index - 1, point.positions).linear();
    const auto at = point.positions.find(turning.id);
    const double angle = at == point.positions.end() ? 0.0 : at->second, sign = turning.table_side ? -1.0 : 1.0;
    for (int n = 0; n < orders; ++n) {
      const Index column = errors + 6 * n;
      result.rows.block<3, 3>(3 * i, column) = sign * std::cos((n + 2) * angle) * frame;
      result.rows.block<3, 3>(3 * i, column + 3) = sign * std::sin((n + 2) * angle) * frame;
    }
  }
  return result;
}

/// The drift over a cycle as the repeated points show it.
struct Drift {
  MatrixXd columns;  ///< (3 points x drifts) effect on each point, 0 in the middle of the cycle; first the common one
  MatrixXd inverse;  ///< (drifts x 3 points) of the deviations
  bool estimated() const { return columns.cols() > 0; }
};

constexpr double least_distinct = 0.3;  ///< of the effect of a drift that is no sum of others at the repeated points
constexpr double least_shown = 0.3;     ///< of the effect on all points that differences between visits show

/// A drift of all points alike, then of growth and rotations, then of the second order in time, those that the repeated
/// points distinguish. Differences between visits of one place alone count: what the place has of its own, such as a
/// component error of the axis, is in none of them.
Drift drift_of(const RTestRecord& record, const RTestCycle& cycle, const std::vector<ErrorTerm>& terms,
               const MatrixXd& moves) {
  const Index points = std::ssize(cycle.points);
  Drift drift{MatrixXd(3 * points, 0), MatrixXd(0, 3 * points)};
  if (!record.drift) return drift;
  const std::vector<Index> places = places_of(record.chain, cycle);
  const double length = std::max(1e-9, cycle.last_time() - cycle.first_time()),
               middle = 0.5 * (cycle.first_time() + cycle.last_time());
  VectorXd tau(points), visits = VectorXd::Zero(points);
  for (Index i = 0; i < points; ++i) {
    tau[i] = (cycle.points[i].time - middle) / length;
    visits[places[i]] += 1.0;
  }
  const auto within_places = [&](MatrixXd rows) {
    MatrixXd means = MatrixXd::Zero(rows.rows(), rows.cols());
    for (Index i = 0; i < points; ++i)
      means.middleRows<3>(3 * places[i]) += rows.middleRows<3>(3 * i) / visits[places[i]];
    for (Index i = 0; i < points; ++i) rows.middleRows<3>(3 * i) -= means.middleRows<3>(3 * places[i]);
    return rows;
  };
  std::vector<VectorXd> basis;  // orthonormal, within places
  const auto add = [&](const VectorXd& column, double shown) {
    const VectorXd within = within_places(column);
    VectorXd left = within;
    for (int pass = 0; pass < 2; ++pass)
      for (const VectorXd& known : basis) left -= known * known.dot(left);
    if (!(left.norm() > least_distinct * within.norm()) || !(within.norm() > shown * column.norm())) return;
    basis.emplace_back(left.normalized());
    drift.columns.conservativeResize(Eigen::NoChange, drift.columns.cols() + 1);
    drift.columns.rightCols(1) = column;
  };
  const auto in_time = [&](VectorXd column, int power) {
    for (Index i = 0; i < points; ++i) column.segment<3>(3 * i) *= std::pow(tau[i], power);
    return column;
  };
  const auto alike = [&](int direction) { return VectorXd(Vector3d::Unit(direction).replicate(points, 1)); };
  for (int i = 0; i < 3; ++i) add(in_time(alike(i), 1), weakest);
  if (!drift.estimated()) return drift;
  for (std::size_t e = 0; e < terms.size(); ++e) {
    const std::string& name = terms[e].name;
    const bool rotation = terms[e].power == 0 && name[0] >= 'A' && name[0] <= 'C';
    if (rotation || name == "R0T") add(in_time(moves.col(e), 1), least_shown);
  }
  for (int i = 0; i < 3; ++i) add(in_time(alike(i), 2), least_shown);
  const LinearFit fit = fit_linear(within_places(drift.columns), VectorXd::Zero(3 * points));
  drift.inverse = within_places(fit.inverse.transpose()).transpose();
  return drift;
}

/// The fit of the deviations less their drift. Value, inverse and cofactor are those of the deviations themselves.
LinearFit fit_cycle(const Equations& equations, const Drift& drift) {
  if (!drift.estimated()) return fit_linear(equations.rows, equations.deviation);
  LinearFit fit =
      fit_linear(equations.rows, equations.deviation - drift.columns * (drift.inverse * equations.deviation));
  fit.inverse -= (fit.inverse * drift.columns) * drift.inverse;
  fit.cofactor = fit.inverse * fit.inverse.transpose();
  return fit;
}

constexpr const char* nuisance = "a harmonic or a shift of the table";

CycleResult result_of(const RTestRecord& record, const RTestCycle& cycle, const Equations& equations,
                      const Drift& drift, const LinearFit& fit) {
  const Index errors = std::ssize(record.errors);
  CycleResult result = cycle_result(fit, errors, record.std * record.std);
  result.degrees_of_freedom -= drift.columns.cols();
  result.time = 0.5 * (cycle.first_time() + cycle.last_time());
  result.drift_estimated = drift.estimated();
  if (result.drift_estimated) {
    result.drift = drift.inverse.topRows<3>() * equations.deviation;
    result.drift_std = record.std * drift.inverse.topRows<3>().rowwise().norm();
  }
  for (Index at = errors; at < errors + equations.harmonics; at += 6) {
    Harmonic harmonic{static_cast<int>((at - errors) / 6) + 2, fit.value.segment<3>(at), fit.value.segment<3>(at + 3)};
    for (Index i = 0; i < 3; ++i) {
      if (fit.hides(at + i)) harmonic.cosine[i] = nan;
      if (fit.hides(at + 3 + i)) harmonic.sine[i] = nan;
    }
    result.harmonics.push_back(harmonic);
  }
  return result;
}

}  // namespace

RTestAnalysis analyse(const RTestRecord& record) {
  compensation::OffsetOptions options;
  options.table_radius = record.table_radius;
  const LocationOffsets map(record.chain, options);
  const std::string place = core::toml_place(record.source, "", "errors");
  const std::vector<ErrorTerm> terms = error_terms(record.errors, map, record.chain, place);
  RTestAnalysis result;
  result.errors = record.errors;
  result.units = units_of_errors(record.errors);
  std::vector<bool> named(record.errors.size(), false);
  for (const RTestCycle& cycle : record.cycles) {
    const Equations equations = equations_of(record, cycle, map, terms);
    if (equations.rows.rows() < equations.rows.cols()) {
      throw InputError(
          cycle.place, fmt::format("{} points for {} parameters", cycle.points.size(), equations.rows.cols()),
          fmt::format("at least {} points, or fewer errors and harmonics", (equations.rows.cols() + 2) / 3));
    }
    const Drift drift = drift_of(record, cycle, terms, equations.rows.leftCols(std::ssize(record.errors)));
    const LinearFit fit = fit_cycle(equations, drift);
    for (std::size_t e = 0; e < record.errors.size(); ++e) {
      if (named[e] || !fit.hides(e)) continue;
      named[e] = true;
      result.not_observable.push_back(record.errors[e] +
                                      ": not observable: " + fit.same_effect(record.errors, e, nuisance));
    }
    result.cycles.push_back(result_of(record, cycle, equations, drift, fit));
  }
  const bool none = std::all_of(result.cycles.begin(), result.cycles.end(),
                                [](const CycleResult& cycle) { return cycle.value.array().isNaN().all(); });
  if (none) {
    throw InputError(place, "no observable error: " + core::join(result.not_observable, "; "),
                     "points that distinguish at least one error");
  }
  complete(result.cycles, record.against_first);
  return result;
}

}  // namespace thermotwin::metrology
