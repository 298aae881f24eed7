// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Computes units of a study. On the full model, all variants of a unit are columns of one block. They share the mesh,
// one factor as preconditioner, the output rows and each pass over the matrices. Every variant is iterated to its own
// residual, so the result equals that of separate runs to the tolerance of the iteration. With the adaptive scheme, and
// on a reduced model, each variant is a run of its own. A reduced model applies material data and stiffnesses through
// its parts.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "reduction/model/reduced_model.h"
#include "solver/campaign/full_model.h"
#include "study/plan/design.h"
#include "study/units/resources.h"
#include "study/variants/variant_unit.h"

namespace thermotwin::study {

struct RunnerOptions {
  std::filesystem::path cache;  ///< of meshes
  solver::SolverChoice solver = solver::SolverChoice::automatic;
  const reduction::ReducedModel* reduced = nullptr;  ///< instead of the full model; must outlive the runner
  double checkpoint_s = 60;                          ///< wall clock seconds between two checkpoints
  double tolerance = 1e-11;                          ///< of the iteration, as a campaign's
  int recycled = 8;                                  ///< see solver::IntegratorOptions
};

class VariantRunner {
public:
  /// All must outlive the runner.
  VariantRunner(const StudyPlan& plan, const Design& design, RunnerOptions options);
  ~VariantRunner();

  /// Computes the unit and writes its tables into the folder. A stopped block continues from its checkpoint there.
  /// @throws MeshError, SolverError for variants that cannot be computed; InputError for a folder that cannot be
  ///   written, or a block that exceeds the memory; Interrupted
  UnitFiles run(const VariantUnit& unit, const std::filesystem::path& folder);

  /// Nodes of the mesh that was used last; 0: none was.
  Eigen::Index nodes() const;

private:
  std::vector<VariantTables> on_full_model(const VariantUnit& unit, const std::filesystem::path& checkpoint_path);
  std::vector<VariantTables> on_reduced_model(const VariantUnit& unit);

  const StudyPlan& plan_;
  const Design& design_;
  RunnerOptions options_;
  std::string said_;  // of the unit that was computed last; said once its files are there
  struct Full;
  std::unique_ptr<Full> full_;  ///< of the matrices that were used last
};

/// Estimated size of the unit's tables on disk, bytes.
double disk_need(const StudyPlan& plan, const VariantUnit& unit);

/// Of the unit among these that needs most on the full model. Meshes each size that they have.
MemoryWanted memory_need(const StudyPlan& plan, const std::vector<VariantUnit>& units,
                         const std::vector<std::size_t>& pending, const RunnerOptions& options);

}  // namespace thermotwin::study
