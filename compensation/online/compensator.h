// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Runs the reduced model beside a control: rows of channels in, axis offsets out.
//
// The thermal state advances in steps of at most step_s with the means of the inputs since the last step. Each row gets
// the TCP error at its own pose, with the state extrapolated to its time at the rate of the last step. If there are
// sensors, an observer corrects the state. It is a Kalman filter in the uncertain quantities of machine.toml (powers,
// films, contacts, ambients, initial state) and a bias for each sensor, see error_model.h. A sensor that is missing
// (NaN) or has failed (sensor_monitor.h) is left out.
//
// std_um combines the observer's covariance, a share of the offset for quantities that are not estimated (expansions,
// the mesh) and the stated error of the reduced model. A guard (offset_guard.h) limits size and rate of the offsets,
// starting from 0 at the first row, for any input; std_um includes the part that it holds back. tcp() is the model's
// prediction without the guard.

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

/// Longest time between two rows, s. After a longer gap (a clock that was set, a machine long off) the state is
/// invalid, and the compensator has to be restarted.
inline constexpr double longest_gap_s = 30 * 86400.0;

/// A probed error beyond it is no measurement.
inline constexpr double largest_probe_um = 1e5;

struct CompensatorOptions {
  double step_s = 60.0;         ///< longest step of the thermal state, 1 ms to a day
  double correction_s = 300.0;  ///< the observer corrects at the first end of a step after this time
  bool use_sensors = true;
  double start_C = 20.0;  ///< uniform initial temperature without sensors
  bool start_from_sensors = true;
  double largest_um = 0.0;  ///< limit of each offset, at most 1e5; 0: from the model, see offset_limits.h
  double rate_um_s = 0.0;   ///< limit of each offset's rate, 1e-6 to 1e6; 0: from the model
  void validate() const;    ///< @throws InputError
};

enum class Status { ok, no_sensors, outside_workspace, input_missing, sensor_failed, limited, failed };
const char* status_text(Status status);

struct Offsets {
  double time = 0;            ///< s
  Eigen::VectorXd offset_um;  ///< (linear axes of the machine) to apply
  Eigen::VectorXd std_um;     ///< (linear axes) one standard deviation, with the part that the guard holds back
  Status status = Status::ok;
  /// "T3=stuck T5=absent T8=drift T9=kelvin" where the status is sensor_failed; such sensors are left out.
  std::string failed_sensors;
  /// "air.T_C=kelvin": implausible temperatures among the inputs, which are not used; the status is input_missing.
  std::string failed_inputs;
};

class Compensator {
public:
  /// @param model  must outlive the compensator  @throws InputError for options out of range
  explicit Compensator(const reduction::ReducedModel& model, const CompensatorOptions& options = {});
  ~Compensator();
  Compensator(Compensator&&) noexcept;

  const solver::Channels& channels() const;
  /// @return the linear axes that receive offsets: "X", "Y", "Z"
  const std::vector<std::string>& axes() const;
  /// @return the limits that the offsets of every row keep
  const OffsetLimits& limits() const;

  /// States the channels that no row will have. They keep their defaults, and std_um includes the heat that their
  /// drives may produce. To be called before the first row. @param channels  indices
  /// @throws InputError for an index without a channel
  void never_told(const std::vector<Eigen::Index>& channels);

  /// Processes one row.
  /// @param time       s, strictly rising
  /// @param row        (channels) values that hold since the last row; not_given keeps the last value. An
  ///   ambient that starts at its default counts as not measured (see ErrorModel::start).
  /// @param sensors_C  (sensors) readings, NaN where missing; empty: none
  /// @throws InputError if time runs backwards or leaps further than longest_gap_s
  const Offsets& step(double time, const Eigen::VectorXd& row, const Eigen::VectorXd& sensors_C);

  /// Takes in a TCP error measured on the machine (probing, R-Test) at the time of the last row. It re-identifies
  /// machine quantities, expansions of the tool and table side and a decaying remainder. The correction takes effect
  /// over some minutes, so that no offset jumps. It may be called any number of times per row.
  /// @param error_um  (3) tool against table without any offset, NaN where not measured
  /// @param std_um    one standard deviation of each, > 0
  /// @throws InputError before the first row, or for a deviation or value out of range
  void probe(const mesh::Pose& pose, const Eigen::Vector3d& error_um, double std_um);
  /// The same for values that were probed with compensation active. @param applied_um  (axes) offsets in effect
  void probe_compensated(const mesh::Pose& pose, const Eigen::Vector3d& left_um, const Eigen::VectorXd& applied_um,
                         double std_um);
  long probed() const;  ///< number of values so far

  /// @return the present estimates of the filter, by physical names
  std::vector<ErrorModel::State> learned() const;
  /// @return the detectability of the disturbance states with the sensors that gave readings, at the mean operating
  ///   point
  /// @throws InputError before the first step has ended
  Detectability detectability() const;

  /// @return the predicted TCP error at a pose for the present state, without the guard; 0 before the first row
  solver::TcpError tcp(const mesh::Pose& pose) const;
  /// (axes) one standard deviation of the offsets that would cancel tcp(), um.
  Eigen::VectorXd std_um(const mesh::Pose& pose) const;
  mesh::Pose pose() const;  ///< of the last row
  /// @return the corrected state (order) at the end of the last step
  const Eigen::VectorXd& state() const;
  /// @return the sensor readings predicted before the last correction, degC
  Eigen::VectorXd predicted_sensors_C() const;

private:
  struct Work;
  std::unique_ptr<Work> work_;
};

struct StreamOptions {
  bool unbuffered = false;          ///< flush each row
  bool strict = false;              ///< an unreadable or impossible cell or row is an error; else it counts as missing
  double probe_std_um = 0.5;        ///< of a probed value
  bool probed_compensated = false;  ///< the values were probed with compensation active
  /// Receive notes on missing columns, and on the first ten unreadable cells.
  std::function<void(const std::string&)> log = core::log_line, warn = core::warn;
  void validate() const;  ///< @throws InputError
};

}  // namespace thermotwin::compensation
