// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A_l d_l = r_l for a block of loads, A_l = shift E + K0 + sum p_j K_j with each load's own p, by GCR
// (generalised conjugate residuals, Eisenstat, Elman and Schultz 1983): the flow of coolants is not
// symmetric. Factors made elsewhere are the preconditioners; loads of one factor are solved as one
// block. Inner tool of the integrators, which decide what factors are worth making.

#include <memory>
#include <vector>

#include "solver/thermal_operator.h"
#include "solver/thermal_system.h"

namespace thermotwin::solver {

class ThermalIteration {
 public:
  /// @param system  must outlive this object
  explicit ThermalIteration(const ThermalSystem& system);

  /// What a factor was made of.
  struct Factor {
    BlockSolver solver;
    Eigen::VectorXd p;
    double shift = 0;
    long last_use = 0;
  };

  struct Direction {
    Eigen::VectorXd z, az, ez;           ///< search direction, A z with norm 1, E z
  };
  struct Load {
    Eigen::VectorXd p, k_values;         ///< coefficients and the matrix they give
    BlockSolver::FluidFactor fluids;
    std::size_t factor = 0;              ///< index of the one that serves as preconditioner
    std::vector<Direction> directions;
    double threshold = 0;                ///< residual norm that ends the iteration
    int iterations = 0;
    bool changed = false;                ///< the fluid factor is to be made anew
    LocalTerms::Change local;            ///< of the next step; empty: none
  };

  ThermalOperator op;
  std::vector<Load> loads;
  std::vector<std::unique_ptr<Factor>> factors;
  double shift = 0;                      ///< of the matrices now
  /// (size x loads): right-hand sides, then what is left of them; d; E d
  Eigen::MatrixXd residual, increment, capacity_increment;

  /// Sets a load's coefficients. @return whether they differ from before
  bool set_coefficients(std::size_t load, const Eigen::VectorXd& p);
  /// Sets what local terms add to a load's step between these states.
  void linearise(std::size_t load, const Eigen::VectorXd& start, const Eigen::VectorXd& end, const Coefficients& c);
  /// E x and K x of a load, with what is local to it. All (size).
  void multiply(std::size_t load, const double* x, double* ex, double* kx) const;
  /// Factorises for (p, shift) in place of what the factor was made of before.
  void factorise(Factor& factor, const Eigen::VectorXd& p, double at_shift) const;
  /// A factor that takes over the analysis of the first one, if there is one; not yet factorised.
  std::unique_ptr<Factor> new_factor() const;
  /// Fluid factors of the loads that changed.
  void update_fluid_factors();

  /// d = 0, thresholds relative to the residuals at hand.
  /// @param scale  (loads) size of the terms that make up the residuals
  void start(const Eigen::VectorXd& scale, double tolerance);
  /// Iterates all loads. @return false if a load needs more than limit iterations
  bool iterate(int limit);
  /// @throws SolverError naming the first load that is not done
  void require_done(int limit) const;

 private:
  void gcr_step(std::size_t load, Eigen::Ref<Eigen::VectorXd> z);
  std::size_t factor_of(Eigen::Index active_column) const;

  const LocalTerms* local_;
  Eigen::MatrixXd packed_, preconditioned_;
  std::vector<std::size_t> active_;
};

}  // namespace thermotwin::solver
