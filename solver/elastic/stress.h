// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Stress at nodes: the element stress D (eps(u) - alpha T) jumps between elements; its L2 projection
// onto continuous, linear functions of the corners,
//   integral N_i (sum_j N_j s_j - stress) = 0,
// is what is shown and read off. An edge node takes the mean of its ends. A stress that is linear in
// space is met exactly; else the error is of order h with linear and h^2 with quadratic tetrahedra.
// At an edge or point where the exact stress is infinite it grows with refinement.

#include <memory>
#include <vector>

#include "mesh/machine_mesh.h"
#include "solver/elastic/assembly.h"

namespace thermotwin::solver {

class SparseFactor;

/// Recovery on one body; factorises once for many fields.
class StressRecovery {
public:
  /// @param mesh  must outlive this object
  explicit StressRecovery(const mesh::TetMesh& mesh);
  ~StressRecovery();
  StressRecovery(StressRecovery&&) noexcept;

  /// (6 x n) Pa: xx yy zz xy yz zx. @param displacement (3n)  @param temperature (n) K above the reference
  Eigen::MatrixXd nodal(const mesh::Material& material, const Eigen::VectorXd& displacement,
                        const Eigen::VectorXd& temperature) const;

private:
  const mesh::TetMesh& mesh_;
  std::vector<int> corner_;  ///< number among the corners, -1 for edge nodes
  std::unique_ptr<SparseFactor> mass_;
};

/// The same stress in another frame. @param turn  from the old frame to the new one
Vector6 turned(const Vector6& stress, const Eigen::Matrix3d& turn);

/// Von Mises stress of each column, Pa.
Eigen::VectorXd von_mises(const Eigen::MatrixXd& stress);

/// Recovery on all elastic bodies of a machine.
class MachineStress {
public:
  /// @param mesh  must outlive this object
  explicit MachineStress(const mesh::MachineMesh& mesh);

  /// (6 x nodes) Pa in each body's home frame; 0 where a body is not elastic.
  /// @param displacement (3 x nodes) as ElasticModel gives it  @param temperature (size) K above the reference
  Eigen::MatrixXd nodal(const Eigen::Matrix3Xd& displacement, const Eigen::VectorXd& temperature) const;

private:
  const mesh::MachineMesh& mesh_;
  std::vector<std::unique_ptr<StressRecovery>> bodies_;  ///< null where not elastic
};

}  // namespace thermotwin::solver
