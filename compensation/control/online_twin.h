// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The online core (twin.h) of a reduced model, with the interface of OnlineModel. `compensate` runs it, and so do the
// exports: the same rows give the same bits. Steps and corrections of rows that come quicker than half a step take
// effect up to half a step later than in Compensator (twin.h).
//
// A state that was saved goes on where it was, also for a prediction from the present of a machine:
//   OnlineTwin twin(model);
//   twin.load_file("machine.state");
//   twin.step(twin.time() + 60.0, row, {});   // what a program will do; no readings
//   const solver::TcpError error = twin.tcp(pose);
// The first row after a saved state may come later. Within correction_s of CompensatorOptions its values are taken to
// hold since the time of the state. Beyond that the machine is taken to have been off in between (pause.h), and the
// offsets begin at zero as after a start.

#include <Eigen/Core>

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "compensation/control/control_model.h"
#include "compensation/online/compensator.h"
#include "compensation/online/offset_guard.h"
#include "compensation/online/online_model.h"

namespace thermotwin::compensation {

class OnlineTwin final : public OnlineModel {
public:
  /// @param model  must outlive the twin  @throws InputError for options out of range, as control_data
  explicit OnlineTwin(const reduction::ReducedModel& model, const ControlOptions& options = {});
  /// @param model  as of read_online_data (online_data.h): without its terms all but detectability() works
  /// @param derived  from the whole model
  OnlineTwin(const reduction::ReducedModel& model, DerivedData derived, const ControlOptions& options);
  ~OnlineTwin() override;
  OnlineTwin(OnlineTwin&&) noexcept;

  const solver::Channels& channels() const override;
  const std::vector<std::string>& axes() const override;
  const OffsetLimits& limits() const override;
  void never_told(const std::vector<Eigen::Index>& channels) override;
  const Offsets& step(double time, const Eigen::VectorXd& row, const Eigen::VectorXd& sensors_C) override;
  void probe(const mesh::Pose& pose, const Eigen::Vector3d& error_um, double std_um) override;
  long probed() const override;
  std::vector<ErrorModel::State> learned() const override;
  /// At the mean operating point of the rows that this object has taken. @throws InputError also without the model's
  /// terms
  Detectability detectability() const override;
  solver::TcpError tcp(const mesh::Pose& pose) const override;
  Eigen::VectorXd std_um(const mesh::Pose& pose) const override;
  Eigen::Vector3d motion_um(const Eigen::VectorXd& offset_um) const override;
  mesh::Pose pose() const override;
  Eigen::VectorXd state() const override;
  Eigen::VectorXd predicted_sensors_C() const override;
  Eigen::VectorXd readings_C() const;  ///< (sensors) of the last row; NaN: none
  /// @return why each sensor is left out ("stuck"), empty: it is not
  std::vector<std::string> sensor_faults() const;
  GuardState guard() const;
  /// @return (axes) the offsets of the last row before the guard, um; NaN: the model has failed
  Eigen::VectorXd wanted_um() const;

  double time() const;  ///< s, of the last row; NaN before the first

  /// The whole state as bytes, to which load() returns. @throws InputError as TwinMemory::load
  std::string saved() const;
  void load(std::string_view saved, const std::string& name = "saved state");
  /// The same as a file, see TwinMemory.
  void save_file(const std::filesystem::path& path) const;
  void load_file(const std::filesystem::path& path);
  /// Goes on from the state of a twin of the same model whose step, limits or start temperature may differ. The
  /// prediction of an NC program needs shorter steps than a twin beside the control. The other twin's measured powers
  /// are not taken over; the model's laws replace them. @throws InputError for another model
  void take_over(const OnlineTwin& other);
  /// @return what probing has found, in use by now: shares of the tool side (x y z) and the table side, remainder in m
  Eigen::Vector<double, 9> output_shares() const;
  /// Computes the time from the last row on as a machine that is off. @param until  s
  void pass_pause(double until);

private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace thermotwin::compensation
