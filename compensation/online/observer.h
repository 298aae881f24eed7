// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Corrects the thermal state by the sensors. H x are the nominal readings, z the readings without the stated offsets of
// the sensors, and b is the correction of the error model (biases included). The innovation of a row is
//   z - H (x_n + a (x_n - x_n-1)),
// with a of state_clock.h. The expected reading is H x(t) + b + (t - t_c) db/dt, with t_c the time of the last
// correction. The innovations of a sensor and their mean time are averaged until a step ends correction_s after t_c
// (sooner after the start). The error model (error_model.h) then advances its sensitivities by that interval and
// learns. The corrected state is
//   x + S theta + (t - t_c) d(S theta)/dt,
// where the last term contains only the effect of the initial state. At the first row the initial state is a uniform
// temperature, the one with the most evidence in the readings, plus the heat of earlier work (work_before.h).

#include <Eigen/Core>

#include <vector>

#include "compensation/online/detectability.h"
#include "compensation/online/error_model.h"
#include "compensation/online/sensor_trust.h"
#include "compensation/online/state_clock.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::compensation {

struct CompensatorOptions;

class Observer {
public:
  /// All must outlive the observer.
  Observer(const reduction::ReducedModel& model, const solver::OperatingModel& operating,
           const CompensatorOptions& options, StateClock& clock);

  const SensorTrust& trust() const { return trust_; }
  const ErrorModel& errors() const { return errors_; }
  /// Sets implausible temperatures to NaN. @param given  (channels)
  void take_out_inputs(Eigen::VectorXd& given) { trust_.take_out_inputs(given); }

  /// Takes the readings of a row. @param sensors_C  (sensors) degC, NaN where missing; empty: no readings
  /// @param row  (channels) inputs that hold at that time
  void read(const Eigen::VectorXd& sensors_C, const Eigen::VectorXd& row);
  bool any_reading() const { return reading_K_.array().isFinite().any(); }

  /// Sets the initial state from the readings of the first row, and starts the clock. @param time  s
  void start(double time, const Eigen::VectorXd& row);
  /// @return the readings that the chillers use, (sensors + observed) K, valid until the next call: measured ones if
  ///   present and trusted, else predicted ones. A reading that jumps is taken for a transmission fault; if the chiller
  ///   does follow it, the other sensors show that
  const Eigen::VectorXd& guide_readings();
  /// Adds the innovations of the last row. @param inputs_leapt  whether inputs changed abruptly since the row before
  void add_readings(bool inputs_leapt);

  /// @return whether a correction is due at this end of a step
  bool due() const { return clock_.interval_s() >= correction_after(); }
  void correct();
  /// See ErrorModel::learn. @param error  (3) probed TCP error, m, NaN where not measured
  void learn(const ErrorModel::ErrorRows& rows, const Eigen::Vector3d& error, double std_m);
  /// Lets the corrections of learn() take effect gradually. @param duration  s since the last call
  void show(double duration) { errors_.show(duration); }

  /// @return the corrected state at the end of the last step, (order) K
  const Eigen::VectorXd& corrected() const { return corrected_; }
  void set_corrected();
  /// See ErrorModel::air_is_untold.
  void air_is_untold() { errors_.air_is_untold(); }
  /// See ErrorModel::rested; for a machine without readings.
  void rested() { errors_.rested(); }
  /// Accounts for the heat of unrecorded drives since the row before. @param untold  (drives) 1: speed not recorded,
  /// else 0  @param duration  s
  void add_drives(const std::vector<char>& untold, const Eigen::VectorXd& row, double duration);
  const Eigen::VectorXd& correction_rate() const { return correction_rate_; }  ///< of the state, K/s

  /// @return the readings predicted before the last correction, degC
  Eigen::VectorXd predicted_sensors_C() const;
  /// See detectability.h; at the mean operating point of the run so far. @throws InputError before the first step ends
  Detectability detectability() const;

private:
  using FirstReading = ErrorModel::FirstReading;
  using UniformStart = ErrorModel::UniformStart;

  double correction_after() const;
  void advance_errors();
  void settle();
  void take_trusted(Eigen::VectorXd& readings_K) const;
  std::vector<UniformStart> uniform_starts(const Eigen::VectorXd& row, Eigen::Index without = -1) const;
  UniformStart uniform_start(const Eigen::VectorXd& row) const;
  double surroundings_near(const Eigen::VectorXd& row, double value) const;
  UniformStart start_of_one(const Eigen::VectorXd& row, double value) const;
  double doubt_of(const Eigen::VectorXd& row, const std::vector<FirstReading>& readings, std::size_t i) const;
  Eigen::VectorXd ambient_gap(const Eigen::VectorXd& row, const UniformStart& uniform) const;
  std::vector<FirstReading> first_readings(double zero_K, Eigen::Index without = -1) const;
  std::vector<char> explained_by_others(const Eigen::VectorXd& row) const;

  const reduction::ReducedModel& model_;
  const CompensatorOptions& options_;
  StateClock& clock_;
  const solver::OperatingModel& operating_;
  const Eigen::VectorXd& defaults_;  ///< of the channels
  int air_;                          ///< channel of the air; -1: none
  std::vector<int> ambients_;        ///< their channels
  Eigen::VectorXd sensor_offset_;    ///< reading in K above the reference minus the state's temperature
  SensorTrust trust_;
  ErrorModel errors_;

  Eigen::VectorXd reading_C_, reading_K_, guide_K_;
  Eigen::VectorXd sensors_start_, shift_;
  Eigen::VectorXd bias_K_, bias_rate_, unsure_rate_;  ///< correction of predicted readings; its rate; its std
  Eigen::VectorXd own_offset_;                        ///< of the readings themselves
  Eigen::VectorXd correction_rate_, corrected_;
  double corrected_at_ = 0;  ///< s

  Eigen::VectorXd innovation_sum_, moment_sum_;  ///< since the last correction
  Eigen::VectorXi innovation_count_;
  std::vector<ErrorModel::Innovation> innovations_;

  struct Untold {
    Eigen::VectorXd energy;  ///< (order) heat at half speed while the speed was not recorded, J; empty: recorded
    double way = 0;          ///< integral of the nominal run's speed over that time, channel's unit times s
  };
  double drives_s_ = 0;         ///< s, duration of the rows that untold_ sums over
  bool drives_taken_ = false;   ///< a correction has used untold_; the next row resets it
  std::vector<Untold> untold_;  ///< (drives)

  ErrorModel::Interval whole_;  ///< sums over the whole run, for detectability()
  Eigen::VectorXi reading_counts_;
};

}  // namespace thermotwin::compensation
