// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reads case.toml with the files that it names.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "mesh/machine/machine.h"
#include "solver/operation/load_program.h"

namespace thermotwin::solver {

/// A virtual machine whose measurement is simulated if the case has none. Its hidden effect is the truth that a
/// diagnosis has to find.
struct MeasuredMachine {
  std::string load;                        ///< load program that it runs
  std::string kind, where;                 ///< effect: source_power | film_coefficient | contact_conductance
  double factor = 1.0;                     ///< ratio to nominal
  std::uint64_t seed = 7;                  ///< of perturbed parameters and noise
  double size_factor = 0.8, refine = 0.8;  ///< factors on the element sizes of its mesh and on its time steps
};

/// A case: a machine, its load programs and the options of case.toml.
struct Case {
  std::filesystem::path folder;
  mesh::Machine machine;
  std::string size = "coarse";
  std::vector<std::string> train, holdout;          ///< names of load programs
  std::filesystem::path measurement;                ///< empty if none
  std::optional<MeasuredMachine> measured_machine;  ///< [measured_machine]; used where measurement is empty
  std::vector<mesh::Pose> check_points;
  double tolerance_um = 0.1;
  std::optional<TimeOptions> time;  ///< [time]; for loads without one

  LoadProgram load(const std::string& name) const;  ///< @throws InputError with the known names
  std::vector<std::string> load_names() const;      ///< all files of loads/, sorted
};

/// Reads a case with its machine; load programs are read by Case::load(). @param path  case folder or case.toml
/// @throws InputError naming file, line and key
Case read_case(const std::filesystem::path& path);

}  // namespace thermotwin::solver
