// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Proper orthogonal decomposition of the candidates. The leading directions are taken in the energy
// of the steady and the hourly problem, H = K + E/(2 h): it weighs a hot spot of a small body (a
// spindle) with the heat that it carries, where the capacity alone would see the bed only. The
// basis itself is orthonormal in the capacity, V^T E V = 1, nested (its first columns are the basis
// of a smaller order), and its first column is the uniform field.

#include <Eigen/Core>

#include "solver/thermal/system.h"

namespace thermotwin::reduction {

/// Sum over the columns of their mean square over the capacity, K^2.
double mean_square(const solver::SparseMatrix& capacity, const Eigen::MatrixXd& block);

/// K + E/(2 h), in which directions compare.
solver::SparseMatrix energy_of(const solver::ThermalSystem& thermal, const solver::SparseMatrix& conduction);

inline constexpr double least_direction = 3e-6;  ///< of the longest: what is worth keeping of a block

/// Fewer columns with the same X X^T, but for directions shorter than `least` of the longest: blocks are
/// compressed one by one before they meet (hierarchical decomposition, Himpe, Leibner & Rave 2018).
Eigen::MatrixXd compressed(const solver::SparseMatrix& energy, const Eigen::MatrixXd& x, double least);

struct Basis {
  Eigen::MatrixXd vectors;          ///< (size x order)
  Eigen::VectorXd singular_values;  ///< of the candidates in the energy, falling
  Eigen::Index rank = 0;            ///< independent candidates
};

/// @param candidates  (size x m), without uniform part
/// @param conduction  K at a typical operating point; symmetric
/// @param most        largest number of columns
Basis make_basis(const solver::ThermalSystem& thermal, const solver::SparseMatrix& conduction,
                 const Eigen::MatrixXd& candidates, Eigen::Index most);

/// The vectors, each made orthogonal in E to those before it (twice: enough) and of length 1; what
/// depends on earlier ones is left out.
Eigen::MatrixXd orthonormal(const solver::SparseMatrix& capacity, const Eigen::MatrixXd& vectors);

/// V^T M V for a sparse M; only rows that M has are touched.
/// @param vectors  row-major copy of V
using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
Eigen::MatrixXd project(const solver::SparseMatrix& matrix, const RowMajorMatrix& vectors);
/// Left^T M Right
Eigen::MatrixXd project(const solver::SparseMatrix& matrix, const RowMajorMatrix& left, const RowMajorMatrix& right);

}  // namespace thermotwin::reduction
