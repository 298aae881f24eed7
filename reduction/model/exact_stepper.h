// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Steps without time error while the coefficients are constant: for x' = -A x + f with A and f constant over h,
//   x(t + h) = x + D(h) x + h P(h) f,   D(h) = exp(-h A) - 1,   P(h) = phi_1(-h A),
// The result does not depend on the division of an interval, except for rounding (1e-10 of the state). D and P are made
// once for a set of coefficients, at h/2^k by their Taylor series and from there by doubling,
//   D(2h) = 2 D + D^2,   P(2h) = P + D P / 2.
// D is kept without the identity, so slow modes lose no digits. The powers of two form a ladder that serves all
// intervals: its rungs for the binary digits, the series for the remainder. Coolant transport is allowed, although its
// matrix is not symmetric and may have no basis of eigenvectors. Coefficients that have just changed are stepped by
// SDIRK2 (second order), and get a ladder once they stay constant or return. Moler and Van Loan (2003), methods 1 and
// 3, describe series and doubling.

#include <memory>

#include "reduction/model/reduced_model.h"
#include "solver/operation/layout.h"
#include "solver/thermal/stepper.h"

namespace thermotwin::reduction {

struct ExactOptions {
  bool from_first = false;  ///< make a ladder for new coefficients at once, for loads whose coefficients seldom change
  StepperOptions passing;   ///< of the SDIRK2 steps
  void validate() const { passing.validate(); }
};

class ExactStepper final : public solver::ThermalStepper {
public:
  /// @param system  must outlive this object
  explicit ExactStepper(const ReducedSystem& system, const ExactOptions& options = {});
  ~ExactStepper() override;
  ExactStepper(ExactStepper&&) noexcept;

  Eigen::Index size() const override;
  const solver::Layout& layout() const override;
  Eigen::VectorXd uniform(double temperature_K) const override;
  void advance(Eigen::MatrixXd& state, const std::vector<solver::Coefficients>& c, double step_s) override;
  /// Does not allocate if a ladder exists. @throws SolverError if the state is no longer finite
  void advance(Eigen::VectorXd& state, const solver::Coefficients& c, double step_s);
  Eigen::MatrixXd sensors(const Eigen::MatrixXd& state) const override;

  struct Statistics {
    long exact = 0, passed = 0, ladders = 0;
  };
  const Statistics& statistics() const;

private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace thermotwin::reduction
