// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Dense factorisations of large matrices by LAPACK and the BLAS, which work on blocks and on all cores
// from a size on (never by --threads, which would change bits). Not to be called on the pool.
// Every function throws SolverError where LAPACK does not converge.

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

/// A V = M V diag(values), V^T M V = 1, values rising; nothing where M is not positive definite.
struct SymmetricPair {
  Eigen::VectorXd values;
  MatrixXd vectors;
};
std::optional<SymmetricPair> symmetric_pair(MatrixXd matrix, MatrixXd metric);

/// M V = V diag(values), V^T V = 1, values rising; M symmetric (its lower triangle counts).
SymmetricPair symmetric_eigen(MatrixXd matrix);

/// F with F F^T = M to within `least` of the largest diagonal entry, by the largest that remains; as many
/// columns as M has that are independent. M symmetric, not negative (its lower triangle counts).
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
/// c := a^T b
void transposed_product(const Eigen::Ref<const MatrixXd>& a, const Eigen::Ref<const MatrixXd>& b,
                        Eigen::Ref<MatrixXd> c);
MatrixXcd product(const MatrixXcd& a, const MatrixXcd& b);

/// Powers of 2 with which diag(1/d) M diag(d) has rows and columns of like size.
Eigen::VectorXd balance(MatrixXd& matrix);

/// One thread a call from now on, for sparse solvers that run side by side on the pool.
void use_one_blas_thread();

}  // namespace thermotwin::reduction::lapack
