// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The uncertainty of the reduced model, and its estimation from sensors. Each uncertain quantity theta_k of
// machine.toml (source powers, films, contact conductances, coolant films and flow, ambient temperatures, initial
// state) changes the state by S_k theta_k, where
//   E dS_k/dt + K(p) S_k = ds/dtheta_k q - dK/dtheta_k x
// is driven by the inputs of the machine. The initial state may contain what spindle, axes, standing losses, fluid and
// surroundings left behind hours before (work_before.h). The covariance of the state is S Sigma S^T: small after a
// night's rest, large after hours at speed, and with the spatial pattern of the causes.
//
// Sensors (H, with a constant bias each) update theta and Sigma by a Kalman filter in these few parameters, and the
// correction of the state is S theta. Neither the nominal state nor S can become unstable, because the correction
// enters only the products on the right-hand side of S. Machine parameters hardly return to their prior, ambient ones
// within hours. The noise of a mean reading is that of one independent sample per correlation time, because
// discretisation errors last long; outliers have less weight. The heat of a drive whose speed is not recorded is a
// further quantity (drive_heats.h). Probing of the TCP error adds nine quantities of the outputs: the relative excess
// of the motion of the tool side and the table side along x, y and z (expansions, scales), and a remainder in x, y and
// z that decays within hours.
//
// Limits: first order in theta (products with x + S theta keep most of the second order), capacities are not estimated,
// expansions only by probing.

#include <Eigen/Core>
#include <Eigen/LU>

#include <string>
#include <vector>

#include "compensation/online/drive_heats.h"
#include "compensation/online/uncertain_quantities.h"
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
  /// States, before start(), that no heat of earlier work is left in the machine.
  void rested() { rested_ = true; }
  /// States the initial positions of the axes; to be called before start() and before(). @param row  (channels)
  void work_ends_at(const Eigen::VectorXd& row) { work_before_.ends_at(row); }
  /// Resets the model. The initial state may contain the heat of earlier work, whose amount and end are weighted by the
  /// evidence of the first readings; update() still has to learn these readings.
  /// @param uniform_K  standard deviation of the mean initial temperature   @param readings  none: earlier work unknown
  /// @param ambient_gap_K  (ambients) temperature by the sensors minus the default of an ambient that is not measured;
  ///   such an ambient may be at either: mean and standard deviation become half the gap
  void start(double uniform_K, const std::vector<FirstReading>& readings, const Eigen::VectorXd& ambient_gap_K);
  /// @return the model of earlier work and its evidence in the first readings
  const WorkBefore& before() const { return work_before_; }
  /// How what the start left changes from now on, until the next advance(). @param interval  its duration and operator
  void foresee(const Interval& interval);
  /// States, before start(), that the air temperature is not recorded.
  void air_is_untold();
  bool is_air_untold() const { return air_is_untold_; }
  /// States, after start(), that the offset of a sensor has this standard deviation and stays as it is. Does nothing
  /// where the stated one is larger.
  void doubt(Eigen::Index sensor, double std_K);
  bool doubts(Eigen::Index sensor) const { return memory_.size() > 0 && memory_[directions_.cols() + sensor] == 0.0; }
  /// Drives with a heat of their own, see set_untold().
  const std::vector<DriveHeat>& drives() const { return drives_; }
  /// States the heat of an unrecorded drive over the interval of the next advance(). It becomes a quantity at the first
  /// call: theta is the heat beyond that of the nominal run, in units of that at half speed, with a standard deviation
  /// of 1, and at least minus that of the nominal run. @param heat  (order) mean of heat_at_half_speed; empty: recorded
  /// @param nominal  speed of the nominal run over half speed
  void set_untold(Eigen::Index drive, const Eigen::VectorXd& heat, double nominal);

  void advance(const Interval& interval);

  /// The mean of reading minus nominal prediction (K) of one sensor over the last interval.
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
  /// Corrections of the outputs by probing: tool side and table side times 1 + share, and a remainder, m.
  struct OutputShares {
    Eigen::Vector3d tool, table, rest;
  };
  OutputShares output_shares() const;

  /// Corrections by learn or release take effect gradually: the shown correction follows with a time constant.
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

  /// A sensor's offset by the other sensors and the model: its posterior without its own prior.
  struct SensorOffset {
    double value = 0, std = 0;  ///< K; std is infinite where nothing else tells
  };
  SensorOffset offset(Eigen::Index sensor) const;
  SensorOffset own_offset(Eigen::Index sensor) const;  ///< with its own prior
  /// Removes the prior of a sensor's offset, so that its influence on other quantities returns to the offset.
  void release(Eigen::Index sensor);

  /// A state of the filter with its physical name.
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
  using Quantity = UncertainQuantity;
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
  bool rested_ = false;
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
  bool learns_ = false, air_is_untold_ = false;
  Eigen::VectorXd memory_;
  Eigen::MatrixXd sigma_;
  Eigen::PartialPivLU<Eigen::MatrixXd> factor_;
  Eigen::VectorXd factor_p_;
  double factor_duration_ = 0;
};

}  // namespace thermotwin::compensation
