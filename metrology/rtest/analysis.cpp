// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/analysis.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

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

/// Positions of a rotary axis count modulo a turn.
bool same_place(const mesh::KinematicChain& chain, const RTestPoint& a, const RTestPoint& b) {
  if ((a.nominal - b.nominal).norm() > 1e-6) return false;
  return std::all_of(a.positions.begin(), a.positions.end(), [&](const auto& at) {
    double apart = at.second - b.positions.at(at.first);
    if (chain.find(at.first)->rotary) apart = std::remainder(apart, 2.0 * std::numbers::pi);
    return std::abs(apart) < 1e-6;
  });
}

bool repeats_a_point(const mesh::KinematicChain& chain, const RTestCycle& cycle) {
  for (std::size_t i = 0; i < cycle.points.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k)
      if (same_place(chain, cycle.points[i], cycle.points[k])) return true;
  }
  return false;
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
  MatrixXd rows;  ///< (3 points x parameters): errors, drift, harmonics, shifts of the table, drift of errors
  VectorXd deviation;
  Index drift = 0;   ///< columns of the drift of all points
  Index others = 0;  ///< columns of harmonics
};

constexpr double least_distinct = 0.3;  ///< of an effect that is no sum of others
constexpr Index least_freedom = 2;      ///< coordinates beyond the parameters that drifts of errors leave

/// Columns for the drift of growth and rotations where the points distinguish it.
/// @param moves  (3 points x errors)  @param tau  (points) -1/2 to 1/2 over the cycle
void add_drifts_of_errors(const std::vector<ErrorTerm>& terms, const MatrixXd& moves, const VectorXd& tau,
                          MatrixXd& rows) {
  std::vector<Index> order;
  for (const bool growth : {true, false}) {
    for (Index e = 0; e < std::ssize(terms); ++e) {
      const std::string& name = terms[e].name;
      const bool rotation = terms[e].power == 0 && name[0] >= 'A' && name[0] <= 'C';
      if (growth ? name == "R0T" : rotation) order.push_back(e);
    }
  }
  std::vector<VectorXd> basis;  // orthonormal, of the effects so far
  const auto left_of = [&](VectorXd column) {
    for (int pass = 0; pass < 2; ++pass)
      for (const VectorXd& known : basis) column -= known * known.dot(column);
    return column;
  };
  const auto add = [&](const VectorXd& column, double least) {
    const VectorXd left = left_of(column);
    const bool distinct = left.norm() > least * column.norm();
    if (distinct) basis.emplace_back(left.normalized());
    return distinct;
  };
  for (const auto& column : rows.colwise()) add(column, weakest);
  for (const Index e : order) {
    VectorXd column = moves.col(e);
    for (Index i = 0; i < tau.size(); ++i) column.segment<3>(3 * i) *= tau[i];
    if (rows.cols() + least_freedom >= rows.rows() || !add(column, least_distinct)) continue;
    rows.conservativeResize(Eigen::NoChange, rows.cols() + 1);
    rows.rightCols(1) = column;
  }
}

Equations equations_of(const RTestRecord& record, const RTestCycle& cycle, const LocationOffsets& map,
                       const std::vector<ErrorTerm>& terms) {
  const Index errors = std::ssize(record.errors), points = std::ssize(cycle.points);
  Equations result;
  result.drift = record.drift && repeats_a_point(record.chain, cycle) ? 3 : 0;
  const int orders = std::max(0, record.harmonics - 1);
  const Turning axis = orders > 0 ? outermost(record) : Turning();
  const MatrixXd shifts = record.table_shift ? table_shifts(record, cycle) : MatrixXd(3, 0);
  const auto last = static_cast<int>(std::ssize(record.chain.table)) - 1;
  result.rows = MatrixXd::Zero(3 * points, errors + result.drift + 6 * orders + shifts.cols());
  result.deviation.resize(3 * points);
  const double length = std::max(1e-9, cycle.last_time() - cycle.first_time());
  const double middle = 0.5 * (cycle.first_time() + cycle.last_time());
  VectorXd tau(points);
  for (Index i = 0; i < points; ++i) {
    const RTestPoint& point = cycle.points[i];
    result.deviation.segment<3>(3 * i) = point.deviation;
    for (Index e = 0; e < errors; ++e) {
      result.rows.block<3, 1>(3 * i, e) = shift_of(terms[e], map, point.positions, point.nominal);
    }
    tau[i] = (point.time - middle) / length;
    if (result.drift > 0) result.rows.block<3, 3>(3 * i, errors) = tau[i] * Matrix3d::Identity();
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
      const Index column = errors + result.drift + 6 * n;
      result.rows.block<3, 3>(3 * i, column) = sign * std::cos((n + 2) * angle) * frame;
      result.rows.block<3, 3>(3 * i, column + 3) = sign * std::sin((n + 2) * angle) * frame;
    }
  }
  result.others = 6 * orders;
  if (result.drift > 0)
    add_drifts_of_errors(terms, result.rows.leftCols(errors), tau, result.rows);
  return result;
}

constexpr const char* nuisance = "a drift, a harmonic or a shift of the table";

CycleResult result_of(const RTestRecord& record, const RTestCycle& cycle, const Equations& equations,
                      const LinearFit& fit) {
  const Index errors = std::ssize(record.errors);
  CycleResult result = cycle_result(fit, errors, record.std * record.std);
  result.time = 0.5 * (cycle.first_time() + cycle.last_time());
  result.drift_estimated =
      equations.drift > 0 && !fit.hides(errors) && !fit.hides(errors + 1) && !fit.hides(errors + 2);
  if (result.drift_estimated) {
    result.drift = fit.value.segment<3>(errors);
    result.drift_std = record.std * fit.cofactor.diagonal().segment<3>(errors).cwiseSqrt();
  }
  const Index first = errors + equations.drift;
  for (Index at = first; at < first + equations.others; at += 6) {
    Harmonic harmonic{static_cast<int>((at - first) / 6) + 2, fit.value.segment<3>(at),
                      fit.value.segment<3>(at + 3)};
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
    const LinearFit fit = fit_linear(equations.rows, equations.deviation);
    for (std::size_t e = 0; e < record.errors.size(); ++e) {
      if (named[e] || !fit.hides(e)) continue;
      named[e] = true;
      result.not_observable.push_back(record.errors[e] +
                                      ": not observable: " + fit.same_effect(record.errors, e, nuisance));
    }
    result.cycles.push_back(result_of(record, cycle, equations, fit));
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
