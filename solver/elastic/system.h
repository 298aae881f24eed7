// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The small dense system of a pose (see model.h): spring forces and rigid motions. It is symmetric and indefinite.
// Forces and motions are scaled against each other, so that a poor condition number reveals a body that is loose.

#include <Eigen/LU>

#include <functional>
#include <string>

#include "solver/elastic/springs.h"

namespace thermotwin::solver {

/// Response of one body to its unit functionals w (functionals.h); K^+ and R as in model.h.
struct BodyResponse {
  Eigen::MatrixXd gram;                              ///< (units x units) w^T K^+ w'
  Eigen::MatrixXd rigid;                             ///< (6 x units) R^T w
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< m, of the rotations in R
  double length = 1.0;                               ///< m, by which R divides the rotations
};

/// @throws MeshError naming an elastic body that no spring touches
void require_held(const mesh::Machine& machine, const std::vector<int>& elastic, const std::vector<Spring>& springs);

class SmallSystem {
public:
  /// @param elastic    bodies that are elastic, rising
  /// @param responses  per body of the machine; must outlive this object
  /// @throws MeshError naming the bodies that can move freely
  SmallSystem(const mesh::Machine& machine, const std::vector<int>& elastic, const std::vector<BodyResponse>& responses,
              std::vector<Spring> springs);

  const std::vector<Spring>& springs() const { return springs_; }

  /// A message that names the bodies held so weakly that their displacements are unreliable; empty: none.
  std::string hardly_held(const mesh::Machine& machine) const;

  /// Spring forces of the adjoint solution of each output, (springs x outputs).
  Eigen::MatrixXd adjoint_forces(const std::vector<Combination>& outputs) const;

  /// First and second derivative of these forces by ln k, the logarithm of the stiffness of one joint's springs.
  /// @param forces  as adjoint_forces() returns them
  std::pair<Eigen::MatrixXd, Eigen::MatrixXd> stiffness_change(int joint, const Eigen::MatrixXd& forces) const;

  /// Weights of a body's unit functionals in the outputs plus the springs' gaps times `forces`, (units x columns);
  /// outputs may be empty.
  Eigen::MatrixXd unit_weights(int body, const std::vector<Combination>& outputs, const Eigen::MatrixXd& forces) const;

  struct Solution {
    Eigen::VectorXd forces;  ///< (springs) N
    Eigen::VectorXd rigid;   ///< (6 x elastic bodies) m
  };
  /// @param unit_motions  per body (units), w^T K^+ F T
  /// @param temperature   of a node of a body, K above the reference
  Solution solve(const std::vector<Eigen::VectorXd>& unit_motions,
                 const std::function<double(int body, Eigen::Index node)>& temperature) const;

private:
  struct Entry {
    Eigen::Index column;
    int unit;
    double weight;
  };
  std::vector<Entry> entries(std::size_t elastic, const std::vector<Combination>& columns) const;
  void require_regular(const mesh::Machine& machine, const Eigen::MatrixXd& matrix) const;
  Eigen::MatrixXd solve_scaled(const Eigen::MatrixXd& right_hand_side) const;

  const std::vector<int>& elastic_;
  const std::vector<BodyResponse>& responses_;
  std::vector<Spring> springs_;
  std::vector<std::vector<Entry>> gaps_;  ///< per elastic body
  double force_scale_ = 1.0, motion_scale_ = 1.0;
  Eigen::PartialPivLU<Eigen::MatrixXd> factor_;
};

}  // namespace thermotwin::solver
