// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// L U = s E - A for sparse matrices and one s after the other (UMFPACK): the pattern of both is
// analysed once, real s are factorised in real arithmetic. The same bits for any number of threads.

#include <Eigen/Core>

#include <complex>
#include <memory>

#include "reduction/systems/linear_system.h"

namespace thermotwin::reduction {

class PencilLu {
public:
  PencilLu(const Sparse& e, const Sparse& a);
  ~PencilLu();

  class Factor {
  public:
    explicit Factor(std::complex<double> s);
    ~Factor();
    Factor(Factor&&) noexcept;

    /// Columns are shared among the threads of the pool. With a real s the real and the imaginary
    /// part are solved for. @param transposed  (s E - A)^T, not conjugated
    Eigen::MatrixXcd solve(const Eigen::MatrixXcd& right_hand_sides, bool transposed) const;
    /// Only for a real s.
    Eigen::MatrixXd solve(const Eigen::MatrixXd& right_hand_sides, bool transposed) const;
    /// Rough reciprocal condition (smallest over largest pivot, rows scaled); 0 is singular.
    double rcond() const;

  private:
    friend class PencilLu;
    struct Impl;
    std::unique_ptr<Impl> impl_;
  };

  /// May be called from several threads at once; the pencil must outlive the factor.
  /// A singular matrix gives rcond() 0 and must not be solved with. @throws SolverError (memory)
  Factor factorise(std::complex<double> s) const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace thermotwin::reduction
