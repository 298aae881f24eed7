// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What the reduction methods ask of a stable system E x' = A x + B u, y = C x, whatever its size:
// solutions with s E - A, its response, factors of its Gramians
//   A P E^T + E P A^T + B B^T = 0,  A^T Q E + E^T Q A + C^T C = 0,  P = Zb Zb^T,  Q = Zc Zc^T,
// and its modes. Up to `dense_limit` unknowns a Schur form (symmetric systems: an eigenproblem) gives
// all of them to rounding; beyond, sparse factorisations at one s each.

#include <Eigen/Core>

#include <complex>
#include <memory>
#include <optional>
#include <string>

#include "reduction/systems/linear_system.h"

namespace thermotwin::reduction {

using Complex = std::complex<double>;

struct GramianFactors {
  Eigen::MatrixXd controllability, observability;  ///< Zb, Zc (n x any)
  Eigen::MatrixXd core;                            ///< Zc^T E Zb: its singular values are Hankel's
  bool complete = true;                            ///< all of them, not the leading ones
  int steps = 0;                                   ///< of the low-rank iteration
  double residual = 0;                             ///< relative, of both equations, where low rank
  /// All Hankel singular values, those not computed too, differ from core's by so much in sum, where
  /// that is known (E and -(A + A^T) positive definite).
  std::optional<double> unknown_sum;
};

/// left^T E right = 1 for each; a complex value is followed by its conjugate.
struct Modes {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd right, left;  ///< (n x count)
};

struct Band {
  double low = 1, high = 1;  ///< rad/s; all that happens is between them
};

class SystemSolver {
public:
  virtual ~SystemSolver() = default;
  virtual bool dense() const = 0;
  struct TwoSided {
    Eigen::MatrixXcd right, left;
  };
  /// (s E - A) right = r and (s E - A)^T left = l, by one factorisation. May be called on the pool.
  virtual TwoSided solve(Complex s, const Eigen::MatrixXcd& r, const Eigen::MatrixXcd& l) const = 0;
  /// C (s E - A)^-1 B, without D. May be called on the pool.
  virtual Eigen::MatrixXcd response(Complex s) const = 0;
  virtual GramianFactors gramians() const = 0;
  /// The most dominant modes, |C x| |y^T B| / |Re value|: of all (dense), of the slowest (sparse).
  virtual Modes dominant_modes(Eigen::Index count) const = 0;
  virtual Band band() const = 0;
  /// Frequencies where the response may peak: |Im| of lightly damped poles (sparse: unknown).
  virtual std::vector<double> peaks() const = 0;
  /// Whether stability is proved, or only no unstable eigenvalue was found.
  virtual bool proved_stable() const = 0;
};

struct SolverOptions {
  Eigen::Index dense_limit = 3000;
  double residual = 1e-16;  ///< of the low-rank iteration, relative
  void validate() const;    ///< @throws InputError
};

/// @param place  of the matrices, for messages; the system must outlive the solver
/// @throws InputError: E singular, an eigenvalue of (A, E) with a real part >= 0
std::unique_ptr<SystemSolver> make_system_solver(const StateSpace& system, const std::string& place,
                                                 const SolverOptions& options = {});

[[noreturn]] void refuse_unstable(const std::string& place, Complex value, bool within_rounding);
[[noreturn]] void refuse_singular(const std::string& place, const Sparse& e, double rcond);

/// Indices of the modes by falling dominance, conjugates together, `count` at most (one more where
/// a pair would be parted).
std::vector<Eigen::Index> by_dominance(const Eigen::VectorXcd& values, const Eigen::VectorXd& dominance,
                                       Eigen::Index count);

/// |Im| of poles with a damping ratio below 0.3, the least damped first, at most so many.
std::vector<double> peak_frequencies(const Eigen::VectorXcd& poles, std::size_t most);

}  // namespace thermotwin::reduction
