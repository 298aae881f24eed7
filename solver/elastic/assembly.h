// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// One elastic body in its own frame: tetrahedra of the mesh's order, isotropic Hooke's law, no body
// forces.
//   K u = F T - S f,   F from the initial stress E alpha / (1 - 2 nu) T, with T as the thermal
// elements have it (linear or quadratic), integrated exactly like K. K is singular by the six rigid
// motions R; six degrees of freedom of three nodes far apart (3-2-1, statically determinate) are
// fixed, so that K^+ is one Cholesky solve: for a load in equilibrium it gives the displacement up to
// a rigid motion, and in the machine's system the loads of a body always are. F T is in equilibrium by itself.

#include <Eigen/Core>

#include <array>

#include "mesh/body/tet_mesh.h"
#include "mesh/machine/machine.h"
#include "solver/thermal/element_matrix.h"

namespace thermotwin::solver {

/// Degrees of freedom: 3 * node + direction.
struct ElasticBody {
  SparseMatrix stiffness;     ///< (3n x 3n) N/m; fixed rows and columns replaced by the unit
                              ///< matrix times a typical stiffness: positive definite
  SparseMatrix thermal_load;  ///< (3n x n) F in N/K
  std::array<Eigen::Index, 6> fixed;
  Eigen::Vector3d centre;  ///< m, of volume
  double length = 1.0;     ///< m, makes rotations as large as translations
  Eigen::MatrixXd rigid;   ///< (3n x 6) translations, then rotations about centre / length
};

/// @throws MeshError if the body has no three nodes that hold it (needs a volume)
ElasticBody assemble_elastic(const mesh::TetMesh& mesh, const mesh::Material& material, const std::string& body);

/// The matrices by themselves: K without supports (3n x 3n), and F (3n x n).
SparseMatrix elastic_stiffness(const mesh::TetMesh& mesh, const mesh::Material& material);
SparseMatrix thermal_load(const mesh::TetMesh& mesh, const mesh::Material& material);

/// Right-hand sides with the fixed degrees of freedom set to 0, as K^+ wants them.
void clear_fixed(const ElasticBody& body, Eigen::MatrixXd& loads);

/// Stress in an element, Pa: xx yy zz xy yz zx. @param displacement (3n)  @param temperature (n) K above the
/// reference  @param at  barycentric coordinates
using Vector6 = Eigen::Matrix<double, 6, 1>;
Vector6 stress_at(const mesh::TetMesh& mesh, const mesh::Material& material, const Eigen::VectorXd& displacement,
                  const Eigen::VectorXd& temperature, Eigen::Index element, const Eigen::Vector4d& at);

}  // namespace thermotwin::solver
