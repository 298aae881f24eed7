// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What the filter's parameters do not explain: the differences between a load on the reduced model and on other meshes,
// at the places of sensors and at the TCP. One mesh is the second one of reduction/basis/mesh_error.h, one has smaller
// edges, hence other faces where rules cut them out. Differences count since the start of the load, as a compensator
// sees them.

#include <Eigen/Core>

#include <filesystem>
#include <string>
#include <vector>

#include "mesh/machine_mesh.h"
#include "reduction/model/reduced_model.h"
#include "solver/campaign/case.h"
#include "study/placement/responses.h"

namespace thermotwin::study {

/// Another mesh less the model along one load program, at the times of its responses.
struct MeshDifference {
  std::vector<Eigen::VectorXd> places_K;  ///< (places)
  std::vector<Eigen::VectorXd> tcp_um;    ///< (3 poses) of the translations
};

/// Along one load program, at the times of its responses.
struct ModelErrors {
  std::vector<Eigen::VectorXd> changes_K;  ///< (places) of the nominal temperatures since the start
  std::vector<MeshDifference> meshes;      ///< each as likely as the others; empty: no other mesh
};

/// @param mesh      of the model
/// @param sensors   that the rows are of: id, and what each sits on
/// @param places    (sensors x order) temperature of each per state
/// @param tcp       (3 poses x order) translations at the poses of the workspace per state, um/K
/// @param along     times of each load
/// @param cache     folder of meshes
/// @param others    the meshes in words; a warning names one that does not differ or cannot be made; empty: neither
std::vector<ModelErrors> model_errors(const solver::Case& machine_case, const mesh::MachineMesh& mesh,
                                      const reduction::ReducedModel& model,
                                      const std::vector<mesh::SensorSpec>& sensors, const Eigen::MatrixXd& places,
                                      const Eigen::MatrixXd& tcp, const std::vector<solver::LoadProgram>& loads,
                                      const std::vector<LoadResponses>& along, const std::filesystem::path& cache,
                                      std::string& others);

}  // namespace thermotwin::study
