// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/elastic/system.h"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <set>

#include "core/error.h"
#include "core/text.h"
#include "solver/elastic/loosest_motion.h"

namespace thermotwin::solver {

namespace {
constexpr double singular_below = 1e-13;    // reciprocal condition of the scaled system
constexpr double hardly_held_below = 1e-4;  // of the usual stiffness: a lever of a hundredth of the body's length

/// The joints with the pads that they have.
std::string joints_of(const mesh::Machine& machine, const std::vector<int>& joints) {
  std::vector<std::string> texts;
  for (const int joint : joints) {
    const mesh::JointSpec& spec = machine.joints[joint];
    texts.push_back("'" + spec.id + "' with " +
                    (spec.sectors > 0
                         ? fmt::format("sectors = {}", spec.sectors)
                         : fmt::format("divide = [{}, {}, {}]", spec.divide[0], spec.divide[1], spec.divide[2])));
  }
  return texts.empty() ? "no joint with stiffness touches it" : "its joints with stiffness: " + core::join(texts);
}

std::string names_of(const mesh::Machine& machine, const std::vector<int>& bodies) {
  std::vector<std::string> names;
  for (const int body : bodies) names.push_back("'" + machine.bodies[body].id + "'");
  return core::join(names);
}

}  // namespace

void require_held(const mesh::Machine& machine, const std::vector<int>& elastic, const std::vector<Spring>& springs) {
  std::set<int> held;
  for (const Spring& spring : springs)
    for (const UnitTerm& term : spring.gap) held.insert(term.body);
  for (int body : elastic) {
    if (!held.contains(body)) {
      throw core::MeshError(machine.path.filename().string() + " body '" + machine.bodies[body].id + "'",
                            "no joint with stiffness touches it at home", "joints that hold it, or elastic = false");
    }
  }
}

SmallSystem::SmallSystem(const mesh::Machine& machine, const std::vector<int>& elastic,
                         const std::vector<BodyResponse>& responses, std::vector<Spring> springs)
    : elastic_(elastic),
      responses_(responses),
      springs_(std::move(springs)) {
  const auto count = std::ssize(springs_);
  const Eigen::Index size = count + 6 * std::ssize(elastic);
  std::vector<Combination> gaps;
  gaps.reserve(springs_.size());
  for (const Spring& spring : springs_) gaps.push_back(spring.gap);

  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index s = 0; s < count; ++s) matrix(s, s) = springs_[s].flexibility;
  for (std::size_t i = 0; i < elastic.size(); ++i) {
    gaps_.push_back(entries(i, gaps));
    const BodyResponse& response = responses[elastic[i]];
    for (const Entry& a : gaps_.back()) {
      for (const Entry& b : gaps_.back())
        matrix(a.column, b.column) += a.weight * b.weight * response.gram(a.unit, b.unit);
      matrix.block<1, 6>(a.column, count + 6 * i) -= a.weight * response.rigid.col(a.unit).transpose();
    }
  }
  matrix.bottomLeftCorner(size - count, count) = matrix.topRightCorner(count, size - count).transpose();
  double compliance = 0.0;
  for (Eigen::Index s = 0; s < count; ++s) compliance += std::log(std::max(matrix(s, s), 1e-300));
  compliance = count > 0 ? std::exp(compliance / count) : 1.0;  // geometric mean
  force_scale_ = 1.0 / std::sqrt(compliance);
  motion_scale_ = std::sqrt(compliance);
  matrix.topLeftCorner(count, count) *= force_scale_ * force_scale_;  // the other blocks keep their size
  factor_.compute(matrix);
  // Eigen's estimate misses pivots that are exactly 0; they are looked at by themselves.
  const Eigen::VectorXd pivots = factor_.matrixLU().diagonal().cwiseAbs();
  if (!(factor_.rcond() > singular_below) || !(pivots.minCoeff() > singular_below * pivots.maxCoeff()))
    require_regular(machine, matrix);
}

std::vector<SmallSystem::Entry> SmallSystem::entries(std::size_t elastic,
                                                     const std::vector<Combination>& columns) const {
  std::vector<Entry> found;
  for (Eigen::Index c = 0; c < std::ssize(columns); ++c) {
    for (const UnitTerm& term : columns[c])
      if (term.body == elastic_[elastic] && term.weight != 0.0) found.push_back({c, term.unit, term.weight});
  }
  return found;
}

std::string SmallSystem::hardly_held(const mesh::Machine& machine) const {
  const LoosestMotion loosest = loosest_motion(elastic_, responses_, springs_);
  if (loosest.ratio > hardly_held_below) return "";
  return fmt::format(
      "{} body {}: hardly held; free {} but for {:.1g} of the usual stiffness; {}; displacements depend on the mesh "
      "there; allowed: pads apart from each other across that line (divide, sectors), or stiffness along that motion",
      machine.path.filename().string(), names_of(machine, loosest.bodies), loosest.motion, loosest.ratio,
      joints_of(machine, loosest.joints));
}

