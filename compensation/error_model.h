// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What the reduced model may be wrong about, and what sensors say about it. Each uncertain quantity
// theta_k of machine.toml (source powers, films, contact conductances, coolant films and flow,
// ambient temperatures, the temperature at the start) moves the state by S_k theta_k, where
//   E dS_k/dt + K(p) S_k = ds/dtheta_k q - dK/dtheta_k x
// is driven by the inputs that the machine really had. So the covariance of the state is
// S Sigma S^T: small after a night's rest, large after hours at speed, and its footprint is that of
// the causes. Sensors (H, with a constant bias each) update theta and Sigma by a Kalman filter in
// these few parameters; the state correction is S theta, and neither nominal state nor S can become
// unstable, since the correction only enters the products of S's right-hand side. Machine
// parameters hardly fade; ambient ones return to their prior within hours. A mean reading's noise is
// that of one independent sample a correlation time, since what a mesh gets wrong is wrong for long;
// far outliers count less. Limits: first order in theta (products with x + S theta keep most of
// the second), capacities and expansions are not estimated.

#include <Eigen/Core>
#include <Eigen/LU>
#include <vector>

#include "reduction/reduced_model.h"

namespace thermotwin::compensation {

class ErrorModel {
 public:
  /// @param model  must outlive the error model
  explicit ErrorModel(const reduction::ReducedModel& model);

  /// Forgets everything. @param coefficients  nominal at the start, for the slowest modes
  /// @param uniform_K, shape_K  standard deviations of the start's mean and of its modes
  /// @param ambient_gap_K  (ambients) temperature that sensors found minus the default of an ambient
  ///   that nobody measures; such an ambient may be at either: mean and deviation become half the gap
  void start(const solver::Coefficients& coefficients, double uniform_K, double shape_K,
             const Eigen::VectorXd& ambient_gap_K);

  /// Means over an interval of the nominal model's run.
  struct Interval {
    double duration = 0;                 ///< s
    Eigen::VectorXd p, q, state;
    Eigen::MatrixXd operator_matrix;     ///< K0 + sum p K
  };
  void advance(const Interval& interval);

  /// Mean reading minus nominal prediction (K) of one sensor over the last interval.
  struct Innovation {
    Eigen::Index sensor = 0;
    double value = 0;
    double moment = 1;                   ///< mean time in the interval, 0 start .. 1 end
    double deviation_K = 0;              ///< how far the sensor is from the start: scales model error
  };
  /// @param independent_s  > 0: time that the readings stand for; 0: one independent sample
  void update(const std::vector<Innovation>& innovations, double independent_s);

  Eigen::VectorXd correction() const { return directions_ * theta_.head(directions_.cols()); }
  /// (sensors) correction of the predicted readings, biases included
  Eigen::VectorXd sensor_correction() const;
  const Eigen::MatrixXd& directions() const { return directions_; }           ///< S
  auto covariance() const { return sigma_.topLeftCorner(directions_.cols(), directions_.cols()); }
  /// Standard deviation of the noise and model error of a mean reading, K.
  double reading_std(Eigen::Index sensor, double deviation_K) const;

 private:
  struct Quantity {
    double std = 0;                      ///< of theta: a share, or K for ambient ones
    double memory = 0;                   ///< s, time constant of the return to the prior; 0: none
    std::vector<int> terms;              ///< terms (and what they drive) that scale with 1 + theta
    std::vector<int> inputs;             ///< inputs that scale with 1 + theta
    std::vector<int> ambient_inputs;     ///< inputs that get p of their term times theta
    int ambient = -1;                    ///< index of the ambient, for those
  };
  void add_machine_quantities();
  void add_ambient_quantities();
  void fade(double duration);

  const reduction::ReducedModel& model_;
  std::vector<Quantity> quantities_;
  std::vector<std::vector<int>> inputs_of_term_;
  Eigen::Index start_modes_ = 0;
  Eigen::MatrixXd directions_, sensor_directions_, last_sensor_directions_;
  Eigen::VectorXd theta_, prior_, mean_; ///< quantities, start modes, sensor biases
  Eigen::VectorXd memory_;
  Eigen::MatrixXd sigma_;
  Eigen::PartialPivLU<Eigen::MatrixXd> factor_;
  Eigen::VectorXd factor_p_;
  double factor_duration_ = 0;
};

}  // namespace thermotwin::compensation
