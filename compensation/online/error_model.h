// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What the reduced model may be wrong about, and what sensors say about it. Each uncertain quantity
// theta_k of machine.toml (source powers, films, contact conductances, coolant films and flow,
// ambient temperatures, the state at the start) moves the state by S_k theta_k, where
//   E dS_k/dt + K(p) S_k = ds/dtheta_k q - dK/dtheta_k x
// is driven by the inputs that the machine really had. The start may carry what spindle, axes, standing
// losses, fluid and surroundings leave behind within hours (patterns of their cooling). So the covariance of the state
// is
// S Sigma S^T: small after a night's rest, large after hours at speed, and its footprint is that of
// the causes. Sensors (H, with a constant bias each) update theta and Sigma by a Kalman filter in
// these few parameters; the state correction is S theta, and neither nominal state nor S can become
// unstable, since the correction only enters the products of S's right-hand side. Machine
// parameters hardly fade; ambient ones return to their prior within hours. A mean reading's noise is
// that of one independent sample a correlation time, since what a mesh gets wrong is wrong for long;
// far outliers count less. The heat of a drive whose speed nobody tells joins theta (drive_heats.h). Where probing
// tells the TCP error itself, nine quantities of the outputs join theta: by which share more than nominal the tool side
// and the table side move along x, y and z (expansions, scales), and a rest in x, y and z that fades within hours.
// Limits: first order in theta (products with x + S theta keep most of the second), capacities are not estimated,
// expansions by probing only.

#include <Eigen/Core>
#include <Eigen/LU>

#include <string>
#include <vector>

#include "compensation/online/drive_heats.h"
#include "compensation/online/work_before.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::compensation {

class ErrorModel {
public:
  /// @param model  must outlive the error model
  explicit ErrorModel(const reduction::ReducedModel& model);

  /// Means over an interval of the nominal model's run.
  struct Interval {
    double duration = 0;  ///< s
    Eigen::VectorXd p, q, state;
    Eigen::MatrixXd operator_matrix;  ///< K0 + sum p K
  };

  using FirstReading = compensation::FirstReading;
  using UniformStart = compensation::UniformStart;
  /// Where the axes stand at the start: to be told before start() and before(). @param row  (channels)
  void work_ends_at(const Eigen::VectorXd& row) { work_before_.ends_at(row); }
  /// Forgets everything. The start may carry what work before it has left: how long ago that ended and how much it
  /// was is weighted by the evidence of the first readings, which are still to be learnt by update().
  /// @param uniform_K  standard deviation of the start's mean   @param readings  none: nothing is known of work before
  /// @param ambient_gap_K  (ambients) temperature that sensors found minus the default of an ambient
  ///   that nobody measures; such an ambient may be at either: mean and deviation become half the gap
  void start(double uniform_K, const std::vector<FirstReading>& readings, const Eigen::VectorXd& ambient_gap_K);
  /// What work before the start may have left, and what first readings say of that.
  const WorkBefore& before() const { return work_before_; }
  /// How what the start left changes from now on, until the next advance(). @param interval  its duration and operator
  void foresee(const Interval& interval);
  /// Before start(): nobody tells the temperature of the air.
  void air_is_untold();
  /// Drives with a heat of their own, see set_untold().
  const std::vector<DriveHeat>& drives() const { return drives_; }
  /// Heat of a drive that nobody tells of, over the interval of the next advance(). It is a quantity from the first
  /// time on: theta is the heat beyond that of the nominal run, in units of that at half speed, with a deviation of 1,
  /// and not less than the nominal run has. @param heat  (order) mean of heat_at_half_speed; empty: told
  /// @param nominal  speed of the nominal run over half speed
  void set_untold(Eigen::Index drive, const Eigen::VectorXd& heat, double nominal);

  void advance(const Interval& interval);

  /// Mean reading minus nominal prediction (K) of one sensor over the last interval.
  struct Innovation {
    Eigen::Index sensor = 0;
    double value = 0;
    double moment = 1;       ///< mean time in the interval, 0 start .. 1 end
    double deviation_K = 0;  ///< how far the sensor is from the start: scales model error
  };
  /// @param independent_s  > 0: time that the readings stand for; 0: one independent sample
  void update(const std::vector<Innovation>& innovations, double independent_s);

  /// Rows of the TCP error's three translations (m) at one pose, each (3 x order).
  struct ErrorRows {
    Eigen::Matrix3Xd tool, table;  ///< error = (tool + table) * state
  };
  /// A TCP error that was probed. @param nominal  nominal state at its time  @param error (3) m, NaN where
  /// not measured  @param std_m  standard deviation of each
  void learn(const ErrorRows& rows, const Eigen::VectorXd& nominal, const Eigen::Vector3d& error, double std_m);
  bool learns() const { return learns_; }  ///< whether anything was probed
  /// What probing found beside the state: tool side and table side times 1 + share, and a rest, m.
  struct OutputShares {
    Eigen::Vector3d tool, table, rest;
  };
  OutputShares output_shares() const;

  /// What learn or release found is not shown at once: the shown correction follows with a time constant.
  void show(double duration);

