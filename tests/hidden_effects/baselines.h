// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What is done where nobody asks for the cause, on the same record as the diagnosis:
//   refit    all powers, films, conductances and coolants at once, regularised least squares by
//            Gauss-Newton, the width of the prior by the last third of the fitted part;
//   process  what the model leaves of each displacement as a Gaussian process of inputs and temperatures
//            (squared exponential), length and noise by marginal likelihood on a coarse grid;
//   sparse   what is left as a sparse sum of inputs behind first-order elements (lasso by coordinate
//            descent), the penalty by the last third of the fitted part.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "expectations.h"

namespace thermotwin::hidden {

/// Functions of time that a correction may be made of, one column each.
struct Library {
  Eigen::VectorXd time;             ///< s
  Eigen::MatrixXd inputs, sensors;  ///< (times x inputs that move, times x sensors)
  /// Values at other times, straight lines in between.
  static Eigen::MatrixXd at(const Eigen::VectorXd& time, const Eigen::MatrixXd& values, const Eigen::VectorXd& when);
};

/// Posterior mean of a Gaussian process with squared exponential covariance. @param x, other  standardised
Eigen::VectorXd gaussian_process(const Eigen::MatrixXd& x, const Eigen::VectorXd& y, const Eigen::MatrixXd& other);

/// Coefficients of min 1/(2 n) |y - x b|^2 + penalty |b|_1, columns of x of unit variance.
Eigen::VectorXd lasso(const Eigen::MatrixXd& x, const Eigen::VectorXd& y, double penalty);

/// Kinds that the refit takes.
inline constexpr diagnosis::Kind refitted_kinds[] = {diagnosis::Kind::source_power, diagnosis::Kind::film_coefficient,
                                                     diagnosis::Kind::contact_conductance,
                                                     diagnosis::Kind::coolant_flow, diagnosis::Kind::coolant_coupling};

struct Corrected {
  std::string method;
  double heldout_um = 0, program_um = 0;  ///< RMS of displacements after it
  std::string kind, where;                ///< of the largest change in stated deviations; empty: none is named
};

/// @param seen, record    what the diagnosis has   @param program, unseen  another program on the same machine
std::vector<Corrected> baselines(const Seen& seen, const compensation::Measurement& record, const Seen& program,
                                 const compensation::Measurement& unseen, const mesh::Machine& machine);

/// RMS of the displacements at some of a record's poses, um; of its held-out part or of all.
struct PoseRange {
  std::size_t first = 1, last = 1000;
};  ///< as channels count them
double displacement_rms(const Seen& seen, const Eigen::VectorXd& predicted, bool heldout, PoseRange poses);

}  // namespace thermotwin::hidden
