// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Steps in readings at unknown times that nothing else goes with: a scale that slips, a tool or wheel that is changed,
// a probe or sensor that is touched. No kind of cause describes them. One channel has the steps, or all displacements
// of one quantity of a record have the same ones.

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <vector>

#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

struct ReadingStep {
  double from_s = 0;         ///< in the time of its record
  double size = 0, std = 0;  ///< in the channel's unit
};

/// The steps that describe a residual best in some channels.
struct ReadingSteps {
  std::vector<std::size_t> channels;  ///< with these steps
  std::vector<ReadingStep> steps;     ///< in the order of time, at most three
  double log_evidence = 0;  ///< ln Bayes factor against no step, a mean over times, sizes and numbers of steps
};

/// A linear problem whose columns have the prior standard deviation 1, and its solution without steps.
struct BesideSteps {
  const Eigen::MatrixXd& columns;  ///< (observations x columns)
  const Eigen::VectorXd& residual;
  const std::vector<ChannelCovariance>& covariance;  ///< (channels) of their fitted part
  const Eigen::LLT<Eigen::MatrixXd>& precision;      ///< of the columns' factors
  const Eigen::VectorXd& mean;                       ///< (columns)
};

/// @param seen    (channels) what there is to explain, RMS in each channel's unit
/// @param levels  prior standard deviations of a step as shares of `seen`
/// @return for each channel, and for all displacements of one quantity of a record where there are several; none for
///   channels of an arrangement, nor where nothing is seen
std::vector<ReadingSteps> find_reading_steps(const Problem& problem, const BesideSteps& beside,
                                             const Eigen::VectorXd& seen, const std::vector<double>& levels);

}  // namespace thermotwin::diagnosis
