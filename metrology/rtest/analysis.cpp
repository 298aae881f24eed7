// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/analysis.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "compensation/chain/location_offsets.h"
#include "core/dense_algebra.h"
#include "core/error.h"
#include "core/text.h"
#include "core/toml_place.h"
#include "core/units.h"

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
constexpr double weakest = 1e-7;  ///< smallest singular value over the largest that counts as observed

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
  MatrixXd rows;  ///< (3 points x parameters): errors, drift, harmonics, shifts of the table
  VectorXd deviation;
  Index drift = 0;  ///< columns
};

Equations equations_of(const RTestRecord& record, const RTestCycle& cycle, const LocationOffsets& map) {
  const Index errors = std::ssize(record.errors), points = std::ssize(cycle.points);
  Equations result;
  result.drift = record.drift && repeats_a_point(record.chain, cycle) ? 3 : 0;
  const int orders = std::max(0, record.harmonics - 1);
  const Turning axis = orders > 0 ? outermost(record) : Turning();
  const MatrixXd shifts = table_shifts(record, cycle);
  const auto last = static_cast<int>(std::ssize(record.chain.table)) - 1;
  result.rows = MatrixXd::Zero(3 * points, errors + result.drift + 6 * orders + shifts.cols());
  result.deviation.resize(3 * points);
  const double length = std::max(1e-9, cycle.last_time() - cycle.first_time());
  const double middle = 0.5 * (cycle.first_time() + cycle.last_time());
  for (Index i = 0; i < points; ++i) {
    const RTestPoint& point = cycle.points[i];
    result.deviation.segment<3>(3 * i) = point.deviation;
    for (Index e = 0; e < errors; ++e) {
      result.rows.block<3, 1>(3 * i, e) = map.motion_of(record.errors[e], 1.0, point.positions, point.nominal).shift;
    }
    if (result.drift > 0)
      result.rows.block<3, 3>(3 * i, errors) = (point.time - middle) / length * Matrix3d::Identity();
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
  return result;
}

/// Least squares in columns of norm 1, without the directions that the points do not observe.
struct Solution {
  VectorXd value;       ///< (parameters)
  MatrixXd cofactor;    ///< (parameters x parameters)
  MatrixXd unobserved;  ///< (parameters x directions), in the scaled parameters
  double sum_of_squares = 0;
};

Solution solve(const Equations& equations) {
  const MatrixXd& rows = equations.rows;
  VectorXd scale = rows.colwise().norm();
  const double largest = scale.size() > 0 ? scale.maxCoeff() : 0.0;
  for (double& value : scale)
    if (!(value > 1e-12 * largest)) value = std::max(largest, 1e-300);
  const MatrixXd scaled = rows * scale.cwiseInverse().asDiagonal();
  const Eigen::JacobiSVD<MatrixXd> parts(scaled, Eigen::ComputeThinU | Eigen::ComputeFullV);
  const VectorXd singular = parts.singularValues();
  Index rank = 0;
  while (rank < singular.size() && singular[rank] > weakest * singular[0]) ++rank;
  const MatrixXd v = parts.matrixV().leftCols(rank);
  const VectorXd inverse = singular.head(rank).cwiseInverse();
  Solution result;
  const MatrixXd root = scale.cwiseInverse().asDiagonal() * v * inverse.asDiagonal();
  result.value = root * (parts.matrixU().leftCols(rank).transpose() * equations.deviation);
  result.cofactor = root * root.transpose();
  result.unobserved = parts.matrixV().rightCols(rows.cols() - rank);
  result.sum_of_squares = (equations.deviation - rows * result.value).squaredNorm();
  return result;
}

bool hidden(const Solution& solution, Index parameter) {
  return solution.unobserved.cols() > 0 && solution.unobserved.row(parameter).norm() > 1e-5;
}

/// The other parameters that make up for this one.
std::string with_the_same_effect(const RTestRecord& record, const Solution& solution, Index parameter) {
  const VectorXd together = solution.unobserved * solution.unobserved.row(parameter).transpose();
  std::vector<std::string> names;
  for (Index i = 0; i < together.size(); ++i) {
    if (i == parameter || std::abs(together[i]) < 1e-5) continue;
    if (i < std::ssize(record.errors)) {
      names.push_back(record.errors[i]);
    } else if (names.empty() || names.back() != "a drift, a harmonic or a shift of the table") {
      names.emplace_back("a drift, a harmonic or a shift of the table");
    }
  }
  return names.empty() ? "no point shows it" : "the points do not distinguish it from " + core::join(names);
}

CycleResult cycle_result(const RTestRecord& record, const RTestCycle& cycle, const Equations& equations,
                         const Solution& solution) {
  const Index errors = std::ssize(record.errors);
  CycleResult result;
  result.time = 0.5 * (cycle.first_time() + cycle.last_time());
  result.parameters = equations.rows.cols();
  result.rank = result.parameters - solution.unobserved.cols();
  result.degrees_of_freedom = equations.rows.rows() - result.rank;
  result.residual_rms = std::sqrt(solution.sum_of_squares / equations.rows.rows());
  const double variance = record.std * record.std;
  result.value = solution.value.head(errors);
  result.covariance = variance * solution.cofactor.topLeftCorner(errors, errors);
  for (Index e = 0; e < errors; ++e) {
    if (!hidden(solution, e)) continue;
    result.value[e] = nan;
    result.covariance.row(e).setConstant(nan);
    result.covariance.col(e).setConstant(nan);
  }
  result.drift_estimated = equations.drift > 0 && !hidden(solution, errors) && !hidden(solution, errors + 1) &&
                           !hidden(solution, errors + 2);
  if (result.drift_estimated) {
    result.drift = solution.value.segment<3>(errors);
    result.drift_std = (variance * solution.cofactor.diagonal().segment<3>(errors)).cwiseSqrt();
  }
  for (Index at = errors + equations.drift; at + 6 <= solution.value.size(); at += 6) {
    Harmonic harmonic{static_cast<int>((at - errors - equations.drift) / 6) + 2, solution.value.segment<3>(at),
                      solution.value.segment<3>(at + 3)};
    for (Index i = 0; i < 3; ++i) {
      if (hidden(solution, at + i)) harmonic.cosine[i] = nan;
      if (hidden(solution, at + 3 + i)) harmonic.sine[i] = nan;
    }
    result.harmonics.push_back(harmonic);
  }
  return result;
}

/// Differences to the first cycle, whose covariance adds.
void subtract_first(std::vector<CycleResult>& cycles) {
  const VectorXd first = cycles.front().value;
  const MatrixXd covariance = cycles.front().covariance;
  for (CycleResult& cycle : cycles) {
    const bool is_first = &cycle == &cycles.front();
    cycle.value -= first;
    if (is_first) {
      cycle.covariance -= covariance;
    } else {
      cycle.covariance += covariance;
    }
  }
}

}  // namespace

