// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The reduced model running beside a control: rows in, offsets out. The thermal state moves on in
// steps of at most step_s with the means of the inputs since the last step; every row gets the TCP
// error at its own pose, the state carried on to its time at the rate of the last step. Where
// sensors are given, an observer corrects the state: a Kalman filter in the uncertain quantities of
// machine.toml (powers, films, contacts, ambients, the start) and a bias for each sensor, see
// error_model.h; a sensor that is missing (NaN) or has failed (sensor_monitor.h) is left out. Inputs are what a control
// has, nothing else. std_um comes from the same covariance, a share of the offset for what is not estimated
// (expansions, the mesh) and the stated error of the reduced model. The offsets of a row are what a guard
// (offset_guard.h) lets through: of limited size and rate from nought at the first row on, whatever comes in; std_um
// then holds what it keeps back. tcp() is the model's own prediction, without the guard.

#include <Eigen/Core>

#include <functional>
#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

#include "compensation/online/detectability.h"
#include "compensation/online/error_model.h"
#include "compensation/online/offset_limits.h"
#include "core/progress.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::compensation {

/// Longest time between two rows, s: beyond it (a clock that was set, a machine long off) the state
/// says nothing any more, and the compensator is to be started anew.
inline constexpr double longest_gap_s = 30 * 86400.0;

struct CompensatorOptions {
  double step_s = 60.0;         ///< longest step of the thermal state, 1 ms to a day
  double correction_s = 300.0;  ///< the observer corrects at the first end of a step after this time
  bool use_sensors = true;
  double start_C = 20.0;  ///< uniform start where no sensor tells better
  bool start_from_sensors = true;
  double largest_um = 0.0;  ///< of an offset, at most 1e5; 0: by the model, see offset_limits.h
  double rate_um_s = 0.0;   ///< of an offset, standing or moving, 1e-6 to 1e6; 0: by the model
  void validate() const;    ///< @throws InputError
};

enum class Status { ok, no_sensors, outside_workspace, input_missing, sensor_failed, limited, failed };
const char* status_text(Status status);

struct Offsets {
  double time = 0;            ///< s
  Eigen::VectorXd offset_um;  ///< (linear axes of the machine) to apply
  Eigen::VectorXd std_um;     ///< (linear axes) one standard deviation, with what the guard keeps back
  Status status = Status::ok;
  /// "T3=stuck T5=absent T8=drift T9=kelvin" where the status is sensor_failed; such sensors are left out.
  std::string failed_sensors;
  /// "air.T_C=kelvin": temperatures among the inputs that cannot be and are not used; the status is input_missing.
  std::string failed_inputs;
};

class Compensator {
public:
  /// @param model  must outlive the compensator  @throws InputError for options out of range
  explicit Compensator(const reduction::ReducedModel& model, const CompensatorOptions& options = {});
  ~Compensator();
  Compensator(Compensator&&) noexcept;

  const solver::Channels& channels() const;
  /// Names of the linear axes that get offsets, "X", "Y", "Z".
  const std::vector<std::string>& axes() const;
  /// What every row's offsets keep to.
  const OffsetLimits& limits() const;

  /// Channels that no row will tell: they stay at their defaults, and std_um has the heat that drives may have had
  /// meanwhile. Before the first row. @param channels  indices
  /// @throws InputError for an index that no channel has
  void never_told(const std::vector<Eigen::Index>& channels);

  /// @param time       s, strictly rising
  /// @param row        (channels) values that hold since the last row; not_given keeps the last. An
  ///   ambient that starts at its default counts as not measured (see ErrorModel::start).
  /// @param sensors_C  (sensors) readings, NaN where missing; empty: none
  /// @throws InputError if time runs backwards or leaps further than longest_gap_s
  const Offsets& step(double time, const Eigen::VectorXd& row, const Eigen::VectorXd& sensors_C);

  /// The TCP error was measured on the machine (probing, R-Test) at the time of the last row: machine
  /// quantities, expansions of the tool and the table side and a fading rest are re-identified. What is
  /// found comes into effect over some minutes, so that no offset jumps. May be called any number of times a row.
  /// @param error_um  (3) tool against table without any offset, NaN where not measured
  /// @param std_um    one standard deviation of each, > 0
  /// @throws InputError before the first row, or for a deviation or value out of range
  void probe(const mesh::Pose& pose, const Eigen::Vector3d& error_um, double std_um);
  /// The same for what is left while offsets are applied. @param applied_um (axes)
  void probe_compensated(const mesh::Pose& pose, const Eigen::Vector3d& left_um, const Eigen::VectorXd& applied_um,
                         double std_um);
  long probed() const;  ///< number of values so far

  /// What the filter knows by now, by physical names.
  std::vector<ErrorModel::State> learned() const;
  /// Which augmented states the sensors that gave readings tell, at the run's mean operating point.
  /// @throws InputError before the first step has ended
  Detectability detectability() const;

  /// Predicted TCP error at a pose for the present state, without the guard; none before the first row.
  solver::TcpError tcp(const mesh::Pose& pose) const;
  /// (axes) one standard deviation of the offsets that would cancel tcp(), um.
  Eigen::VectorXd std_um(const mesh::Pose& pose) const;
  mesh::Pose pose() const;  ///< of the last row
  /// Corrected state at the last end of a step.
  const Eigen::VectorXd& state() const;
  /// Sensor readings predicted before the last correction, degC.
  Eigen::VectorXd predicted_sensors_C() const;

private:
  struct Work;
  std::unique_ptr<Work> work_;
};

struct StreamOptions {
  bool unbuffered = false;          ///< flush each row
  bool strict = false;              ///< a cell or row that cannot be read, or be, is an error; else it is missing
  double probe_std_um = 0.5;        ///< of a probed value
  bool probed_compensated = false;  ///< probed while the offsets of the row before were applied
  /// Told of what the rows do not say, and of what cannot be read; the first ten lines of that.
  std::function<void(const std::string&)> log = core::log_line, warn = core::warn;
  void validate() const;  ///< @throws InputError
};

}  // namespace thermotwin::compensation
