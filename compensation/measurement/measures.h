// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Measures of a prediction against a measurement z, with the residual e = z - prediction (Okenka et al., eqs. 2 and 3;
// the paper exchanges the hat and the bar of eq. 2). Pairs with a NaN are left out.

#include <Eigen/Core>

namespace thermotwin::compensation {

struct Measures {
  double fit = 0;                         ///< %, (1 - |e| / |z - mean z|) 100 with Euclidean norms
  double peak_to_peak = 0;                ///< PK: max e - min e
  double rms = 0, maximum = 0, mean = 0;  ///< of the residual; maximum of |e|
  double rms_before = 0, peak_to_peak_before = 0, maximum_before = 0, mean_before = 0;  ///< of z itself
  double rms_reduction_percent = 0, peak_to_peak_reduction_percent = 0;
  Eigen::Index count = 0;
};

/// @param measured z  @param predicted  same length and unit
Measures measure(const Eigen::VectorXd& measured, const Eigen::VectorXd& predicted);

}  // namespace thermotwin::compensation
