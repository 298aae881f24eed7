// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What runs beside a control: rows of channels in, axis offsets out. Two do it: Compensator (compensator.h), the class
// of the library, and OnlineTwin (control/online_twin.h), the core that `compensate` and the exports run.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "compensation/online/detectability.h"
#include "compensation/online/error_model.h"
#include "compensation/online/offset_limits.h"
#include "mesh/machine/kinematics.h"
#include "solver/operation/channels.h"

namespace thermotwin::compensation {

/// Longest time between two rows, s. After a longer gap (a clock that was set, a machine long off) the state is
/// invalid, and the model has to be restarted.
inline constexpr double longest_gap_s = 30 * 86400.0;

/// A probed error beyond it is no measurement, um.
inline constexpr double largest_probe_um = 1e5;

enum class Status { ok, no_sensors, outside_workspace, input_missing, sensor_failed, limited, failed };
const char* status_text(Status status);

struct Offsets {
  double time = 0;            ///< s
  Eigen::VectorXd offset_um;  ///< (linear axes of the machine) to apply
  Eigen::VectorXd std_um;     ///< (linear axes) one standard deviation, with the part that the guard holds back
  Eigen::VectorXd before_um;  ///< (linear axes) offsets in effect until this row; 0 after a start
  Status status = Status::ok;
  /// "T3=stuck T5=absent T9=kelvin": sensors left out, named where the status is sensor_failed or input_missing.
  std::string failed_sensors;
  /// "air.T_C=kelvin": implausible temperatures among the inputs, which are not used; the status is input_missing.
  std::string failed_inputs;
};

class OnlineModel {
public:
  virtual ~OnlineModel() = default;

  virtual const solver::Channels& channels() const = 0;
  /// @return the linear axes that receive offsets: "X", "Y", "Z"
  virtual const std::vector<std::string>& axes() const = 0;
  /// @return the limits that the offsets of every row keep
  virtual const OffsetLimits& limits() const = 0;

  /// States the channels that no row will have. They keep their defaults, and std_um includes the heat that their
  /// drives may produce. To be called before the first row. @param channels  indices
  /// @throws InputError for an index without a channel
  virtual void never_told(const std::vector<Eigen::Index>& channels) = 0;

  /// Processes one row.
  /// @param time       s, strictly rising
  /// @param row        (channels) values that hold since the last row; not_given keeps the last value. An
  ///   ambient that starts at its default counts as not measured (see ErrorModel::start).
  /// @param sensors_C  (sensors) readings, NaN where missing; empty: none
  /// @throws InputError if time runs backwards or leaps further than longest_gap_s
  virtual const Offsets& step(double time, const Eigen::VectorXd& row, const Eigen::VectorXd& sensors_C) = 0;

  /// Takes in a TCP error measured on the machine (probing, R-Test) at the time of the last row. It re-identifies
  /// machine quantities, expansions of the tool and table side and a decaying remainder. The correction takes effect
  /// over some minutes, so that no offset jumps. It may be called any number of times per row.
  /// @param error_um  (3) tool against table without any offset, NaN where not measured
  /// @param std_um    one standard deviation of each, > 0
  /// @throws InputError before the first row, or for a deviation or value out of range
  virtual void probe(const mesh::Pose& pose, const Eigen::Vector3d& error_um, double std_um) = 0;
  /// The same for values that were probed with compensation active. @param applied_um  (axes) offsets in effect
  void probe_compensated(const mesh::Pose& pose, const Eigen::Vector3d& left_um, const Eigen::VectorXd& applied_um,
                         double std_um) {
    probe(pose, left_um - motion_um(applied_um), std_um);
  }
  virtual long probed() const = 0;  ///< number of values so far

  /// @return the present estimates of the filter, by physical names
  virtual std::vector<ErrorModel::State> learned() const = 0;
  /// @return the detectability of the disturbance states with the sensors that gave readings, at the mean operating
  ///   point
  /// @throws InputError before the first step has ended
  virtual Detectability detectability() const = 0;

  /// @return the predicted TCP error at a pose for the present state, without the guard; 0 before the first row
  virtual solver::TcpError tcp(const mesh::Pose& pose) const = 0;
  /// @return (axes) one standard deviation of the offsets that would cancel tcp(), um
  virtual Eigen::VectorXd std_um(const mesh::Pose& pose) const = 0;
  /// @return (3) translation of the tool against the table, um, that offsets of the axes (um) make
  virtual Eigen::Vector3d motion_um(const Eigen::VectorXd& offset_um) const = 0;
  virtual mesh::Pose pose() const = 0;  ///< of the last row
  /// @return (order) the corrected state at the end of the last step, K above the reference
  virtual Eigen::VectorXd state() const = 0;
  /// @return (sensors) the readings predicted before the last correction, degC
  virtual Eigen::VectorXd predicted_sensors_C() const = 0;
};

/// @throws InputError for a probed value or standard deviation (um) out of range
void check_probe(const Eigen::Vector3d& error_um, double std_um);
void check_probe_std(double std_um);

}  // namespace thermotwin::compensation
