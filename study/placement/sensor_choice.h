// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Chooses sensors by the variance that a Kalman filter in the uncertain parameters leaves of the TCP error.
//
// Parameters theta (in standard deviations) return to their prior with their memory: theta' = a theta + w, a =
// exp(-dt / memory), Var w = 1 - a^2. A sensor at place i reads h_i(t)^T theta + b_i + noise with a constant bias b_i.
// The TCP's variance is tr(M(t) P(t)), M the mean over the poses of the squared translations per parameter. The
// criterion is the root of its mean over all times and load programs, in um.
//
// A place that is best alone may be useless beside two others: three more are taken and the least valuable leave.
// Greedy: the place that lowers the criterion most joins, one after another. Exchange: each sensor is replaced by the
// place that lowers the criterion most, until no replacement does (Fedorov 1972).

#include <Eigen/Core>

#include <vector>

#include "study/placement/responses.h"

namespace thermotwin::study {

struct ChoiceOptions {
  double noise_K = 0.05;        ///< standard deviation of a reading, mean of the interval between two times
  double bias_K = 0.1;          ///< of a sensor's constant bias: its calibration and the mesh's error beside it
  int exchanges = 3;            ///< passes over the sensors at most; 0: greedy alone
  bool any_loss = false;        ///< exchange for the criterion after the loss of the worst sensor
  Eigen::Index choosable = -1;  ///< only the first places may be chosen; -1: all
  void validate() const;        ///< @throws InputError
};

class SensorChoice {
public:
  /// @param places  (places x order) temperature of each place per state
  /// @param tcp     (3 poses x order) translations per state, um/K
  SensorChoice(const std::vector<LoadResponses>& loads, const std::vector<UncertainParameter>& parameters,
               const Eigen::MatrixXd& places, const Eigen::MatrixXd& tcp, const ChoiceOptions& options);

  /// The criterion of these places, um.
  double left_um(const std::vector<int>& sensors) const;
  /// The same after the loss of the sensor without which it is largest; of one sensor: without sensors.
  double left_after_loss_um(const std::vector<int>& sensors) const;

  /// @param count  of sensors  @param taken  places to begin with, which stay
  std::vector<int> greedy(int count, const std::vector<int>& taken = {}) const;
  /// The best of two starts after exchanges: these, and these with three more of which the least valuable leave.
  /// @param greedy  of greedy()
  std::vector<int> chosen(const std::vector<int>& greedy) const;
  /// @param fixed  how many of the first stay
  std::vector<int> exchanged(std::vector<int> sensors, int fixed = 0) const;

private:
  double criterion(const std::vector<int>& sensors) const;
  struct Time {
    Eigen::MatrixXd places;  // (places x parameters) K
    Eigen::MatrixXd tcp;     // (parameters x parameters) um^2
    Eigen::VectorXd decay;   // (parameters) a since the time before
    bool first = false;      // of a load program
  };
  std::vector<Time> times_;
  ChoiceOptions options_;
  Eigen::Index places_ = 0, parameters_ = 0;  // places that may be chosen
};

}  // namespace thermotwin::study
