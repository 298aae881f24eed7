// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The machine in 3-D (solver/export/machine_scene.h) as the reduced model sees it: fields are basis times state.

#include <filesystem>
#include <vector>

#include "reduction/model/reduced_model.h"
#include "solver/campaign/case.h"
#include "solver/campaign/full_model.h"
#include "solver/export/machine_scene.h"
#include "solver/operation/load_program.h"
#include "tools/chain.h"

namespace thermotwin::tools {

/// Scene of the loads by the reduced model. @param basis  (size x order) of the model
solver::MachineScene reduced_scene(const solver::FullModel& full, const reduction::ReducedModel& model,
                                   const Eigen::MatrixXd& basis, const std::vector<solver::LoadProgram>& loads);

/// For a campaign of the reduced model: scene.bin beside the model, its loads exchanged for these. Without such a file
/// the scene has arrows only.
solver::MachineScene reduced_scene(const std::filesystem::path& scene_file, const reduction::ReducedModel& model,
                                   const std::vector<solver::LoadProgram>& loads);

/// Writes scene.bin; where that fails, a warning says why.
void write_reduced_scene(const std::filesystem::path& file, const solver::FullModel& full, const ReducedCase& made,
                         const solver::Case& machine_case);

/// What a scene.bin of the model is made from.
std::string scene_stamp(const reduction::ReducedModel& model);

}  // namespace thermotwin::tools
