// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// One diagnosis as numbers: measured means, the nominal prediction with its sensitivities, what is
// uncertain without being a cause (nuisances), and what noise and mesh explain.

#include <Eigen/Core>

#include <map>
#include <vector>

#include "diagnosis/causes/parameter.h"
#include "diagnosis/record/diagnose_options.h"
#include "diagnosis/record/observations.h"
#include "diagnosis/response/response.h"
#include "diagnosis/statistics/covariance.h"

namespace thermotwin::diagnosis {

struct Problem {
  Observations observations;
  std::vector<Parameter> parameters;  ///< candidates; the first columns
  Eigen::VectorXd nominal;            ///< (parameters)
  /// (first parameters) Where they are linearised, less nominal. Few deviations of the stated uncertainty already
  /// change how fast and how far another parameter acts.
  Eigen::VectorXd around;
  Eigen::VectorXd measured, predicted;  ///< (observations) with all parameters at nominal, on the linear form
  Eigen::MatrixXd columns;              ///< (observations x (parameters + start + surroundings + zeros + late changes))
  Eigen::VectorXd prior_std;            ///< (columns) nominal
  /// Of parameters whose place is not known for sure: what their column may be off by, (observations x few), per unit;
  /// one standard deviation each.
  std::map<int, Eigen::MatrixXd> place_freedom;
  std::vector<ChannelCovariance> covariance;  ///< per channel, all its times
  Eigen::VectorXd amplitude;                  ///< (channels) how far a channel moves, its unit
  Eigen::VectorXd expected_std;               ///< (observations) of measured minus predicted, no cause

  /// The rows that are fitted, channel after channel.
  Eigen::MatrixXd fitted(const Eigen::MatrixXd& stacked) const;
  std::vector<ChannelCovariance> fitted_covariance() const;
  Eigen::Index first_row(std::size_t channel) const;
  /// A machine with all parameters but these where the problem is linearised, and what that moves. (observations)
  mesh::Machine machine_around(const mesh::Machine& machine, const std::vector<int>& but) const;
  Eigen::VectorXd moved_around(const std::vector<int>& but) const;
};

/// @param around  (parameters) see Problem; empty: linearised at nominal
Problem make_problem(const mesh::Machine& machine, const compensation::Measurement& measurement,
                     Observations observations, const Response& response, const DiagnoseOptions& options,
                     const Eigen::VectorXd& around = {});

}  // namespace thermotwin::diagnosis
