// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The choice of `study sensors`: possible places, those that the filter needs most, and what they leave of the TCP
// error beside the sensors of the case.

#include <Eigen/Core>

#include <optional>
#include <string>
#include <vector>

#include "reduction/model/reduced_model.h"
#include "solver/campaign/case.h"
#include "solver/campaign/full_model.h"
#include "study/placement/candidates.h"
#include "study/placement/sensor_choice.h"
#include "tools/study/sensor_confirmation.h"
#include "tools/study/study.h"

namespace thermotwin::tools {

struct CurvePoint {
  int count;
  double left_um, after_loss_um;
};

struct ChosenSensors {
  std::vector<study::Place> places;  ///< all
  std::vector<int> own, chosen;      ///< indices of the case's sensors (after the places), of the chosen places
  std::vector<CurvePoint> curve;
  std::string second_mesh;  ///< in words; empty: none
  std::string directions;   ///< of the TCP error that count, a sentence; empty: all
  study::Left without_left, own_left, chosen_left;
  double without_um = 0, own_um = 0, own_after_loss_um = 0, chosen_um = 0, chosen_after_loss_um = 0;
  std::vector<double> without_one_um;  ///< after the loss of each chosen one
  std::optional<ConfirmedSensors> confirmed;
  /// The criterion of what the machines differ by from the model.
  double predicted_um(const study::Left& of) const { return confirmed->own_mesh ? of.parameters_um : of.all_um(); }
  /// Whether the machines say of choice and case what the criterion says of them, and what the choice was made by.
  bool borne_out() const {
    const bool better = confirmed->chosen_um() < confirmed->own_um();
    return better == (predicted_um(chosen_left) < predicted_um(own_left)) && better == (chosen_um < own_um);
  }
};

/// Places that the rules of the options leave.
/// @throws InputError  for rules that name nothing, more sensors than places
std::vector<study::Place> sensor_places(const StudySensorsOptions& options, const mesh::MachineMesh& mesh);

/// @param basis  of the model, (size x order or more)  @throws InputError  for more sensors than places
ChosenSensors chosen_sensors(const StudySensorsOptions& options, const solver::Case& machine_case,
                             const solver::FullModel& full, const reduction::ReducedModel& model,
                             const Eigen::MatrixXd& basis, const std::vector<solver::LoadProgram>& loads);

}  // namespace thermotwin::tools
