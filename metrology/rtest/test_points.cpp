// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/test_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "core/units.h"

namespace thermotwin::metrology {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr double turn = 2.0 * std::numbers::pi;
constexpr double same_position = 2e-3;  ///< m or rad
constexpr double same_weight = 0.02;    ///< of the largest weight of an error

/// Points with their weights, in order of time.
struct Weighted {
  std::vector<RTestPoint> points;
  MatrixXd weights;
};

Weighted thinned(const RTestCycle& cycle, const MatrixXd& functional) {
  const Index count = std::ssize(cycle.points), kept = std::min(count, most_poses);
  Weighted result;
  result.weights.setZero(functional.rows(), 3 * kept);
  if (kept == count) return {cycle.points, functional};
  for (Index k = 0; k < kept; ++k) result.points.push_back(cycle.points[k * (count - 1) / (kept - 1)]);
  for (Index i = 0, left = 0; i < count; ++i) {
    while (left + 2 < kept && (left + 1) * (count - 1) / (kept - 1) <= i) ++left;
    const Index first = left * (count - 1) / (kept - 1), last = (left + 1) * (count - 1) / (kept - 1);
    const double way = last - first, share = (i - first) / way;
    const auto own = functional.middleCols(3 * i, 3);
    result.weights.middleCols(3 * left, 3) += (1.0 - share) * own;
    result.weights.middleCols(3 * left + 3, 3) += share * own;
  }
  return result;
}

bool agree(const mesh::KinematicChain& chain, const Weighted& a, const Weighted& b) {
  if (a.points.size() != b.points.size()) return false;
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    for (const auto& [axis, position] : a.points[i].positions) {
      const auto other = b.points[i].positions.find(axis);
      if (other == b.points[i].positions.end()) return false;
      double apart = position - other->second;
      if (chain.find(axis)->rotary) apart = std::remainder(apart, turn);
      if (std::abs(apart) > same_position) return false;
    }
  }
  for (Index e = 0; e < a.weights.rows(); ++e) {
    const bool hidden = std::isnan(a.weights(e, 0));
    if (hidden != std::isnan(b.weights(e, 0))) return false;
    if (!hidden && (a.weights.row(e) - b.weights.row(e)).cwiseAbs().maxCoeff() >
                       same_weight * a.weights.row(e).cwiseAbs().maxCoeff()) {
      return false;
    }
  }
  return true;
}

}  // namespace

std::string place_text(const RTestRecord& record, const RTestPoint& point) {
  std::string text;
  for (const auto& [axis, position] : point.positions) {
    const bool rotary = record.chain.find(axis)->rotary;
    double at = position;
    if (rotary && std::abs(at) > turn - 1e-7) at = std::remainder(at, turn);
    if (std::abs(at) < 1e-7) at = 0.0;
    text +=
        fmt::format("{}{}={:.9g}", text.empty() ? "" : ",", axis, at / (rotary ? core::units::deg : core::units::mm));
  }
  return text;
}

TestPoints common_points(const RTestRecord& record, const RTestAnalysis& analysis) {
  std::vector<Weighted> cycles;
  for (std::size_t c = 0; c < record.cycles.size(); ++c) {
    const MatrixXd& functional = analysis.cycles[c].functional;
    if (functional.cols() != 3 * std::ssize(record.cycles[c].points)) {
      TestPoints none;
      none.too_many = functional.size() == 0;
      return none;
    }
    cycles.push_back(thinned(record.cycles[c], functional));
  }
  std::vector<bool> best(cycles.size(), false), seen = best;
  std::size_t most = 0, of = 0;
  for (std::size_t c = 0; c < cycles.size(); ++c) {
    if (seen[c]) continue;
    std::vector<bool> same(cycles.size(), false);
    for (std::size_t k = c; k < cycles.size(); ++k) {
      same[k] = !seen[k] && agree(record.chain, cycles[c], cycles[k]);
      if (same[k]) seen[k] = true;
    }
    const std::size_t count = std::count(same.begin(), same.end(), true);
    if (count <= most) continue;
    most = count;
    of = c;
    best = same;
  }
  if (2 * most < cycles.size() || most == 0) return {};
  TestPoints result;
  for (const RTestPoint& point : cycles[of].points) result.poses.push_back(place_text(record, point));
  result.weights = cycles[of].weights;
  result.of_cycles = best;
  return result;
}

}  // namespace thermotwin::metrology
