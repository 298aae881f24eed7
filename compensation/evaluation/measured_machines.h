// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Virtually measured machines, one for each seed. The truth is the full model with perturbed parameters on another mesh
// and time scheme. For many machines it is a reduced model of larger order with perturbed coefficients, stepped by
// matrix exponentials; it shares mesh, capacities and output rows with the judged model and is an easier truth. Full
// runs are kept in a folder, so that a stopped study continues.

#include <filesystem>
#include <optional>
#include <string>

#include "compensation/measurement/virtual_measurement.h"
#include "reduction/model/reduced_model.h"
#include "solver/campaign/case.h"
#include "solver/campaign/full_model.h"

namespace thermotwin::compensation {

/// A load program of measured machines, and the text that a kept run is known by.
struct MeasuredLoad {
  solver::LoadProgram program;
  std::string text;
};

/// Everything that the measurements of a machine depend on, but for mesh and load program.
std::string words_of_measured(const solver::Case& machine_case, const VirtualOptions& options);

class MeasuredMachines {
public:
  /// @param reference  truth instead of the full model; nullptr: the full model. Must outlive this
  /// @param keep       folder of measurements, `<load>/machine_<seed>`; with full runs of earlier studies; empty: none
  MeasuredMachines(const solver::Case& machine_case, VirtualOptions options, std::filesystem::path keep,
                   const reduction::ReducedModel* reference);

  /// A kept run of another text is repeated.
  Measurement measure(std::uint64_t seed, const MeasuredLoad& load);
  /// Nodes of the measured machine; 0 if no full model was built.
  Eigen::Index nodes() const { return nodes_; }

private:
  std::string stamp(std::uint64_t seed, const std::string& load_text);

  const solver::Case& case_;
  VirtualOptions options_;
  std::filesystem::path keep_;
  const reduction::ReducedModel* reference_;
  std::string mesh_hash_;
  std::optional<solver::FullModel> full_;  ///< of the seed that was measured last
  std::uint64_t full_seed_ = 0;
  Eigen::Index nodes_ = 0;
};

}  // namespace thermotwin::compensation
