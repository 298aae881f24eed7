// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Analyses residuals before causes are considered: their size relative to the expected one, the time of their maximum,
// their correlation time, and the measured input that they follow with a delay.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

/// Times the expected RMS, from which on a residual is unexpected.
inline constexpr double unexpected = 1.5;

/// @return the unit of a difference of two readings: K of degC
std::string residual_unit(const std::string& unit);

/// @param names   of the inputs, (steps x inputs) their values, constant over each step
/// @param points  (steps + 1) s, ends of the steps
struct InputHistory {
  std::vector<std::string> names;
  Eigen::VectorXd points;
  Eigen::MatrixXd values;
};

/// Analyses one channel. @param time, residual, expected_std  (n), without NaN
ResidualAnalysis analyse(const std::string& id, const Eigen::VectorXd& time, const Eigen::VectorXd& residual,
                         const Eigen::VectorXd& expected_std, const InputHistory& inputs);

/// Analyses all channels: measured minus predicted without a cause, on the whole record.
std::vector<ResidualAnalysis> analyse(const Problem& problem, const solver::Channels& channels);

/// @return a sentence for each channel whose residual RMS is at least 1.5 times the expected one
std::vector<std::string> in_words(const std::vector<ResidualAnalysis>& analysis);

}  // namespace thermotwin::diagnosis
