// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/drift.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/dense_algebra.h"
#include "metrology/fit/estimates.h"

namespace thermotwin::metrology {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double of_a_step = 0.25;      ///< of the mean step that still is the same place
constexpr double least_distinct = 0.3;  ///< of the effect of a drift that is no sum of others at the repeated points
constexpr double least_shown = 0.3;     ///< of the effect on all points that differences between visits show

/// Distance of two points in units of the tolerance. Positions of a rotary axis count modulo a turn.
double distance_of(const mesh::KinematicChain& chain, const RTestPoint& a, const RTestPoint& b) {
  double most = (a.nominal - b.nominal).norm() / same_length;
  for (const auto& [axis, position] : a.positions) {
    double difference = position - b.positions.at(axis);
    const bool rotary = chain.find(axis)->rotary;
    if (rotary) difference = std::remainder(difference, 2.0 * std::numbers::pi);
    most = std::max(most, std::abs(difference) / (rotary ? same_angle : same_length));
  }
  return most;
}

/// In units of the tolerance.
double tolerance_of(const mesh::KinematicChain& chain, const RTestCycle& cycle) {
  double way = 0.0;
  for (std::size_t i = 1; i < cycle.points.size(); ++i) way += distance_of(chain, cycle.points[i - 1], cycle.points[i]);
  return std::clamp(of_a_step * way / std::max(1.0, cycle.points.size() - 1.0), 1e-4, 1.0);
}

/// (points) the first point at the same place
std::vector<Index> places_of(const mesh::KinematicChain& chain, const RTestCycle& cycle) {
  const double limit = tolerance_of(chain, cycle);
  const auto x = [&](Index i) { return cycle.points[i].nominal[0]; };
  std::vector<Index> order(cycle.points.size()), places(order.size());
  std::iota(order.begin(), order.end(), Index{0});
  places = order;
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return x(a) < x(b); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (std::size_t k = i; k-- > 0 && x(order[i]) - x(order[k]) <= limit * same_length;) {
      if (distance_of(chain, cycle.points[order[i]], cycle.points[order[k]]) > limit) continue;
      const Index first = std::min(places[order[i]], places[order[k]]);
      places[order[i]] = places[order[k]] = first;
    }
  }
  return places;
}

/// Visits that are not exactly at one place: what the parameters of the fit differ between them is taken off, so that
/// v = inverse (d - A W (d - C v)) with the fit W of the deviations without drift.
void take_off_errors(const MatrixXd& rows, Drift& drift) {
  const MatrixXd leak = drift.inverse * rows;
  if (!(leak.norm() > 1e-12 * drift.inverse.norm() * rows.norm())) return;
  const MatrixXd by_errors = leak * fit_linear(rows, VectorXd::Zero(rows.rows())).inverse;
  const Index drifts = drift.columns.cols();
  const MatrixXd own = MatrixXd::Identity(drifts, drifts) - by_errors * drift.columns;
  drift.inverse = MatrixXd(own.inverse() * (drift.inverse - by_errors));
}

}  // namespace

VectorXd time_shares(const RTestCycle& cycle) {
  const double length = std::max(1e-9, cycle.last_time() - cycle.first_time()),
               middle = 0.5 * (cycle.first_time() + cycle.last_time());
  VectorXd tau(std::ssize(cycle.points));
  for (Index i = 0; i < tau.size(); ++i) tau[i] = (cycle.points[i].time - middle) / length;
  return tau;
}

Drift drift_of(const RTestRecord& record, const RTestCycle& cycle, const std::vector<ErrorTerm>& terms,
               const MatrixXd& rows) {
  const Index points = std::ssize(cycle.points);
  Drift drift{MatrixXd(3 * points, 0), MatrixXd(0, 3 * points)};
  if (!record.drift) return drift;
  const std::vector<Index> places = places_of(record.chain, cycle);
  const VectorXd tau = time_shares(cycle);
  VectorXd visits = VectorXd::Zero(points);
  for (Index i = 0; i < points; ++i) visits[places[i]] += 1.0;
  const auto within_places = [&](MatrixXd of) {
    MatrixXd means = MatrixXd::Zero(of.rows(), of.cols());
    for (Index i = 0; i < points; ++i)
      means.middleRows<3>(3 * places[i]) += of.middleRows<3>(3 * i) / visits[places[i]];
    for (Index i = 0; i < points; ++i) of.middleRows<3>(3 * i) -= means.middleRows<3>(3 * places[i]);
    return of;
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
    if (rotation || name == "R0T") add(in_time(rows.col(e), 1), least_shown);
  }
  for (int i = 0; i < 3; ++i) add(in_time(alike(i), 2), least_shown);
  const LinearFit fit = fit_linear(within_places(drift.columns), VectorXd::Zero(3 * points));
  drift.inverse = within_places(fit.inverse.transpose()).transpose();
  take_off_errors(rows, drift);
  return drift;
}

}  // namespace thermotwin::metrology
