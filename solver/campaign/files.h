// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The files of a campaign: out/<load>/tcp.csv, sensors.csv, inputs.csv, heat.csv, snapshots.bin and fields.bin if asked
// for, and `done`. The last one is written at the end and holds the hash of everything that the results depend on, and
// the hash of the tables. A load whose tables were changed afterwards is run again.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"

namespace thermotwin::solver {

/// @return the hash of machine, mesh, program, poses and options  @param mesh_hash  see hash_of_mesh
std::string hash_of_load(const FullModel& model, const std::string& mesh_hash, const LoadProgram& load,
                         const std::vector<mesh::Pose>& poses, const CampaignOptions& options);
std::string hash_of_mesh(const mesh::MachineMesh& mesh);
/// @return the hash of loads that run together, which their bits depend on
std::string hash_of_block(const std::vector<std::string>& hashes_of_loads);

/// Significant digits of the tables of a load. Nine would round a temperature of 20 degC to 2.5e-9 of itself, where
/// runs of equal machines agree to 1e-9.
inline constexpr int table_digits = 12;

/// Writes the result and rounds its tables to the digits of the files, so that a resumed campaign continues with the
/// same numbers. An earlier result is kept until the new one is complete.
void write_result(const std::filesystem::path& folder, LoadResult& result, const std::string& hash);

/// @return the result if the folder holds a complete one with this hash, with snapshots and fields as the options ask
std::optional<LoadResult> read_result(const std::filesystem::path& folder, const std::string& load,
                                      const std::string& hash, const CampaignOptions& options);

/// Why read_result() takes nothing from a folder.
enum class Unused { none_there, other_inputs, changed_tables, no_temperatures };
Unused why_unused(const std::filesystem::path& folder, const std::string& hash);

/// @return the result if the folder holds a complete one, whatever inputs it was made of
std::optional<LoadResult> read_result(const std::filesystem::path& folder, const std::string& load,
                                      const CampaignOptions& options);

/// Names of the files of a result in its folder; `done` is last.
std::vector<std::filesystem::path> result_files(const std::filesystem::path& folder);

}  // namespace thermotwin::solver
