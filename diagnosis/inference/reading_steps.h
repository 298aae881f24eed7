// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Steps in readings at unknown times, without a change of the inputs: a scale slips, a tool or wheel is changed, a
// probe or sensor is touched. A fixture, a tool or a probe that was clamped before the record creeps instead: a single
// step begins with the record and comes with a time constant. No kind of cause describes them. A single channel has the
// steps, or all displacements of one quantity in a record by the same size, or all displacements of a record.

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <string>
#include <vector>

#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

struct ReadingStep {
  double from_s = 0;         ///< in the time of its record
  double size = 0, std = 0;  ///< in the channel's unit
  double memory_s = 0;       ///< time constant with which it comes; 0: at once
};

/// The steps that describe the residual of some channels best.
struct ReadingSteps {
  std::vector<std::size_t> channels;  ///< channels that have these steps
  std::vector<ReadingStep> steps;     ///< in the order of time, at most three
  /// Where all displacements of a record have them, each quantity by its own size: the quantity whose sizes these are,
  /// which moves most. Else empty.
  std::string quantity;
  /// ln Bayes factor against no step, a mean over times, sizes, numbers of steps and time constants
  double log_evidence = 0;
};

/// A linear problem whose columns have the prior standard deviation 1, and its solution without steps.
struct BesideSteps {
  const Eigen::MatrixXd& columns;  ///< (observations x columns)
  const Eigen::VectorXd& residual;
  const std::vector<ChannelCovariance>& covariance;  ///< (channels) of their fitted part
  const Eigen::LLT<Eigen::MatrixXd>& precision;      ///< of the columns' factors
  const Eigen::VectorXd& mean;                       ///< (columns)
};

/// @param seen    (channels) RMS of the difference to be explained, in each channel's unit
/// @param levels  prior standard deviations of a step as shares of `seen`
/// @return for each channel, for all displacements of one quantity of a record where there are several, and for all
///   displacements of a record with a size for each quantity; none for channels of an arrangement, nor where nothing is
///   seen
std::vector<ReadingSteps> find_reading_steps(const Problem& problem, const BesideSteps& beside,
                                             const Eigen::VectorXd& seen, const std::vector<double>& levels);

}  // namespace thermotwin::diagnosis
