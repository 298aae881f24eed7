// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The full model's thermal stepper.

#include <memory>
#include <vector>

#include "solver/thermal/stepper.h"
#include "solver/thermal/system.h"

namespace thermotwin::solver {

/// Time scheme: two-stage, stiffly accurate, second-order SDIRK (Alexander 1977),
/// gamma = 1 - 1/sqrt(2); L-stable. Both stages share the factorised operator E/(gamma h) + K.
inline constexpr double sdirk_gamma = 0.29289321881345254;

struct IntegratorOptions {
  double tolerance = 1e-9;  ///< residual relative to the right-hand side
  int max_iterations = 60;
  int refactor_above = 8;       ///< iterations worth a new factor while coefficients keep changing
  bool keep_mean = false;       ///< for a HeatBalance
  bool backward_euler = false;  ///< first order instead, for comparison and for virtual machines
  double factor_memory = 1e9;   ///< bytes that factors beyond the first may take
  /// Earlier solutions that a first guess is made of while coefficients stand, of each load; 0: none. For wide blocks
  /// of loads, each with coefficients of its own.
  int recycled = 0;
  void validate() const;  ///< @throws InputError
};

/// One CHOLMOD factor of the mean operator serves all loads and steps while it is close enough;
/// what differs from it (films, contacts, flows of each load) is iterated by GCR, each load with
/// its own coefficients, their solves in one block. Where coefficients stand for long, each set of
/// loads that share them gets a factor of its own, as far as memory allows.
class ThermalIntegrator final : public ThermalStepper {
public:
  explicit ThermalIntegrator(const ThermalSystem& system, const IntegratorOptions& options = {});
  ~ThermalIntegrator() override;

  Eigen::Index size() const override { return system_.size; }
  const Layout& layout() const override { return system_.layout; }
  Eigen::VectorXd uniform(double temperature_K) const override;
  void advance(Eigen::MatrixXd& state, const std::vector<Coefficients>& c, double step_s) override;
  bool is_nonlinear() const override { return system_.local != nullptr; }
  void linearise(const Eigen::MatrixXd& start, const Eigen::MatrixXd& end, const std::vector<Coefficients>& c) override;
  const Eigen::MatrixXd* mean_over_step() const override;
  const LocalTerms::Change* local_change(std::size_t load) const override;
  Eigen::MatrixXd sensors(const Eigen::MatrixXd& state) const override;
  void save(core::BinaryWriter& out) const override;
  void load(core::BinaryReader& in) override;

  struct Statistics {
    long steps = 0, factorisations = 0, iterations = 0;
  };
  const Statistics& statistics() const { return statistics_; }

private:
  const ThermalSystem& system_;
  IntegratorOptions options_;
  Statistics statistics_;
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace thermotwin::solver
