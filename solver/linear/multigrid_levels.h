// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Levels of algebraic multigrid by smoothed aggregation (PETSc's GAMG), which knows what the
// operator hardly feels: the rigid motions of an elastic body, the uniform temperature of a warm
// one. PETSc brings a hundred shared libraries and MPI with it: it is loaded when the first levels
// are asked for, one caller at a time, and gone from the picture once they are made.

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <vector>

namespace thermotwin::solver {

/// A coarser level.
struct MultigridLevel {
  Eigen::SparseMatrix<double, Eigen::RowMajor> prolongation;  ///< to the next finer level
  Eigen::SparseMatrix<double, Eigen::RowMajor> matrix;        ///< P^T A P of the next finer level
};

/// @param spd  (n x n) compressed, both triangles   @param block  consecutive unknowns per node
/// @param near_null  (n x k) what the operator hardly feels; none: one constant per unknown of a node
/// @return from fine to coarse; the matrix given is not among them
/// @throws SolverError  the module or PETSc failed
std::vector<MultigridLevel> multigrid_levels(const Eigen::SparseMatrix<double>& spd, int block,
                                             const Eigen::MatrixXd& near_null);

}  // namespace thermotwin::solver
