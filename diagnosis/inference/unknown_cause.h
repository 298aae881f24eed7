// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A difference that no kind describes: something that wanders, in one channel, in all of one sort or in all, or steps
// in readings; alone or beside causes. Its size, memory and times are not known: the evidence is a mean over some.

#include <Eigen/Core>

#include <vector>

#include "diagnosis/inference/reading_steps.h"
#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

/// log evidence of the fitted part with the whitening's determinant, without and with something unknown.
struct UnknownEvidence {
  double without = 0;
  double with = 0;  ///< mean over scopes, sizes, memories and times
  /// Where the best scope is a single channel, or steps of one quantity: these channels; else empty.
  std::vector<std::size_t> channels;
  ReadingSteps steps;  ///< where they are the best scope; else without steps
};

/// @param columns, prior_std  of the nuisances and, where a cause stands beside it, of the cause
/// @param residual  (observations) measured less what is predicted where the columns are zero
/// @param seen      (channels) what there is to explain, RMS in each channel's unit
/// @param levels    sizes as shares of `seen`
UnknownEvidence unknown_evidence(const Problem& problem, const Eigen::MatrixXd& columns,
                                 const Eigen::VectorXd& prior_std, const Eigen::VectorXd& residual,
                                 const Eigen::VectorXd& seen, const std::vector<double>& levels);

}  // namespace thermotwin::diagnosis
