// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Cholesky factor of a sparse symmetric positive definite matrix (CHOLMOD, supernodal; nested
// dissection by METIS, AMD for small or dense matrices). The pattern is analysed once, values may
// be factorised again and again. The same bits for any number of threads: the ordering is made
// under a lock (METIS draws from rand()), columns are solved in blocks of fixed width, and BLAS
// works with one thread except for factors whose operation count calls for all cores.

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>

namespace thermotwin::solver {

struct SparseFactorOptions {
  int block = 1;           ///< consecutive unknowns per node; the graph of the nodes is ordered
  int columns_at_once = 32;  ///< right-hand sides per pass through the factor; one task of the pool
  double many_core_flops = 2e11;  ///< operations above which BLAS may use all cores
};

class SparseFactor {
 public:
  using Matrix = Eigen::SparseMatrix<double>;

  /// Analyses and factorises. @param spd  (n x n) compressed; only its lower triangle is read
  /// @throws SolverError: not positive definite (with the unknown), out of memory
  explicit SparseFactor(const Matrix& spd, const SparseFactorOptions& options = {});
  ~SparseFactor();
  SparseFactor(SparseFactor&&) noexcept;
  SparseFactor& operator=(SparseFactor&&) noexcept;

  /// A factor of its own with the same analysis and values.
  SparseFactor clone() const;

  /// New values on the same pattern; not while another thread solves.
  void factorise(const Matrix& spd);

  /// A X = B; (n x m). May be called from several threads at once. @throws SolverError (memory)
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right_hand_sides) const;
  void solve(const Eigen::Ref<const Eigen::MatrixXd>& right_hand_sides, Eigen::Ref<Eigen::MatrixXd> solution) const;

  Eigen::Index size() const;
  double memory_bytes() const;       ///< of the factor
  double flops() const;              ///< of one factorisation
  double nonzeros() const;           ///< of the factor
  /// Rough reciprocal condition number (smallest / largest pivot, squared); 0 is singular.
  double rcond() const;

 private:
  struct Impl;
  explicit SparseFactor(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace thermotwin::solver
