// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Machines that are measured virtually, one a seed: the full model of perturbed parameters on another
// mesh by another time scheme, or, where many are wanted, a reduced model of larger order with perturbed
// coefficients, stepped by matrix exponentials (its mesh, capacities and output rows are then those of the
// model that is judged: an easier truth). Full runs are kept in a folder and found again, so that a stopped
// study goes on.

#include <filesystem>
#include <optional>
#include <string>

#include "compensation/measurement/virtual_measurement.h"
#include "reduction/model/reduced_model.h"
#include "solver/campaign/case.h"
#include "solver/campaign/full_model.h"

namespace thermotwin::compensation {

class MeasuredMachines {
public:
  /// @param reference  truth instead of the full model; nullptr: the full model. Must outlive this
  /// @param keep       folder of measurements, <load>/machine_<seed>; full runs are found again; empty: none
  MeasuredMachines(const solver::Case& machine_case, VirtualOptions options, std::filesystem::path keep,
                   const reduction::ReducedModel* reference);

  /// @param load_text  of the program's file: a kept run of another text is run again
  Measurement measure(std::uint64_t seed, const solver::LoadProgram& load, const std::string& load_text);
  /// Nodes of the measured machine; 0 where no full model had to be built.
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
