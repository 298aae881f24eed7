// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What the filter's parameters do not explain: the differences between a load on the reduced model and on a second mesh
// (reduction/basis/mesh_error.h), at the places of sensors and at the TCP. Both count since the start of the load, as a
// compensator sees them.

#include <Eigen/Core>

#include <filesystem>
#include <string>
#include <vector>

#include "mesh/machine_mesh.h"
#include "reduction/model/reduced_model.h"
#include "solver/campaign/case.h"
#include "study/placement/responses.h"

namespace thermotwin::study {

/// Along one load program, at the times of its responses.
struct ModelErrors {
  std::vector<Eigen::VectorXd> changes_K;  ///< (places) of the nominal temperatures since the start
  std::vector<Eigen::VectorXd> places_K;   ///< (places) second mesh less model; empty: no second mesh
  std::vector<Eigen::VectorXd> tcp_um;     ///< (3 poses) the same of the translations
};

/// @param mesh      of the model
/// @param sensors   that the rows are of: id, and what each sits on
/// @param places    (sensors x order) temperature of each per state
/// @param tcp       (3 poses x order) translations at the poses of the workspace per state, um/K
/// @param along     times of each load
/// @param cache     folder of meshes
/// @param second    in words; empty, with a warning, where no second mesh differs or none can be made
std::vector<ModelErrors> model_errors(const solver::Case& machine_case, const mesh::MachineMesh& mesh,
                                      const reduction::ReducedModel& model,
                                      const std::vector<mesh::SensorSpec>& sensors, const Eigen::MatrixXd& places,
                                      const Eigen::MatrixXd& tcp, const std::vector<solver::LoadProgram>& loads,
                                      const std::vector<LoadResponses>& along, const std::filesystem::path& cache,
                                      std::string& second);

}  // namespace thermotwin::study
