// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// How well an observer beside the machine can know the TCP error at all, to which order a reduction is
// worth its states. The prior: the states that the campaign reached, times the share by which
// machine.toml is unsure of heats and films, are what a prediction from known inputs is off by,
//   P = share^2 mean(x x^T);   Q = P - F P F^T,   F = exp(-K interval) of the machine at rest,
// is the disturbance that keeps it so (its negative part, if any, is left out). The sensors with their
// stated uncertainty R then leave the stationary covariance of the Kalman filter's prediction,
//   S = F (S - S H^T (H S H^T + R)^-1 H S) F^T + Q,
// found by doubling (Anderson 1978; Chu, Fan, Lin and Wang 2004), and seen through the TCP's rows.

#include <Eigen/Core>

#include "reduction/model/reduced_model.h"

namespace thermotwin::reduction {

struct ObserverOptions {
  double interval_s = 300.0;    ///< between corrections, as the compensator's
  double unstated_share = 0.1;  ///< where machine.toml states no uncertainty of a source or film
  void validate() const;        ///< @throws InputError
};

/// RMS of the relative standard deviations that machine.toml states of sources and films.
double prior_share(const mesh::Machine& machine, const ObserverOptions& options = {});

struct ObserverNoise {
  double predicted_um =
      0;               ///< standard deviation of the TCP's translation before a correction, RMS over the stored poses
  double open_um = 0;  ///< the same without sensors
};

/// @param states    (order x any) reduced states of the campaign, from each load's start on
/// @param standing  (terms) p of the machine at rest
ObserverNoise observer_noise(const ReducedModel& model, const Eigen::MatrixXd& states, const Eigen::VectorXd& standing,
                             const ObserverOptions& options = {});

/// S of the equation above. @param h  (readings x n)  @param r  (readings) variances
Eigen::MatrixXd stationary_prediction(const Eigen::MatrixXd& f, const Eigen::MatrixXd& q, const Eigen::MatrixXd& h,
                                      const Eigen::VectorXd& r);

}  // namespace thermotwin::reduction
