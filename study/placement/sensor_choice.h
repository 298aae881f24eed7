// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Chooses sensors by the variance that a Kalman filter in the uncertain parameters leaves of the TCP error.
//
// Parameters theta (in standard deviations) return to their prior with their memory: theta' = a theta + w, a = exp(-dt
// / memory), Var w = (1 - a^2) times that of the prior. A sensor at place i reads h_i(t)^T theta + b_i + noise with a
// constant bias b_i. The TCP's variance is tr(M(t) P(t)), M the mean over the poses of the squared translations per
// parameter. The criterion is the root of its mean over all times and load programs, in um.
//
// The mesh of the model differs from the machine by d_i(t) at the places and by e(t) at the TCP (model_errors.h), which
// no parameter explains. The filter takes them for parameters: it finds m(t) from d_i(t), which takes G(t) m(t) from
// e(t). The mean square of e(t) - G(t) m(t) over the poses, and over the other meshes, joins the variance. Sensors may
// thus tell a part of e, where both meshes agree on it. Noise of a reading: as in the observer, 3 % of the change since
// the start beside noise_K, one independent sample in half an hour.
//
// A place that is best alone may be useless beside two others: three more are taken and the least valuable leave.
// Greedy: the place that lowers the criterion most joins, one after another. Exchange: each sensor is replaced by the
// place that lowers the criterion most, until no replacement does (Fedorov 1972). Where there are many places, all are
// judged along every fourth time, whose readings then count fourfold, and the most promising along all times.

#include <Eigen/Core>

#include <cstddef>
#include <utility>
#include <vector>

#include "study/placement/model_errors.h"
#include "study/placement/responses.h"

namespace thermotwin::study {

struct ChoiceOptions {
  double noise_K = 0.05;        ///< standard deviation of a reading, mean of the interval between two times
  double bias_K = 0.1;          ///< of a sensor's constant bias: its calibration and the mesh's error beside it
  int exchanges = 3;            ///< passes over the sensors at most; 0: greedy alone
  bool any_loss = false;        ///< exchange for the criterion after the loss of the worst sensor
  int all_times_from = 64;      ///< so many places at most are all judged along all times
  Eigen::Index choosable = -1;  ///< only the first places may be chosen; -1: all
  void validate() const;        ///< @throws InputError
};

/// What is left of the TCP error, RMS over poses, times and load programs, um.
struct Left {
  double parameters_um = 0, mesh_um = 0;
  double all_um() const;
};

class SensorChoice {
public:
  /// @param places  (places x order) temperature of each place per state
  /// @param tcp     (3 poses x order) translations per state, um/K
  /// @param errors  of the model along each load; empty: a reading has noise_K alone and the mesh has no error
  SensorChoice(const std::vector<LoadResponses>& loads, const std::vector<UncertainParameter>& parameters,
               const Eigen::MatrixXd& places, const Eigen::MatrixXd& tcp, const ChoiceOptions& options,
               const std::vector<ModelErrors>& errors = {});

  /// The criterion of these places, um.
  double left_um(const std::vector<int>& sensors) const { return left(sensors).all_um(); }
  /// Its two parts.
  Left left(const std::vector<int>& sensors) const { return left(sensors, steps_); }
  /// The same after the loss of the sensor without which it is largest; of one sensor: without sensors.
  double left_after_loss_um(const std::vector<int>& sensors) const { return after_loss_um(sensors, steps_); }

  /// @param count  of sensors  @param taken  places to begin with, which stay
  std::vector<int> greedy(int count, const std::vector<int>& taken = {}) const;
  /// The best of two starts after exchanges: these, and these with three more of which the least valuable leave.
  /// @param greedy  of greedy()
  std::vector<int> chosen(const std::vector<int>& greedy) const;
  /// @param fixed  how many of the first stay
  std::vector<int> exchanged(std::vector<int> sensors, int fixed = 0) const;

private:
  struct Time {
    Eigen::MatrixXd places;  // (places x parameters) K
    Eigen::MatrixXd tcp;     // (parameters x parameters) um^2
    Eigen::MatrixXd mesh_K;  // (places x meshes) d
    Eigen::MatrixXd cross;   // (parameters x meshes) G^T e over the number of poses, um^2
    double mesh_um2 = 0;     // e^T e over the number of poses, mean over the meshes
  };
  struct Step {
    std::size_t time = 0;
    bool first = false;     // of a load program
    Eigen::VectorXd decay;  // (parameters) a since the step before
    Eigen::VectorXd prior;  // (parameters) variance
    Eigen::VectorXd noise;  // (places) variance of the readings since then, K^2
  };
  using Steps = std::vector<Step>;
  Left left(const std::vector<int>& sensors, const Steps& steps) const;
  double after_loss_um(const std::vector<int>& sensors, const Steps& steps) const;
  double criterion(const std::vector<int>& sensors, const Steps& steps) const;
  /// The place that leaves least, and what it leaves. @param with  sensors with a place; none: not to be judged
  /// @param value  of sensors along steps
  template <class With, class Value>
  std::pair<int, double> best_place(const With& with, const Value& value) const;

  std::vector<Time> times_;
  Steps steps_, fewer_steps_;
  ChoiceOptions options_;
  Eigen::Index places_ = 0, parameters_ = 0;  // places that may be chosen
};

}  // namespace thermotwin::study
