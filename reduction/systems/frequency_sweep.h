// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The H-infinity norm of a system, and of the difference of two, as the largest singular value seen on
// the imaginary axis: a lower bound of the norm. Frequencies are spaced evenly on a logarithmic scale
// over the system's band, with 0, the frequencies of lightly damped poles of both systems, and a
// golden section search around the highest points. Of a large sparse system few frequencies are
// affordable: a reduced model of high order tells where to look, the system itself is asked there.

#include <Eigen/Core>

#include <map>
#include <optional>
#include <vector>

#include "reduction/systems/system_solver.h"

namespace thermotwin::reduction {

struct Peak {
  double value = 0;      ///< largest singular value
  double frequency = 0;  ///< rad/s
};

/// C (i w - A)^-1 B of a reduced system with E = 1, without D.
class ReducedResponse {
public:
  explicit ReducedResponse(const ReducedLinearSystem& system);
  Eigen::MatrixXcd operator()(double frequency) const;
  Eigen::VectorXcd poles() const { return triangular_.diagonal(); }
  bool stable() const { return (poles().real().array() < 0.0).all(); }

private:
  Eigen::MatrixXcd triangular_, b_, c_;
};

class FrequencySweep {
public:
  /// @param solver    must outlive this
  /// @param stand_in  a reduced model of high order for a sparse system, nothing for a dense one
  FrequencySweep(const SystemSolver& solver, const std::optional<ReducedLinearSystem>& stand_in);

  /// Of the system without D.
  Peak norm();
  /// Of the difference. @param reduced  with E = 1
  Peak error(const ReducedResponse& reduced);
  /// Frequencies at which the system itself was asked so far.
  std::size_t samples() const { return known_.size(); }

private:
  template <class Difference>
  Peak largest(std::vector<double> grid, const Difference& difference);
  void ask(const std::vector<double>& frequencies);

  const SystemSolver& solver_;
  std::optional<ReducedResponse> stand_in_;
  std::vector<double> grid_;
  std::map<double, Eigen::MatrixXcd> known_;
};

/// Spectral norm.
double largest_singular_value(const Eigen::MatrixXcd& matrix);

}  // namespace thermotwin::reduction