void SmallSystem::require_regular(const mesh::Machine& machine, const Eigen::MatrixXd& matrix) const {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(matrix);
  Eigen::Index loose = 0;
  const double smallest = eigen.eigenvalues().cwiseAbs().minCoeff(&loose);
  if (smallest > singular_below * eigen.eigenvalues().cwiseAbs().maxCoeff()) return;
  const Eigen::VectorXd mode = eigen.eigenvectors().col(loose);
  if (mode.tail(6 * std::ssize(elastic_)).cwiseAbs().maxCoeff() < 1e-3) {
    throw core::MeshError(machine.path.filename().string() + " scale", "two constraints hold the same motion",
                          "one scale an axis");
  }
  const LoosestMotion loosest = loosest_motion(elastic_, responses_, springs_);
  throw core::MeshError(
      machine.path.filename().string() + " body " + names_of(machine, loosest.bodies),
      fmt::format("nothing holds it: it is free {}; {}{}", loosest.motion, joints_of(machine, loosest.joints),
                  loosest.turns ? "; a pad carries the mean motion of its surface, so one pad holds no rotation, and "
                                  "pads on one line hold none about that line"
                                : ""),
      loosest.turns
          ? "joints that hold rotations: divide of 2 x 2 or more cells across the contact ([2, 2, 1] where it is "
            "normal to z), "
            "sectors of 3 or more, or several pads or joints apart from each other"
          : "joints or a scale that hold every body in all six directions: stiffness_normal_N_mm3 across a contact, "
            "stiffness_tangential_N_mm3 along it; a guide is free along its axis");
}

Eigen::MatrixXd SmallSystem::solve_scaled(const Eigen::MatrixXd& right_hand_side) const {
  const auto count = std::ssize(springs_);
  Eigen::MatrixXd scaled = right_hand_side;
  scaled.topRows(count) *= force_scale_;
  scaled.bottomRows(scaled.rows() - count) *= motion_scale_;
  scaled = factor_.solve(scaled).eval();
  scaled.topRows(count) *= force_scale_;
  scaled.bottomRows(scaled.rows() - count) *= motion_scale_;
  return scaled;
}

Eigen::MatrixXd SmallSystem::adjoint_forces(const std::vector<Combination>& outputs) const {
  const auto count = std::ssize(springs_);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(factor_.rows(), std::ssize(outputs));
  for (std::size_t i = 0; i < elastic_.size(); ++i) {
    const BodyResponse& response = responses_[elastic_[i]];
    for (const Entry& c : entries(i, outputs)) {
      for (const Entry& s : gaps_[i]) right(s.column, c.column) -= s.weight * c.weight * response.gram(s.unit, c.unit);
      right.block<6, 1>(count + 6 * i, c.column) += c.weight * response.rigid.col(c.unit);
    }
  }
  return solve_scaled(right).topRows(count);
}

std::pair<Eigen::MatrixXd, Eigen::MatrixXd> SmallSystem::stiffness_change(int joint,
                                                                          const Eigen::MatrixXd& forces) const {
  // M f = b with 1/k on the diagonal, which falls as exp(-ln k): M' = -D, M'' = D of the joint's springs, so
  // M f' = D f and M f'' = D (2 f' - f).
  const auto solve = [&](const Eigen::MatrixXd& loads) {
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(factor_.rows(), loads.cols());
    for (std::size_t s = 0; s < springs_.size(); ++s)
      if (springs_[s].joint == joint) right.row(s) = springs_[s].flexibility * loads.row(s);
    return Eigen::MatrixXd(solve_scaled(right).topRows(loads.rows()));
  };
  const Eigen::MatrixXd first = solve(forces);
  return {first, solve(2.0 * first - forces)};
}

Eigen::MatrixXd SmallSystem::unit_weights(int body, const std::vector<Combination>& outputs,
                                          const Eigen::MatrixXd& forces) const {
  const auto at = std::find(elastic_.begin(), elastic_.end(), body);
  const std::size_t i = at - elastic_.begin();
  Eigen::MatrixXd weights = Eigen::MatrixXd::Zero(responses_[body].gram.rows(), forces.cols());
  for (const Entry& c : entries(i, outputs)) weights(c.unit, c.column) += c.weight;
  for (const Entry& s : gaps_[i]) weights.row(s.unit) += s.weight * forces.row(s.column);
  return weights;
}

SmallSystem::Solution SmallSystem::solve(const std::vector<Eigen::VectorXd>& unit_motions,
                                         const std::function<double(int body, Eigen::Index node)>& temperature) const {
  const auto count = std::ssize(springs_);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(factor_.rows());
  for (Eigen::Index s = 0; s < count; ++s) {
    const Spring& spring = springs_[s];
    for (const UnitTerm& term : spring.gap) right[s] += term.weight * unit_motions[term.body][term.unit];
    for (const auto& [node, per_kelvin] : spring.expansion)
      right[s] -= per_kelvin * temperature(spring.expansion_body, node);
  }
  const Eigen::VectorXd solution = solve_scaled(right);
  return {solution.head(count), solution.tail(solution.size() - count)};
}

}  // namespace thermotwin::solver
