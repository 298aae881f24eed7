// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A case and its campaign: all load programs on the full model, the TCP error at all poses of the
// workspace grid, written load by load (tcp.csv, sensors.csv, heat.csv) so that a stopped campaign resumes,
// within a load from its last checkpoint with the same bits.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/table.h"
#include "mesh/machine_mesh.h"
#include "solver/elastic_model.h"
#include "solver/load_program.h"
#include "solver/simulation.h"
#include "solver/thermal_system.h"

namespace thermotwin::solver {

/// A machine to be measured virtually where no measurement is at hand: what is wrong with it is
/// the truth that a diagnosis has to find.
struct MeasuredMachine {
  std::string load;                            ///< load program it runs
  std::string kind, where;                     ///< effect: source_power | film_coefficient | contact_conductance
  double factor = 1.0;                         ///< ratio to nominal
  std::uint64_t seed = 7;                      ///< of perturbed parameters and noise
  double size_factor = 0.8, refine = 0.8;      ///< its mesh and time steps
};

/// case.toml with what it names.
struct Case {
  std::filesystem::path folder;
  mesh::Machine machine;
  std::string size = "coarse";
  std::vector<std::string> train, holdout;     ///< names of load programs
  std::filesystem::path measurement;           ///< empty if none
  std::optional<MeasuredMachine> measured_machine;  ///< [measured_machine]; used where measurement is empty
  std::vector<mesh::Pose> check_points;
  double tolerance_um = 0.1;
  std::optional<TimeOptions> time;             ///< [time]; for loads without one

  LoadProgram load(const std::string& name) const;  ///< @throws InputError with the known names
  std::vector<std::string> load_names() const;      ///< all files of loads/, sorted
};
/// @param path  case folder or case.toml
Case read_case(const std::filesystem::path& path);

/// The full model of a machine on one mesh, everything that is made once.
struct FullModel {
  mesh::MachineMesh mesh;
  ThermalSystem thermal;
  ElasticModel elastic;
  MemoryPlan memory{};
};
FullModel build_full_model(const mesh::Machine& machine, const mesh::MeshOptions& options,
                           SolverChoice choice = SolverChoice::automatic);

/// Result of one load on the full model.
struct LoadResult {
  std::string load;
  core::Table tcp;       ///< one row per time and pose; no columns: a machine without [tcp]
  core::Table sensors;   ///< time_s, <sensor>_C
  core::Table inputs;    ///< time_s and the channel rows (means since the last output)
  Eigen::MatrixXd snapshots;  ///< (size x outputs) temperatures, if asked for
  std::optional<HeatBalance> heat;  ///< of the run; empty where files were read
  RunSummary run;        ///< of the block that the load ran in; empty where files were read
  core::Table heat_flows;  ///< heat.csv, see HeatBalance::columns; empty: of a reduced model
};

struct CampaignOptions {
  std::vector<mesh::Pose> poses;   ///< empty: the workspace grid
  double refine = 1.0;             ///< factor of the longest time step; with error control of its tolerance
  std::optional<TimeOptions> time; ///< for all loads, in place of their own
  bool keep_snapshots = false;
  std::filesystem::path out;       ///< empty: nothing is written; else out/<load>/tcp.csv ..., of a machine with [tcp]
  bool resume = false;             ///< loads with complete files of the same inputs are read, not run;
                                   ///< others go on from their checkpoints
  std::filesystem::path checkpoints;  ///< folder; empty: none are written or read
  double checkpoint_s = 60;        ///< wall clock seconds between two
  Eigen::VectorXd start;           ///< (size) K above the reference; empty: initial_C of each load
  /// Called at each output after it is recorded; a resumed run may repeat the last ones.
  std::function<void(const LoadProgram&, const OutputState&)> on_output;
};

std::vector<LoadResult> run_campaign(const FullModel& model, const std::vector<LoadProgram>& loads,
                                     const CampaignOptions& options);

}  // namespace thermotwin::solver
