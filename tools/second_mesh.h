// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The mesh error of a case, from a second mesh of it.

#include <filesystem>
#include <optional>
#include <string>

#include "reduction/model/reduced_model.h"
#include "solver/campaign/case.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"
#include "solver/operation/load_program.h"

namespace thermotwin::tools {

/// Runs the load on another mesh (reduction::second_meshes) and compares.
/// @param result  of the load on `full`
/// @return nothing, with a warning, where no second mesh differs or none can be made
std::optional<reduction::MeshError> mesh_error_of(const solver::FullModel& full, const solver::Case& machine_case,
                                                  const solver::LoadProgram& load, const solver::LoadResult& result,
                                                  const std::filesystem::path& out);

/// @return what a virtual measurement was measured on: another mesh than that of the judged model, or the same one
std::string about_measured_mesh(const reduction::ReducedModel& model, Eigen::Index measured_nodes);

}  // namespace thermotwin::tools
