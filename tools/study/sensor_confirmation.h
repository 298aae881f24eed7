// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The sensors of a case and chosen ones on machines that are measured virtually. Each machine is measured once and has
// both, so that a difference is one of the places.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "core/statistics.h"
#include "reduction/model/reduced_model.h"
#include "solver/campaign/case.h"
#include "tools/study/study.h"

namespace thermotwin::tools {

/// Medians over the machines of what is left along a load program, um.
struct ConfirmedLoad {
  std::string load;
  double without_um = 0, own_um = 0, chosen_um = 0;
};

/// RMS of the TCP error that the compensator leaves on each machine, um.
struct ConfirmedSensors {
  std::vector<double> own, chosen;
  std::vector<ConfirmedLoad> loads;
  bool own_mesh = false;  ///< of the model: its error takes no part
  double own_um() const { return core::median(own); }
  double chosen_um() const { return core::median(chosen); }
  double change_percent() const { return 100.0 * (chosen_um() / own_um() - 1.0); }
  int better() const {
    int count = 0;
    for (std::size_t i = 0; i < own.size(); ++i) count += chosen[i] < own[i] ? 1 : 0;
    return count;
  }
};

bool has_linear_axis(const mesh::Machine& machine);

/// @throws InputError  for a case without check points, or a machine without a linear axis
void require_confirmable(const solver::Case& machine_case);

/// @param rows   (places x order) temperatures of the chosen places
/// @param nodes  of the model's mesh
ConfirmedSensors confirmed_sensors(const StudySensorsOptions& options, const solver::Case& machine_case,
                                   const solver::Case& placed, const reduction::ReducedModel& model,
                                   const Eigen::MatrixXd& rows, Eigen::Index nodes);

}  // namespace thermotwin::tools
