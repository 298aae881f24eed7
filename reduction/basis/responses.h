// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Candidates of the basis: responses of the full model at parameter points and shifts, in K. A
// column (K(p) + s E)^-1 b q is what an input of size q has made of the temperatures after a time of
// about 1/s, so all columns compare in size. Adjoint columns answer the outputs in the same way.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "solver/elastic/model.h"
#include "solver/operation/operating_model.h"
#include "solver/thermal/system.h"

namespace thermotwin::reduction {

/// A state of operation that stays for a while; the channels' row says what is on.
struct OperatingPoint {
  std::string name;
  Eigen::VectorXd row;     ///< (channels)
  solver::Coefficients c;  ///< its p is what the operator needs
};

/// Standing; the axes at five places of their travel, where their joints' matrices differ, with films and
/// coolants on and off and speeds between; axes that run over their whole travel at half speed.
std::vector<OperatingPoint> operating_points(const solver::OperatingModel& model);

/// Full vectors of what acts at the point, in W: each source at the largest power of its laws (one
/// that moves: spread over the travel and at both ends), each ambient and coolant inlet at 5 K.
Eigen::MatrixXd effective_inputs(const solver::ThermalSystem& thermal, const solver::OperatingModel& model,
                                 const OperatingPoint& point);

/// p_j K_j T of each film, joint and coolant: what a relative change of its coefficient does.
Eigen::MatrixXd coefficient_changes(const solver::ThermalSystem& thermal, const OperatingPoint& point,
                                    const Eigen::VectorXd& temperature);

/// Output functionals as columns (size x m): the TCP rows compressed to their leading directions,
/// lengths in m (rotations at a lever of 0.3 m, R0T as it is).
Eigen::MatrixXd output_directions(const solver::ThermalSystem& thermal, const std::vector<solver::OutputRows>& rows);

/// The same with the sensors: 1 K of a sensor counts as much as 5 um at the TCP. (size x m) in m
Eigen::MatrixXd observed_directions(const solver::ThermalSystem& thermal, const std::vector<solver::OutputRows>& rows);

/// 1/s. Steady state: a very long time instead, so that an insulated machine has one.
inline constexpr double steady_shift = 1.0 / (1000.0 * 86400.0);

struct CandidateOptions {
  std::vector<double> shifts;          ///< 1/s, of the inputs
  std::vector<double> adjoint_shifts;  ///< 1/s, of the outputs
  void validate() const;               ///< @throws InputError
};
/// Inputs: steady state (1000 days), 8 h, 100 min, 20 min and 2 min as 1/s. Outputs: steady state, 8 h and 20 min.
CandidateOptions default_candidates();

/// K0 + sum p K without the coolant's transport, which is not symmetric.
solver::SparseMatrix symmetric_conduction(const solver::ThermalSystem& thermal, const Eigen::VectorXd& p);

/// Takes the capacity-weighted mean from each column: the uniform field is in every basis anyway.
void remove_mean(const solver::ThermalSystem& thermal, Eigen::MatrixXd& block);

/// Columns of each group, (size x columns), without uniform part; W and K as they are.
struct Candidates {
  Eigen::MatrixXd responses;  ///< to inputs, mean over points and shifts
  Eigen::MatrixXd adjoints;   ///< to outputs
  Eigen::MatrixXd changes;    ///< to changes of coefficients
  Eigen::Index columns() const { return responses.cols() + adjoints.cols() + changes.cols(); }
  Eigen::Index made = 0;  ///< columns before they were compressed, point by point
};
Candidates make_candidates(const solver::ThermalSystem& thermal, const solver::OperatingModel& model,
                           const std::vector<solver::OutputRows>& rows, const CandidateOptions& options);

}  // namespace thermotwin::reduction
