// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Integrals of the shape functions of one body, exact for straight-edged tetrahedra of order 1 and
// 2 (quadrature of the needed degree). The lumped capacity is the diagonal of the consistent one
// scaled to the element's heat (Hinton, Rock and Zienkiewicz 1976): of each element's heat a
// corner takes 1/4, or in a quadratic one a corner 1/36 and an edge node 4/27; all positive, where
// row sums of quadratic ones are negative at corners. It keeps temperatures from overshooting in
// short steps, but a quadratic mesh then is of second order in transients only.

#include <utility>
#include <vector>

#include "mesh/machine/machine.h"
#include "solver/thermal/element_matrix.h"
#include "solver/thermal/element_rules.h"

namespace thermotwin::solver {

/// (n x n), nodes of the body.
struct BodyHeat {
  SparseMatrix capacity;    ///< J/K
  SparseMatrix conduction;  ///< W/K
};
BodyHeat assemble_heat(const mesh::TetMesh& body, const mesh::Material& material, bool lumped,
                       ElementRules rules = ElementRules::consistent);

/// Integral of N N^T over a triangle of area 1, (3 x 3) or (6 x 6), and of N.
const Eigen::MatrixXd& face_mass(int order, ElementRules rules = ElementRules::consistent);
mesh::FaceValues face_load(int order);

/// Places and weights of a row or column that is mostly zero.
using SparseColumn = std::vector<std::pair<int, double>>;

/// Interpolation at the point of the body that is nearest to p, by nodes of the body.
SparseColumn interpolation_at(const mesh::TetMesh& body, const Eigen::Vector3d& p);

}  // namespace thermotwin::solver
