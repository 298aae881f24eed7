// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A difference that no kind describes: something that wanders, in one channel, in all of one quantity or
// in all, alone or beside causes. Its size and its memory are not known: the evidence is a mean over some.

#include <Eigen/Core>

#include <vector>

#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

/// log evidence of the fitted part with the whitening's determinant, without and with something unknown.
struct UnknownEvidence {
  double without = 0;
  double with = 0;   ///< mean over scopes, sizes and memories
  int channel = -1;  ///< where a single channel's is the best scope; -1: several channels'
};

/// @param columns, prior_std  of the nuisances and, where a cause stands beside it, of the cause
/// @param residual  (observations) measured less what is predicted where the columns are zero
/// @param seen      (channels) what there is to explain, RMS in each channel's unit
/// @param levels    sizes as shares of `seen`
UnknownEvidence unknown_evidence(const Problem& problem, const Eigen::MatrixXd& columns,
                                 const Eigen::VectorXd& prior_std, const Eigen::VectorXd& residual,
                                 const Eigen::VectorXd& seen, const std::vector<double>& levels);

}  // namespace thermotwin::diagnosis
