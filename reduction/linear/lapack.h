// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Dense factorisations of large matrices by LAPACK and the BLAS. Matrices of 1500 rows and more use all cores, smaller
// ones one core; products go by the geometric mean of their three extents. --threads has no influence, so that results
// do not depend on it. Not to be called on the thread pool.
// @throws SolverError if LAPACK does not converge

#include <Eigen/Core>

#include <complex>
#include <optional>

namespace thermotwin::reduction::lapack {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;

/// M = vectors T vectors^H with T upper triangular, through the real Schur form of M.
struct Schur {
  MatrixXcd triangular, vectors;
};
Schur schur(MatrixXd matrix);

/// A V = M V diag(values), V^T M V = 1, values rising. @return nothing if the metric M is not positive definite
struct SymmetricPair {
  Eigen::VectorXd values;
  MatrixXd vectors;
};
std::optional<SymmetricPair> symmetric_pair(MatrixXd matrix, MatrixXd metric);

/// M V = V diag(values), V^T V = 1, values rising. M is symmetric; only its lower triangle is read.
SymmetricPair symmetric_eigen(MatrixXd matrix);

/// The largest eigenvalue of a Hermitian matrix; only its lower triangle is read. For small matrices: one core, also on
/// the thread pool.
double largest_eigenvalue(MatrixXcd matrix);

/// @return F (n x rank) with F F^T = M. Pivoting ends when the largest remaining diagonal entry is below `least` times
/// the largest one of M. M is symmetric and positive semidefinite; only its lower triangle is read.
MatrixXd pivoted_cholesky(MatrixXd matrix, double least);

/// M = U diag(values) V^T, thin.
struct Svd {
  MatrixXd left, right;
  Eigen::VectorXd values;
};
Svd svd(MatrixXd matrix);

/// The upper triangle R of M = Q R; rows >= columns.
MatrixXd triangle_of_qr(MatrixXd matrix);

MatrixXd product(const MatrixXd& a, const MatrixXd& b);
/// c -= a b
void subtract_product(const Eigen::Ref<const MatrixXd>& a, const MatrixXd& b, MatrixXd& c);
/// c := a^T b
void transposed_product(const Eigen::Ref<const MatrixXd>& a, const Eigen::Ref<const MatrixXd>& b,
                        Eigen::Ref<MatrixXd> c);
MatrixXcd product(const MatrixXcd& a, const MatrixXcd& b);

/// Balances the matrix: replaces M by diag(1/d) M diag(d), whose rows and columns have similar norms.
/// @return d, powers of 2
Eigen::VectorXd balance(MatrixXd& matrix);

/// From now on each call of the BLAS uses one thread, for sparse solvers that run side by side on the thread pool.
void use_one_blas_thread();

}  // namespace thermotwin::reduction::lapack
