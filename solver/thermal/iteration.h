// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Solves A_l d_l = r_l for a block of loads l, A_l = shift E + K0 + sum p_j K_j with each load's own p. The method is
// GCR (generalised conjugate residuals; Eisenstat, Elman and Schultz 1983), because the flow of coolants is not
// symmetric. The integrators supply factors as preconditioners, and decide when to make new ones. All loads pass
// through a matrix or factor side by side; a converged load leaves the block. With an exact factor, one iteration
// costs a solve, a product with the matrix and two passes over the vectors.

#include <cmath>
#include <memory>
#include <vector>

#include "solver/thermal/operator.h"
#include "solver/thermal/system.h"

namespace thermotwin::solver {

class ThermalIteration {
public:
  /// @param system  must outlive this object
  explicit ThermalIteration(const ThermalSystem& system);

  /// A factor with the p and the shift it was made for.
  struct Factor {
    BlockSolver solver;
    Eigen::VectorXd p;
    double shift = 0;
    long last_use = 0;
  };

  struct Load {
    Eigen::VectorXd p;  ///< coefficients
    BlockSolver::FluidFactor fluids;
    std::size_t factor = 0;  ///< index of the one that serves as preconditioner
    double threshold = 0;    ///< residual norm that ends the iteration
    int iterations = 0;
    bool changed = false;      ///< the fluid factor is to be made anew
    LocalTerms::Change local;  ///< of the next step; empty: none
  };

  static constexpr double same_shift = 1e-11;  ///< relative difference of equal shifts, for rounded step lengths

  ThermalOperator op;
  std::vector<Load> loads;
  std::vector<std::unique_ptr<Factor>> factors;
  double shift = 0;               ///< present shift, 1/s
  bool single_precision = false;  ///< of the values of factors, see SparseFactorOptions
  /// (size x loads) right-hand sides r, during the iteration the residuals; d; E d
  SideBySide residual, increment, capacity_increment;

  /// (terms x loads) coefficients of all loads.
  SideBySide coefficients() const;
  /// Sets a load's coefficients. @return whether they differ from before
  bool set_coefficients(std::size_t load, const Eigen::VectorXd& p);
  /// Sets the contribution of local terms to a load's step between these states.
  void linearise(std::size_t load, const Eigen::VectorXd& start, const Eigen::VectorXd& end, const Coefficients& c);
  /// E X and K X of all loads, local terms included. (size x loads)
  void multiply(const SideBySide& x, SideBySide& ex, SideBySide& kx) const;
  /// Factorises anew, for (p, shift).
  void factorise(Factor& factor, const Eigen::VectorXd& p, double at_shift) const;
  /// A factor that takes over the analysis of the first one, if there is one; not yet factorised.
  std::unique_ptr<Factor> new_factor() const;
  /// Fluid factors of the loads that changed.
  void update_fluid_factors();

  /// Sets d = 0 and the thresholds.
  /// @param scale  (loads) size of the terms that make up the residuals
  void start(const Eigen::VectorXd& scale, double tolerance);
  /// To be called after start() where d is not zero; the residual has to be that of d.
  void has_guess() { started_ = false; }
  /// Iterates all loads. @return false if a load needs more than limit iterations
  /// @param want_capacity  whether to compute capacity_increment
  bool iterate(int limit, bool want_capacity = true);
  /// Whether a factor was made for this shift, to rounding.
  static bool fits(const Factor& factor, double at_shift) {
    return std::abs(factor.shift / at_shift - 1.0) <= same_shift;
  }
  /// Whether every load's factor is that of its own matrix, and solves with it are direct.
  bool factors_are_exact() const;
  /// d = A^-1 r by exact factors; residuals are not computed.
  void solve_once();
  /// @throws SolverError naming the first load that is not done
  void require_done(int limit) const;

private:
  struct Direction {
    SideBySide z, az;
    Eigen::ArrayXd weight;  ///< 1 / |A z|^2; 0 where nothing is to be gained
  };
  /// The loads that are not done yet, those of one factor side by side.
  struct Working {
    std::vector<std::size_t> load;  ///< of each column
    SideBySide residual, increment, p;
    std::vector<Direction> directions;  ///< the oldest is overwritten
    bool all = false;                   ///< the members' own blocks, lent
  };

  void borrow(const Eigen::VectorXd& norm);
  void give_back();
  /// Drops columns whose residual is small enough. @param norm  (columns of the working block)
  void drop_finished(const Eigen::VectorXd& norm);
  void precondition(SideBySide& z) const;
  /// @return residual norms
  Eigen::VectorXd step(int iteration, bool with_capacity);

  /// To E X and (shift E + K) X what is local to the load of each column (all loads: null).
  void add_local(const std::vector<std::size_t>* load_of, double at_shift, const SideBySide& x, SideBySide* ex,
                 SideBySide* ax) const;

  const LocalTerms* local_;
  Working working_;
  SideBySide ez_;
  bool started_ = false;  ///< d is still zero
};

}  // namespace thermotwin::solver
