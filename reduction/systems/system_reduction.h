// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reduction of a system of another program (linear_system.h) by one of three methods: balanced
// truncation (square root form, from the Gramians' factors; |G - Gr| <= 2 sum of the Hankel singular
// values left out, K. Glover 1984), truncation to the most dominant modes, and rational Krylov
// bases. With parameter matrices A_film_j, bases are made at each point p, and joined.

#include <map>
#include <string>
#include <vector>

#include "reduction/systems/frequency_sweep.h"
#include "reduction/systems/linear_system.h"
#include "reduction/systems/system_solver.h"

namespace thermotwin::reduction {

enum class Method { balanced, modal, krylov };
/// @throws UsageError with the known names
Method method_of(const std::string& word);
const char* word(Method method);

struct SystemReductionOptions {
  Method method = Method::balanced;
  Eigen::Index order = 0;                   ///< per point; 0: the smallest whose bound keeps the tolerance
  double tolerance = 1e-3;                  ///< of balanced truncation's bound
  bool absolute = false;                    ///< the tolerance is a norm, not relative to the H-infinity norm
  bool compare = false;                     ///< errors of all methods at several orders
  std::vector<std::vector<double>> points;  ///< values of all films, one or more; empty: all 1
  SolverOptions solver;
  void validate() const;  ///< @throws InputError
  /// The order and the points too. @throws InputError
  void validate_for(const LinearSystem& system) const;
};

/// What is known at one set of the films' values.
struct PointResult {
  std::vector<double> films;
  Eigen::VectorXd hankel;             ///< Hankel singular values, falling
  bool complete = true;               ///< all of them
  std::optional<double> unknown_sum;  ///< see GramianFactors
  int gramian_steps = 0;
  double gramian_residual = 0;
  Eigen::Index order = 0;  ///< of this point's own basis
  double bound = 0;        ///< 2 sum hankel beyond `order`
  Peak norm, error;        ///< of the system without D; of the difference, in the model given back
  bool stable = false, proved_stable = true, dense = true;
  std::size_t samples = 0;  ///< frequencies at which the system was asked
  Eigen::VectorXcd poles;   ///< of the reduced model
};

struct Comparison {
  Method method;
  Eigen::Index order = 0;  ///< reached
  double error = 0;        ///< sampled H-infinity norm of the difference
  bool stable = false;
};

struct SystemReduction {
  ReducedLinearSystem model;  ///< E = 1
  std::vector<PointResult> points;
  std::vector<Comparison> comparison;  ///< at the first point
  Method method = Method::balanced;
  bool joined = false;    ///< of several points: the bounds are those of the points' own models
  bool converged = true;  ///< the Krylov iteration's shifts stay
  bool stable() const;
};

/// @throws InputError (make_system_solver), SolverError: the Gramians do not converge, the reduced
///         model is not stable
SystemReduction reduce_system(const LinearSystem& system, const SystemReductionOptions& options);

/// Smallest order with 2 sum of what is left out <= allowed, never between equal values.
Eigen::Index order_for(const Eigen::VectorXd& hankel, double allowed);
double bound_of(const Eigen::VectorXd& hankel, Eigen::Index order);

}  // namespace thermotwin::reduction
