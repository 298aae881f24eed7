// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/analysis.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "compensation/chain/location_offsets.h"
#include "core/error.h"
#include "core/text.h"
#include "core/toml_place.h"
#include "core/units.h"
#include "metrology/rtest/drift.h"
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
  const Index last = std::ssize(record.chain.table) - 1;
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

/// (errors x 3) of a common drift of 1 m over the cycle that is not taken off.
MatrixXd effect_of_drift(const RTestCycle& cycle, const LinearFit& fit, Index errors) {
  const VectorXd tau = time_shares(cycle);
  MatrixXd effect = MatrixXd::Zero(errors, 3);
  for (Index i = 0; i < tau.size(); ++i) effect += tau[i] * fit.inverse.block(0, 3 * i, errors, 3);
  return effect;
}

/// A cycle without a repeated point may drift as the others do: their mean square is in its covariance.
void widen(std::vector<CycleResult>& cycles, const std::vector<MatrixXd>& effects) {
  Matrix3d squares = Matrix3d::Zero();
  double known = 0.0;
  for (const CycleResult& cycle : cycles) {
    if (!cycle.drift_estimated) continue;
    squares += cycle.drift * cycle.drift.transpose();
    known += 1.0;
  }
  if (known == 0.0) return;
  for (std::size_t i = 0; i < cycles.size(); ++i) {
    if (cycles[i].drift_estimated) continue;
    cycles[i].covariance += effects[i] * (squares / known) * effects[i].transpose();
  }
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
  result.not_estimated = record.left_out;
  result.units = units_of_errors(record.errors);
  std::vector<bool> named(record.errors.size(), false);
  std::vector<MatrixXd> effects;
  for (const RTestCycle& cycle : record.cycles) {
    const Equations equations = equations_of(record, cycle, map, terms);
    if (equations.rows.rows() < equations.rows.cols()) {
      throw InputError(
          cycle.place, fmt::format("{} points for {} parameters", cycle.points.size(), equations.rows.cols()),
          fmt::format("at least {} points, or fewer errors and harmonics", (equations.rows.cols() + 2) / 3));
    }
    const Drift drift = drift_of(record, cycle, terms, equations.rows);
    const LinearFit fit = fit_cycle(equations, drift);
    for (std::size_t e = 0; e < record.errors.size(); ++e) {
      if (named[e] || !fit.hides(e)) continue;
      named[e] = true;
      result.not_observable.push_back(record.errors[e] +
                                      ": not observable: " + fit.same_effect(record.errors, e, nuisance));
    }
    result.cycles.push_back(result_of(record, cycle, equations, drift, fit));
    effects.push_back(drift.estimated() ? MatrixXd() : effect_of_drift(cycle, fit, std::ssize(record.errors)));
  }
  if (record.drift) widen(result.cycles, effects);
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