  Eigen::VectorXd correction() const { return directions_ * shown().head(directions_.cols()); }
  /// How fast what the start left fades from the correction, K/s of the state
  Eigen::VectorXd correction_rate() const { return start_rate_ * shown().segment(machine_quantities(), start_modes_); }
  /// (sensors) the same of sensor_correction(), K/s
  Eigen::VectorXd sensor_correction_rate() const {
    return sensor_start_rate_ * theta_.segment(machine_quantities(), start_modes_);
  }
  /// (sensors) standard deviation of how fast the predicted readings change, K/s
  Eigen::VectorXd sensor_rate_std() const;
  /// (sensors) correction of the predicted readings, biases included
  Eigen::VectorXd sensor_correction() const;
  const Eigen::MatrixXd& directions() const { return directions_; }  ///< S
  auto covariance() const { return sigma_.topLeftCorner(directions_.cols(), directions_.cols()); }
  const Eigen::MatrixXd& all_covariance() const { return sigma_; }       ///< of all of theta
  Eigen::Index first_output() const { return theta_.size() - outputs; }  ///< index of the output quantities
  /// Standard deviation of the noise and model error of a mean reading, K.
  double reading_std(Eigen::Index sensor, double deviation_K) const;

  /// A sensor's offset as the others and the model see it: its posterior without its own prior.
  struct SensorOffset {
    double value = 0, std = 0;  ///< K; std is infinite where nothing else tells
  };
  SensorOffset offset(Eigen::Index sensor) const;
  /// Forgets that the sensor was expected to be right: what its readings had pushed into other
  /// quantities comes back as its offset.
  void release(Eigen::Index sensor);

  /// A state of the filter by its physical name.
  struct State {
    std::string name, unit;  ///< unit "1": a share of nominal
    double value = 0, std = 0, prior_std = 0;
    double memory_s = 0;  ///< 0: does not fade
  };
  std::vector<State> states() const;
  /// (order x machine quantities) how fast each moves the state per unit, W-scaled as E dx/dt.
  Eigen::MatrixXd rates(const Interval& interval) const;
  Eigen::Index machine_quantities() const { return std::ssize(quantities_); }

private:
  struct Quantity {
    std::string name, unit;
    double std = 0;                   ///< of theta: a share, or K for ambient ones
    double memory = 0;                ///< s, time constant of the return to the prior; 0: none
    std::vector<int> terms;           ///< terms (and what they drive) that scale with 1 + theta
    std::vector<int> inputs;          ///< inputs that scale with 1 + theta
    std::vector<int> ambient_inputs;  ///< inputs that get p of their term times theta
    int ambient = -1;                 ///< index of the ambient, for those
    Eigen::Index drive = -1;          ///< index of the drive whose heat it is
    double least = -3.0;              ///< of theta, in deviations from its mean
  };
  static std::vector<Quantity> make_quantities(const reduction::ReducedModel& model);
  static void add_sources(const reduction::ReducedModel& model, std::vector<Quantity>& quantities);
  static void add_terms(const reduction::ReducedModel& model, std::vector<Quantity>& quantities);
  static void add_ambients(const reduction::ReducedModel& model, std::vector<Quantity>& quantities);
  static std::vector<WorkBefore::Ambient> ambients_of(const std::vector<Quantity>& quantities);
  void add_quantity(Quantity quantity);
  void fade(double duration);
  void settle();
  Eigen::VectorXd shown() const { return theta_ - withheld_; }
  /// One scalar observation row * theta. @param residual  observed - predicted
  void observe(const Eigen::VectorXd& row, double residual, double variance);

  const reduction::ReducedModel& model_;
  std::vector<Quantity> quantities_;
  std::vector<std::vector<int>> inputs_of_term_;
  WorkBefore work_before_;
  std::vector<DriveHeat> drives_;
  struct Untold {
    Eigen::VectorXd heat;        ///< (order) empty: told
    Eigen::VectorXd rate;        ///< (sensors) K/s at which readings rise when it starts
    Eigen::Index quantity = -1;  ///< of the quantities; -1: was always told
  };
  std::vector<Untold> untold_;  ///< (drives)
  Eigen::Index start_modes_ = 0;
  Eigen::MatrixXd directions_, sensor_directions_, last_sensor_directions_;
  Eigen::MatrixXd start_rate_, sensor_start_rate_;  ///< of the start's directions, 1/s
  Eigen::MatrixXd sensor_rate_;                     ///< (sensors x directions) 1/s
  static constexpr Eigen::Index outputs = 9;
  Eigen::VectorXd theta_, prior_, mean_;  ///< quantities, start modes, sensor biases, outputs
  Eigen::VectorXd withheld_;              ///< part of theta that is not shown yet
  Eigen::VectorXd gain_;                  ///< scratch of observe
  bool learns_ = false;
  Eigen::VectorXd memory_;
  Eigen::MatrixXd sigma_;
  Eigen::PartialPivLU<Eigen::MatrixXd> factor_;
  Eigen::VectorXd factor_p_;
  double factor_duration_ = 0;
};

}  // namespace thermotwin::compensation
