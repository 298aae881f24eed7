// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// CHOLMOD behind a face of our own, for sparse_factor.cpp: orderings, and supernodal factors with 32-
// or 64-bit indices. The only place that sees the library is cholmod_factor.cpp.

#include <memory>
#include <vector>

#include "solver/linear/sparse_factor.h"
#include "solver/linear/supernodal_sweeps.h"

namespace thermotwin::solver::cholmod {

/// Places of the unknowns, consecutive ones of a block together; METIS, or AMD for a small graph.
/// @throws SolverError: the unknowns are no multiple of the block
std::vector<int> fill_reducing_order(const SparseFactor::Matrix& matrix, int block);

/// A factor with the functions that go with its indices.
class Factor {
public:
  virtual ~Factor() = default;
  virtual void factorise(const SparseFactor::Matrix& spd, double many_core_flops) = 0;
  virtual std::unique_ptr<Factor> copy() const = 0;
  virtual bool wide() const = 0;
  virtual double memory_bytes() const = 0;
  /// Column-major by supernodes, as SupernodalPattern says.
  virtual const double* values() const = 0;
  /// Frees them; the analysis is kept for the next factorise().
  virtual void drop_values() = 0;
  virtual SupernodalPattern pattern() const = 0;
  /// Place of each row of the factor in the matrix.
  virtual std::vector<int> permutation() const = 0;
  double rcond = 0, flops = 0, nonzeros = 0;
};

/// Without values. @param work  receives the working memory that values will take, if given
/// @throws SolverError (memory)
std::unique_ptr<Factor> analysed(const SparseFactor::Matrix& spd, const std::vector<int>& order, bool wide,
                                 double* work = nullptr);

}  // namespace thermotwin::solver::cholmod
