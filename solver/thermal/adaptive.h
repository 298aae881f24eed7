// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// One step of TR-BDF2 with an error estimate, for one load. Trapezoidal rule to c h, c = 2 - sqrt 2,
// then BDF2 to h: second order, L-stable, both stages with E / (d h) + K, d = 1 - 1 / sqrt 2. The
// estimate is the difference to a third-order companion, smoothed by one more solve with the same
// matrix, so that stiff parts do not spoil it (Hosea and Shampine 1996). The three values are a
// quadratic in time, second order too: the dense output. Factors are kept by step size and
// coefficients; a step between sizes uses the nearest one as preconditioner until a factor of its
// own would have been cheaper.

#include <array>
#include <memory>

#include "solver/thermal/system.h"

namespace thermotwin::solver {

inline constexpr double tr_bdf2_stage = 0.58578643762690495;  ///< c, place of the inner stage in a step

struct AdaptiveOptions {
  double tolerance = 1e-9;  ///< residual relative to the right-hand side
  int max_iterations = 60;
  double factor_memory = 1e9;     ///< bytes that factors beyond the first may take
  bool single_precision = false;  ///< of the values of factors (SparseFactorOptions); for tolerances above 1e-6
  void validate() const;          ///< @throws InputError
};

class AdaptiveIntegrator {
public:
  /// @param system  must outlive this object
  explicit AdaptiveIntegrator(const ThermalSystem& system, const AdaptiveOptions& options = {});
  ~AdaptiveIntegrator();

  struct Step {
    Eigen::VectorXd stage, end;    ///< temperatures at c h and h
    double error_K = 0;            ///< estimated error of the step, largest at any node; 0 where not wanted
    Eigen::VectorXd mean, q_mean;  ///< of the step's stages, as its heat flows have them, see HeatBalance
  };
  /// Tries a step from start; nothing is kept but factors.
  /// @param p  (terms), constant over the step   @param q  (inputs) at 0, c h and h
  /// @param on_ladder  a step size that will come again: worth a factor at once
  /// @param want_error  else the estimate, one of a step's three solves, is left out
  /// @throws SolverError if the iteration does not converge
  void attempt(const Eigen::VectorXd& start, const Eigen::VectorXd& p, const std::array<Eigen::VectorXd, 3>& q,
               double step_s, bool on_ladder, Step& result, bool want_error = true);

  bool is_nonlinear() const { return system_.local != nullptr; }
  /// As ThermalStepper::linearise.
  void linearise(const Eigen::VectorXd& start, const Eigen::VectorXd& end, const Coefficients& c);

  /// What was local in the last step tried; null: nothing.
  const LocalTerms::Change* local_change() const;

  struct Statistics {
    long solves = 0, factorisations = 0, iterations = 0, most_factors = 0;
  };
  const Statistics& statistics() const { return statistics_; }
  const ThermalSystem& system() const { return system_; }

  void save(core::BinaryWriter& out) const;
  void load(core::BinaryReader& in);

private:
  const ThermalSystem& system_;
  Statistics statistics_;
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace thermotwin::solver
