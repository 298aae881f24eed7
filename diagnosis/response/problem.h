// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The linear-Gaussian problem of a diagnosis: measured means, the nominal prediction, its sensitivities to candidate
// and nuisance parameters with their priors, and the covariance of noise and discretisation error.

#include <Eigen/Core>

#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "diagnosis/causes/parameter.h"
#include "diagnosis/record/diagnose_options.h"
#include "diagnosis/record/observations.h"
#include "diagnosis/record/several_records.h"
#include "diagnosis/response/response.h"
#include "diagnosis/response/weighted_points.h"
#include "diagnosis/statistics/covariance.h"

namespace thermotwin::diagnosis {

/// What a record leaves open of the machine's state: how warm it began, and what ran before it and in its pauses.
struct OpenState {
  Eigen::MatrixXd columns;  ///< (observations x k)
  Eigen::MatrixXd gain;     ///< (k x fitted) their estimates from white residuals, all else as uncertain as stated
  Whitener whitener;
};

struct Problem {
  Observations observations;
  std::vector<Parameter> parameters;  ///< candidates; the first columns
  Eigen::VectorXd nominal;            ///< (parameters)
  /// (parameters) Point of linearisation minus nominal. It matters because a change of one parameter by a few stated
  /// standard deviations changes the effect of another.
  Eigen::VectorXd around;
  Eigen::VectorXd measured, predicted;  ///< (observations); predicted: at nominal, by the linearisation
  /// (observations x (parameters + start + surroundings + zeros + mesh errors of tests + late changes))
  Eigen::MatrixXd columns;
  Eigen::VectorXd prior_std;  ///< (columns) prior standard deviation of a machine without faults
  /// By index of a parameter whose place is uncertain: errors of its column, (observations x few) per unit of the
  /// parameter, each of one standard deviation.
  std::map<int, Eigen::MatrixXd> place_freedom;
  std::vector<PointTest> tests;  ///< channels whose errors are correlated
  /// Per channel, all its times. Of a test's channels that of the sum in the channel's place, see decorrelated().
  std::vector<ChannelCovariance> covariance;
  Eigen::VectorXd amplitude;  ///< (channels) RMS change from the start, in the channel's unit; of a test's of its sums
  Eigen::VectorXd expected_std;                 ///< (observations) of measured minus predicted without a cause
  std::shared_ptr<const OpenState> open_state;  ///< null: the machine began alike everywhere, and the log has no pause

  /// @param predicted  (observations)
  /// @return the same with the open state as the fitted part tells it; before and after a correction it is another
  Eigen::VectorXd settled(const Eigen::VectorXd& predicted) const;

  /// @return the rows with sums of independent errors in place of a test's channels
  /// @param stacked  (observations x any)
  Eigen::MatrixXd decorrelated(const Eigen::MatrixXd& stacked) const;
  /// @return of the decorrelated rows those that are not held out, channel after channel  @param stacked as above
  Eigen::MatrixXd fitted(const Eigen::MatrixXd& stacked) const;
  std::vector<ChannelCovariance> fitted_covariance() const;
  /// @return the first observation of a channel
  Eigen::Index first_row(std::size_t channel) const;
  /// @return the machine with all parameters at the point of linearisation, except those of `but`
  MachineInTime machine_around(const mesh::Machine& machine, const std::vector<int>& but) const;
  /// @return change of the prediction by these parameters, (observations)
  Eigen::VectorXd moved_around(const std::vector<int>& but) const;
};

/// @param around  (parameters) see Problem; empty: linearised at nominal
/// @param records  those of the observations
Problem make_problem(const mesh::Machine& machine, Records records, Observations observations, const Response& response,
                     const DiagnoseOptions& options, const Eigen::VectorXd& around = {});
inline Problem make_problem(const mesh::Machine& machine, const compensation::Measurement& measurement,
                            Observations observations, const Response& response, const DiagnoseOptions& options,
                            const Eigen::VectorXd& around = {}) {
  return make_problem(machine, Records(&measurement, 1), std::move(observations), response, options, around);
}

/// Adds a cause that was found after the problem was made. @param column  (observations) per unit
void add_parameter(Problem& problem, const Parameter& parameter, const Eigen::VectorXd& column);

}  // namespace thermotwin::diagnosis
