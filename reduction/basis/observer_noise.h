// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Uncertainty of the TCP error that remains with an observer on the machine. A reduction error far below it does not
// improve the offsets, so it limits the useful order. The prior error of a prediction from known inputs is the states x
// that the campaign reached times a share, the uncertainty of sources and films in machine.toml:
//   P = share^2 mean(x x^T).
// The process noise that makes P stationary is (its negative part, if any, is left out)
//   Q = P - F P F^T,   F = exp(-K interval) of the machine at rest.
// With sensors of the stated uncertainty R the stationary covariance of the Kalman filter's prediction is
//   S = F (S - S H^T (H S H^T + R)^-1 H S) F^T + Q,
// computed by doubling (Anderson 1978; Chu, Fan, Lin and Wang 2004). The rows of the TCP error convert S to um.

#include <Eigen/Core>

#include "reduction/model/reduced_model.h"

namespace thermotwin::reduction {

struct ObserverOptions {
  double interval_s = 300.0;    ///< between corrections, as in the compensator
  double unstated_share = 0.1;  ///< share if machine.toml states no uncertainty of any source or film
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
