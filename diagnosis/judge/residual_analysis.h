// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What residuals say before anyone asks for causes: how large against what is expected, when they are
// largest, how long they remember, and which measured input they follow with which delay.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

/// @param names   of the inputs, (steps x inputs) their values, constant over each step
/// @param points  (steps + 1) s, ends of the steps
struct InputHistory {
  std::vector<std::string> names;
  Eigen::VectorXd points;
  Eigen::MatrixXd values;
};

/// Of one channel. @param time, residual, expected_std  (n), no NaN
ResidualAnalysis analyse(const std::string& id, const Eigen::VectorXd& time, const Eigen::VectorXd& residual,
                         const Eigen::VectorXd& expected_std, const InputHistory& inputs);

/// Of all channels, measured minus predicted without a cause, on the whole record.
std::vector<ResidualAnalysis> analyse(const Problem& problem, const solver::Channels& channels);

/// In words, for channels that are beyond what is expected.
std::vector<std::string> in_words(const std::vector<ResidualAnalysis>& analysis);

}  // namespace thermotwin::diagnosis
