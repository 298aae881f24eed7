// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/elastic/loosest_motion.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "solver/elastic/system.h"

namespace thermotwin::solver {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double takes_part = 0.3;  // of the motion of the body that moves most

/// "x" for a direction along an axis, else its components.
std::string direction_words(const Eigen::Vector3d& direction) {
  Eigen::Index most = 0;
  const Eigen::Vector3d unit = direction.normalized();
  unit.cwiseAbs().maxCoeff(&most);
  if (std::abs(unit[most]) > 0.98) return std::string(1, "xyz"[most]);
  return fmt::format("({:.2f}, {:.2f}, {:.2f})", unit[0], unit[1], unit[2]);
}

/// @param motion  translation of the centre, then rotation times length
std::string motion_words(const Vector6& motion, const BodyResponse& body) {
  const Eigen::Vector3d shift = motion.head<3>(), turn = motion.tail<3>() / body.length;
  if (motion.tail<3>().norm() < 0.2 * shift.norm()) return "to move along " + direction_words(shift);
  // The point of the axis of rotation next to the centre.
  const Eigen::Vector3d through = 1e3 * (body.centre + turn.cross(shift) / turn.squaredNorm());
  return fmt::format("to turn about {} through ({:.0f}, {:.0f}, {:.0f}) mm", direction_words(turn), through[0] + 0.0,
                     through[1] + 0.0, through[2] + 0.0);
}

/// How much a spring gives with its surroundings: a joint holds no body better than the bodies hold its pads.
double compliance(const Spring& spring, const std::vector<BodyResponse>& responses) {
  double sum = spring.flexibility;
  for (const UnitTerm& a : spring.gap) {
    for (const UnitTerm& b : spring.gap)
      if (a.body == b.body) sum += a.weight * b.weight * responses[a.body].gram(a.unit, b.unit);
  }
  return sum;
}

Eigen::MatrixXd rigid_stiffness(const std::vector<int>& elastic, const std::vector<BodyResponse>& responses,
                                const std::vector<Spring>& springs) {
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(6 * std::ssize(elastic), 6 * std::ssize(elastic));
  for (const Spring& spring : springs) {
    Eigen::VectorXd row = Eigen::VectorXd::Zero(stiffness.rows());
    for (std::size_t i = 0; i < elastic.size(); ++i) {
      for (const UnitTerm& term : spring.gap)
        if (term.body == elastic[i]) row.segment<6>(6 * i) += term.weight * responses[term.body].rigid.col(term.unit);
    }
    const double gives = compliance(spring, responses);
    if (gives > 0.0) stiffness.noalias() += row * row.transpose() / gives;
  }
  return stiffness;
}

}  // namespace

LoosestMotion loosest_motion(const std::vector<int>& elastic, const std::vector<BodyResponse>& responses,
                             const std::vector<Spring>& springs) {
  LoosestMotion found;
  if (elastic.empty()) return found;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(rigid_stiffness(elastic, responses, springs));
  const Eigen::VectorXd& held = eigen.eigenvalues();
  const double usual = held[held.size() / 2];
  found.ratio = usual > 0.0 ? std::max(held[0], 0.0) / usual : 0.0;
  const Eigen::VectorXd mode = eigen.eigenvectors().col(0);
  std::size_t most = 0;
  const auto size_of = [&](std::size_t i) { return mode.segment<6>(6 * i).norm(); };
  for (std::size_t i = 0; i < elastic.size(); ++i)
    if (size_of(i) > size_of(most)) most = i;
  for (std::size_t i = 0; i < elastic.size(); ++i)
    if (size_of(i) >= takes_part * size_of(most)) found.bodies.push_back(elastic[i]);
  const Vector6 motion = mode.segment<6>(6 * most);
  found.motion = motion_words(motion, responses[elastic[most]]);
  found.turns = found.motion.starts_with("to turn");
  const std::set<int> moving(found.bodies.begin(), found.bodies.end());
  std::set<int> joints;
  for (const Spring& spring : springs) {
    for (const UnitTerm& term : spring.gap)
      if (spring.joint >= 0 && moving.contains(term.body)) joints.insert(spring.joint);
  }
  found.joints.assign(joints.begin(), joints.end());
  return found;
}

}  // namespace thermotwin::solver
