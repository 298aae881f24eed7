// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The machine as a saved state of `compensate` has it, to predict from. The state is read with the options that it was
// saved with, and the prediction goes on in steps of the program's rows. Temperatures of surroundings and coolants hold
// as they were last measured. Other inputs that the program does not state are those of a machine that is on.

#include <Eigen/Core>

#include <filesystem>

#include "compensation/control/online_twin.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::nc {

struct PresentOptions {
  std::filesystem::path state;              ///< file of `compensate --state`
  compensation::ControlOptions saved_with;  ///< options that it was saved with
  double after_s = 10.0;                    ///< from the state to the program's start; up to seven days
  double step_s = 10.0;                     ///< longest step of the prediction
  void validate() const;                    ///< @throws InputError
};

class PresentMachine {
public:
  /// @param model  must outlive this
  /// @throws InputError for a file that cannot be read, and a state of another model or saved with other options
  PresentMachine(const reduction::ReducedModel& model, const PresentOptions& options);

  compensation::OnlineModel& online() { return twin_; }
  const compensation::OnlineTwin& twin() const { return twin_; }
  double start_s() const { return start_s_; }  ///< of the program, on the clock of the state's rows
  mesh::Pose pose() const { return twin_.pose(); }

  /// The time between the state and the program. @param row  (channels) of the standing machine
  void stand_until_start(const Eigen::VectorXd& row);
  /// @param seconds  from the program's start  @param row  (channels) as OnlineModel::step
  void step(double seconds, const Eigen::VectorXd& row);

private:
  Eigen::VectorXd filled(Eigen::VectorXd row) const;

  compensation::OnlineTwin twin_;
  Eigen::VectorXd held_;  ///< (channels) NaN where the last measured value holds, or a law takes over
  double start_s_ = 0;
};

}  // namespace thermotwin::nc
