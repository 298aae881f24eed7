// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Steps that several verbs share: the case with its size, the full model with its mesh cache, the
// campaign, the reduced model with its errors on held-out loads.

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "reduction/basis/error_estimate.h"
#include "reduction/basis/off_grid.h"
#include "reduction/basis/reduce.h"
#include "reduction/bound/error_bound.h"
#include "reduction/model/reduced_model.h"
#include "reduction/model/reduced_simulation.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/case.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"
#include "tools/options.h"

namespace thermotwin::tools {

struct Stopwatch {
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); }
};

/// Largest resident memory of this process so far, GiB.
double peak_memory_GiB();

/// What a verb computes: temperatures, and displacements of elastic bodies; or the TCP error.
enum class Asked { heat, tcp_error };

/// The case with the size (empty: its own) and the order of tetrahedra (0: its own) asked for on the
/// command line. @throws InputError where the TCP error is asked of a machine without [tcp]
solver::Case open_case(const std::filesystem::path& path, const std::string& size, int mesh_order,
                       Asked asked = Asked::tcp_error);

/// Makes the folder for results. @throws InputError before any work is lost
void require_writable(const std::filesystem::path& out);

solver::FullModel build(const solver::Case& machine_case, const std::filesystem::path& out,
                        const std::string& solver = "auto");

std::vector<solver::LoadProgram> load_programs(const solver::Case& machine_case, const std::vector<std::string>& names);

/// A held-out load at one pose: what the error may be and what it is, translations.
struct BoundedLoad {
  std::string load, pose;
  double peak_um = 0, error_um = 0, bound_um = 0;  ///< largest of the load
  double remainder_um = 0;                         ///< of the bound: what U's own error may be
  double least_ratio = 0,
         median_ratio = 0;  ///< bound over error of single outputs, where the error is 1 % of its largest
  double seconds = 0;
};

struct ReducedCase {
  reduction::ReducedModel model, reference;  ///< reference: of larger order, for error estimates
  std::optional<reduction::BoundModel> bound;
  std::vector<BoundedLoad> bounded;
  double bound_seconds = 0;                           ///< to make it
  std::vector<reduction::Effectivity> effectivities;  ///< of the estimates, one a held-out load
  reduction::ReduceSummary summary;
  std::vector<mesh::Pose> off_grid_poses;          ///< between the stored ones, at random
  std::vector<reduction::OffGridErrors> off_grid;  ///< one a held-out load
  std::vector<reduction::SensorError> sensors;     ///< of the held-out loads, one load after another
  double campaign_seconds = 0;
  std::size_t loads = 0, poses = 0;
  std::string largest_load;  ///< that with the largest TCP error of the campaign
};

/// Campaign on the training and held-out loads, reduction, errors on the held-out ones; writes
/// model.rom.h5, reference.rom.h5, off_grid.csv and the campaign's tables. The tolerance is the case's.
/// @param bounded  poses to bound the error at: bound.rom.h5 is made too
ReducedCase make_reduced_model(const solver::FullModel& full, const solver::Case& machine_case,
                               const reduction::ReduceOptions& wanted, bool resume, const std::filesystem::path& out,
                               const std::vector<mesh::Pose>& bounded = {});

/// Bound and error of each load at each pose of the bound that the campaign has. @param full  of the loads
std::vector<BoundedLoad> evaluate_bound(const reduction::ReducedModel& model, const reduction::BoundModel& bound,
                                        const mesh::Machine& machine, const std::vector<solver::LoadProgram>& loads,
                                        const std::vector<solver::LoadResult>& full);
std::string bound_table(const ReducedCase& made);

/// Rows of a tcp table at one pose, in order of time; none if the pose is not one of the table's.
std::vector<Eigen::Index> rows_at(const std::vector<mesh::Pose>& poses, const mesh::Pose& pose, Eigen::Index rows);

/// Warns of chillers and films that follow the machine's own temperatures: the bound takes theirs from the
/// reduced run, and a full run has slightly others.
void tell_what_no_bound_covers(const mesh::Machine& machine);

/// Order against error on the training loads, with the held-out ones, as SVG.
void write_order_picture(const std::filesystem::path& file, const ReducedCase& made, double tolerance_um);

/// The model of --model, or one made from the case.
reduction::ReducedModel model_for(const std::filesystem::path& case_path, const std::filesystem::path& model,
                                  const std::filesystem::path& out);

/// Table of held-out errors for the terminal, at the stored poses and between them.
std::string error_table(const ReducedCase& made);

}  // namespace thermotwin::tools
