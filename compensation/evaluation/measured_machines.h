// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Virtual measurements of machines, one machine per seed. The truth is the full model with perturbed parameters on
// another mesh and time scheme. For many machines it is a reduced model of larger order with perturbed coefficients,
// stepped by matrix exponentials. That is an easier test, because this model shares mesh, capacities and output rows
// with the judged one. Full runs are kept in a folder, so that a stopped study continues.

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

/// Options and check points that measurements depend on; machine, mesh and load program are not included.
std::string words_of_measured(const solver::Case& machine_case, const VirtualOptions& options);

class MeasuredMachines {
public:
  /// @param reference  truth instead of the full model; nullptr: the full model. Must outlive this
  /// @param keep       folder of measurements, LOAD/machine_SEED, also those of earlier studies; empty: none
  MeasuredMachines(const solver::Case& machine_case, VirtualOptions options, std::filesystem::path keep,
                   const reduction::ReducedModel* reference);

  /// Reads a kept full run if machine, mesh, options and load agree; else simulates.
  Measurement measure(std::uint64_t seed, const MeasuredLoad& load);
  /// Nodes of the measured machine; 0 with `reference`, and before the first measurement.
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