bool RTestAnalysis::turns(std::size_t error) const { return errors[error][0] >= 'A' && errors[error][0] <= 'C'; }

RTestAnalysis analyse(const RTestRecord& record) {
  compensation::OffsetOptions options;
  options.table_radius = record.table_radius;
  const LocationOffsets map(record.chain, options);
  for (const std::string& error : record.errors) {
    const auto& known = map.known_errors();
    if (std::find(known.begin(), known.end(), error) != known.end()) continue;
    throw InputError(core::toml_place(record.source, "", "errors"), "'" + error + "'",
                     "of this chain: " + core::join(known) + " (nearest: " + core::nearest(error, known) + ")");
  }
  RTestAnalysis result;
  result.errors = record.errors;
  std::vector<bool> named(record.errors.size(), false);
  for (const RTestCycle& cycle : record.cycles) {
    const Equations equations = equations_of(record, cycle, map);
    if (equations.rows.rows() < equations.rows.cols()) {
      throw InputError(
          cycle.place, fmt::format("{} points for {} parameters", cycle.points.size(), equations.rows.cols()),
          fmt::format("at least {} points, or fewer errors and harmonics", (equations.rows.cols() + 2) / 3));
    }
    const Solution solution = solve(equations);
    for (std::size_t e = 0; e < record.errors.size(); ++e) {
      if (named[e] || !hidden(solution, e)) continue;
      named[e] = true;
      result.not_observable.push_back(record.errors[e] +
                                      ": not observable: " + with_the_same_effect(record, solution, e));
    }
    result.cycles.push_back(cycle_result(record, cycle, equations, solution));
  }
  const bool none = std::all_of(result.cycles.begin(), result.cycles.end(),
                                [](const CycleResult& cycle) { return cycle.value.array().isNaN().all(); });
  if (none) {
    throw InputError(core::toml_place(record.source, "", "errors"),
                     "no observable error: " + core::join(result.not_observable, "; "),
                     "points that distinguish at least one error");
  }
  if (record.against_first) subtract_first(result.cycles);
  for (CycleResult& cycle : result.cycles) cycle.std = cycle.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  for (CycleResult& cycle : result.cycles) {
    for (Index e = 0; e < cycle.std.size(); ++e)
      if (std::isnan(cycle.value[e])) cycle.std[e] = nan;
  }
  return result;
}

}  // namespace thermotwin::metrology
