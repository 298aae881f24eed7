// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Discrete transfer functions of several inputs on a grid of times,
//   y(k) = c + sum_i B_i(q)/F_i(q) (u_i(k) - r_i),
//   B = b0 + b1 q^-1 + ... + bn q^-n,  F = 1 + f1 q^-1 + ... + fn q^-n,
// with the superposition of Mares et al. (2020), eq. 3, and Mares et al. (2019), eqs. 2 and 3. ARX and ARMAX have one F
// for all inputs, output error one for each. The magnitude of the poles is limited, so that no time constant exceeds a
// limit and the step response of every input settles.

#include <Eigen/Core>

#include <memory>
#include <string>
#include <vector>

#include "compensation/models/channel_model.h"

namespace thermotwin::compensation {

struct TransferSet {
  double step = 0;      ///< s, of the grid
  double constant = 0;  ///< c
  std::vector<InputInfo> info;
  Eigen::VectorXd reference;  ///< (inputs) r
  Eigen::MatrixXd b;          ///< (inputs x n+1)
  Eigen::MatrixXd f;          ///< (inputs x n)

  Eigen::Index order() const { return f.cols(); }
  /// Displacement per unit of the input once all has settled.
  double static_gain(Eigen::Index input) const;
  /// (samples) answer to a unit step of one input at sample 0
  Eigen::VectorXd step_response(Eigen::Index input, Eigen::Index samples) const;
  /// Time until the step response stays within 5 % of its end, s.
  double settling_time(Eigen::Index input) const;
  /// Largest magnitude of the poles of one input.
  double largest_pole(Eigen::Index input) const;
  /// Largest magnitude of any pole.
  double largest_pole() const;
};

/// Roots of z^n + f1 z^(n-1) + ... + fn.
Eigen::VectorXcd poles_of(const Eigen::VectorXd& f);
/// Mirrors poles outside the circle of this radius into it and pulls those on it inside.
/// @return whether anything moved
bool stabilise(Eigen::VectorXd& f, double radius);

/// Inputs and target at t0 + k step, means of the rows since the grid time before.
struct Grid {
  double step = 0;
  Eigen::MatrixXd inputs;  ///< (samples x inputs)
  Eigen::VectorXd target;  ///< (samples) NaN where nothing was measured
};
Grid make_grid(const TrainingData& data, double step);

/// (samples x inputs) contributions of the inputs to the answer, without the constant; starts settled.
Eigen::MatrixXd simulate(const TransferSet& set, const Eigen::MatrixXd& inputs);

/// Row by row at any times; between grid times the last two outputs are carried on.
std::unique_ptr<RowPredictor> make_predictor(const TransferSet& set);

}  // namespace thermotwin::compensation
