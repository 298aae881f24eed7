// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Cholesky factor of a sparse symmetric positive definite matrix (CHOLMOD, supernodal; nested
// dissection by METIS, AMD for small or dense matrices). The pattern is analysed once, values may
// be factorised again and again. The same bits for any number of threads: the ordering is made
// under a lock (METIS draws from rand()), columns are solved in blocks of fixed width by sweeps of our
// own that share a factor among threads (supernodal_sweeps.h), and BLAS works with one thread except
// for factors whose operation count calls for all cores. Factors that overflow 32-bit indices (16 GB)
// are made with 64-bit ones.

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include <memory>
#include <vector>

#include "solver/linear/side_by_side.h"

namespace thermotwin::solver {

/// The ordering and what it will cost, before any memory is asked for.
struct SparseAnalysis {
  std::vector<int> order;   ///< fill-reducing permutation of the unknowns
  double factor_bytes = 0;  ///< of the factor, as SparseFactor::memory_bytes() will say
  double work_bytes = 0;    ///< beside it while it is made
  double nonzeros = 0, flops = 0;
  bool wide = false;  ///< needs 64-bit indices
};

struct SparseFactorOptions {
  int block = 1;                  ///< consecutive unknowns per node; the graph of the nodes is ordered
  int columns_at_once = 48;       ///< right-hand sides per pass through the factor (at most 64)
  double many_core_flops = 2e11;  ///< operations above which BLAS may use all cores
  bool force_wide = false;        ///< 64-bit indices even where 32 bits do
  /// Values rounded to single precision once they are made, sums in double: half the memory and a
  /// shorter solve, good to about 1e-6 of the right-hand side. For iterations that look at what is
  /// left; no half_solve().
  bool single_precision = false;
  void validate() const;  ///< @throws InputError
};

class SparseFactor {
public:
  using Matrix = Eigen::SparseMatrix<double>;

  /// Analyses and factorises. @param spd  (n x n) compressed; only its lower triangle is read
  /// @throws SolverError: not positive definite (with the unknown), out of memory
  explicit SparseFactor(const Matrix& spd, const SparseFactorOptions& options = {});
  /// With an analysis made before, of the same pattern and options.
  SparseFactor(const Matrix& spd, const SparseFactorOptions& options, const SparseAnalysis& analysis);
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

  /// W B with W W^T = A^-1, for norms: |W^T r|^2 = r^T A^-1 r. The backward sweep alone. (n x m)
  Eigen::MatrixXd half_solve(const Eigen::MatrixXd& b) const;

  /// solve() for right-hand sides that lie side by side, a row of them for each unknown.
  void solve_side_by_side(const Eigen::Ref<const SideBySide>& right_hand_sides, Eigen::Ref<SideBySide> solution) const;

  Eigen::Index size() const;
  double memory_bytes() const;  ///< of the factor
  bool wide() const;            ///< 64-bit indices
  double flops() const;         ///< of one factorisation
  double nonzeros() const;      ///< of the factor
  /// Rough reciprocal condition number (smallest / largest pivot, squared); 0 is singular.
  double rcond() const;

private:
  struct Impl;
  explicit SparseFactor(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Orders the unknowns and counts. Values do not matter. @throws SolverError (memory)
SparseAnalysis analyse(const SparseFactor::Matrix& spd, const SparseFactorOptions& options = {});

}  // namespace thermotwin::solver
