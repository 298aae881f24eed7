// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Matrices of the affine equation on the full mesh. Unknowns: nodes of all bodies (numbered as
// MachineMesh::first_node says), then those of coolants and volumes (fluid_assembly.h). Tetrahedra of the mesh's order,
// consistent or lumped capacity (elements.h). Contacts are integrated over the pieces into which the master's triangles
// cut the slave's, at each grid node of the joint (contact.h). Coolant flow is upwind: its matrix G is not symmetric,
// and G + G^T is non-negative. All others are symmetric and non-negative.

#include <Eigen/SparseCore>

#include <memory>
#include <vector>

#include "core/binary.h"
#include "mesh/machine_mesh.h"
#include "solver/linear/linear_solver.h"
#include "solver/operation/layout.h"
#include "solver/operation/operating_model.h"
#include "solver/thermal/element_matrix.h"
#include "solver/thermal/local_terms.h"

namespace thermotwin::solver {

struct ThermalSystem {
  Layout layout;
  Eigen::Index nodes = 0;                      ///< of the bodies
  Eigen::Index size = 0;                       ///< nodes + fluid nodes
  SparseMatrix capacity, conduction;           ///< E in J/K, K0 in W/K
  std::vector<SparseMatrix> terms;             ///< K_j for p_j = 1
  SparseMatrix inputs;                         ///< (size x inputs) s_k for q_k = 1
  std::shared_ptr<const LocalTerms> local;     ///< terms that follow the temperature at each place; null: none
  SparseMatrix sensors;                        ///< (sensors + layout.observed x size) rows of their temperatures
  LinearSolver solver = LinearSolver::direct;  ///< of the block of the bodies' nodes, in every solve
};

/// Steady state of (K0 + sum p K) T = S q for one set of coefficients; (size).
Eigen::VectorXd solve_steady(const ThermalSystem& system, const Coefficients& c);

/// Solves (shift E + K0 + sum p K) X = B, shift in 1/s >= 0; X, B (size x m). Factorises once for
/// all columns; transpose for adjoints (coolant flow is not symmetric).
Eigen::MatrixXd solve_shifted(const ThermalSystem& system, const Coefficients& c, double shift,
                              const Eigen::MatrixXd& right_hand_side, bool transpose = false);

}  // namespace thermotwin::solver
