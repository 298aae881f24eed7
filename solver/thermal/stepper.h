// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// One step of the temperatures.

#include <Eigen/Core>

#include <vector>

#include "core/binary.h"
#include "solver/operation/operating_model.h"
#include "solver/thermal/local_terms.h"

namespace thermotwin::solver {

/// Advances temperatures by one step; the full and the reduced model each have one.
class ThermalStepper {
public:
  virtual ~ThermalStepper() = default;
  virtual Eigen::Index size() const = 0;
  virtual const Layout& layout() const = 0;
  /// State of uniform temperature, K above the reference (reduced: its projection).
  virtual Eigen::VectorXd uniform(double temperature_K) const = 0;
  /// @param state  (size x loads), overwritten by the state at the end of the step
  /// @param c      (loads) coefficients, constant over the step   @param step_s  > 0
  /// @throws SolverError if the iteration does not converge
  virtual void advance(Eigen::MatrixXd& state, const std::vector<Coefficients>& c, double step_s) = 0;
  /// @return whether matrices depend on the local temperature. If so, linearise() states the expected start and end of
  ///   the next step, and the caller repeats the step until its end agrees
  virtual bool is_nonlinear() const { return false; }
  virtual void linearise(const Eigen::MatrixXd& /*start*/, const Eigen::MatrixXd& /*end*/,
                         const std::vector<Coefficients>&) {}
  /// Temperatures whose heat flows the last step had, (size x loads), see HeatBalance; null: not kept.
  virtual const Eigen::MatrixXd* mean_over_step() const { return nullptr; }
  /// Contribution of a load's local terms to the last step (LocalTerms); null: none.
  virtual const LocalTerms::Change* local_change(std::size_t /*load*/) const { return nullptr; }
  /// (sensors + observed x loads) K above the reference
  virtual Eigen::MatrixXd sensors(const Eigen::MatrixXd& state) const = 0;
  /// Saves, for a checkpoint, the data besides the state that determine the bits of the next steps.
  virtual void save(core::BinaryWriter&) const {}
  virtual void load(core::BinaryReader&) {}
};

}  // namespace thermotwin::solver
