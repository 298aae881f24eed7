// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Temperatures of one load as a few modes (linear/field_modes.h) and their coefficients at some of its outputs: small
// enough to lie beside the tables of a load, and all that a page needs to show the machine in 3-D.

#include <Eigen/Core>

#include <vector>

namespace thermotwin::solver {

/// At most this many rows of `count`, evenly spread, the first and the last among them.
std::vector<Eigen::Index> thinned(Eigen::Index count, Eigen::Index most);

struct LoadFields {
  static constexpr Eigen::Index most_times = 72;
  Eigen::MatrixXd modes;         ///< (size x k) orthonormal, K; no columns: no fields are at hand
  Eigen::MatrixXd coefficients;  ///< (k x thinned times)
};

/// @param states  (size x thinned times) K above the reference  @param most_modes  the largest ones are kept
LoadFields compressed(const Eigen::MatrixXd& states, Eigen::Index most_modes);

/// Fields of several loads in common modes. A load without fields has no columns of coefficients.
struct CommonFields {
  Eigen::MatrixXd modes;                      ///< (size x k) orthonormal
  std::vector<Eigen::MatrixXd> coefficients;  ///< of each load, (k x its thinned times)
};
/// @param size  of a state, for loads without fields
CommonFields in_common(const std::vector<const LoadFields*>& loads, Eigen::Index size, Eigen::Index most_modes);

}  // namespace thermotwin::solver
