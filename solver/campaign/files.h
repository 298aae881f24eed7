// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Files of a campaign: out/<load>/tcp.csv, sensors.csv, inputs.csv, snapshots.bin where asked for,
// and `done`, written last, with the hash of all that the load's results depend on and that of the tables:
// a table that something else wrote over is run anew, not believed.

#include <optional>
#include <string>

#include "mesh/machine/kinematics.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"

namespace thermotwin::solver {

/// Hash of machine, mesh, program, poses and options. @param mesh_hash  see hash_of_mesh
std::string hash_of_load(const FullModel& model, const std::string& mesh_hash, const LoadProgram& load,
                         const std::vector<mesh::Pose>& poses, const CampaignOptions& options);
std::string hash_of_mesh(const mesh::MachineMesh& mesh);
/// Of loads that run together, which their bits depend on.
std::string hash_of_block(const std::vector<std::string>& hashes_of_loads);

/// Writes the result and rounds its tables to what the files hold, so that a resumed campaign goes
/// on with the same numbers. An earlier result stays until the new one is complete.
void write_result(const std::filesystem::path& folder, LoadResult& result, const std::string& hash);

/// The result, if the folder holds a complete one of this hash (with snapshots, if wanted).
std::optional<LoadResult> read_result(const std::filesystem::path& folder, const std::string& load,
                                      const std::string& hash, bool snapshots);

}  // namespace thermotwin::solver
