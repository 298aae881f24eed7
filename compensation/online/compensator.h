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
#include <string_view>
#include <vector>

#include "compensation/online/online_model.h"
#include "core/progress.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::compensation {

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

class Compensator final : public OnlineModel {
public:
  /// @param model  must outlive the compensator  @throws InputError for options out of range
  explicit Compensator(const reduction::ReducedModel& model, const CompensatorOptions& options = {});
  ~Compensator() override;
  Compensator(Compensator&&) noexcept;

  const solver::Channels& channels() const override;
  const std::vector<std::string>& axes() const override;
  const OffsetLimits& limits() const override;
  void never_told(const std::vector<Eigen::Index>& channels) override;
  /// States, before the first row, that the machine has stood off until no heat of earlier work is left in it: all of
  /// it is at start_C, with a standard deviation of 0.5 K.  @throws InputError if sensors are used, or after a row
  void rested();
  const Offsets& step(double time, const Eigen::VectorXd& row, const Eigen::VectorXd& sensors_C) override;
  void probe(const mesh::Pose& pose, const Eigen::Vector3d& error_um, double std_um) override;
  long probed() const override;
  std::vector<ErrorModel::State> learned() const override;
  Detectability detectability() const override;
  solver::TcpError tcp(const mesh::Pose& pose) const override;
  Eigen::VectorXd std_um(const mesh::Pose& pose) const override;
  Eigen::Vector3d motion_um(const Eigen::VectorXd& offset_um) const override;
  mesh::Pose pose() const override;
  Eigen::VectorXd state() const override;
  Eigen::VectorXd predicted_sensors_C() const override;

private:
  struct Work;
  std::unique_ptr<Work> work_;
};

struct StreamOptions {
  bool unbuffered = false;          ///< flush each row
  bool strict = false;              ///< an unreadable or impossible cell or row is an error; else it counts as missing
  double probe_std_um = 0.5;        ///< of a probed value
  bool probed_compensated = false;  ///< the values were probed with compensation active
  /// Text of a row instead of its CSV, which then has no header. Gets the answer and its status with names.
  std::function<std::string(const Offsets&, std::string_view)> line;
  /// Receive notes on missing columns, and on the first ten unreadable cells.
  std::function<void(const std::string&)> log = core::log_line, warn = core::warn;
  /// Receives notes on missing values: a cell of nan, a channel without a value.
  std::function<void(const std::string&)> lack = core::warn;
  void validate() const;  ///< @throws InputError
};

}  // namespace thermotwin::compensation
