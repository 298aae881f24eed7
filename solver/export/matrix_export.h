// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The affine equation of a machine as Matrix Market files, for programs that know nothing of machine.toml:
//   E x' = (A + sum_j p_j A_film_j) x + B q,   y = C x,   x in K above the machine's reference temperature.
// E.mtx (J/K), A.mtx = -K0 (W/K), A_film_NAME.mtx = -K_j for p_j = 1, B.mtx = s_k for q_k = 1, C.mtx: temperatures of
// the sensors (K), then the TCP error at one pose (um, um/m). names.toml states each parameter, input and output with
// its unit. For parameters and inputs it also states their value for a machine that stands at this pose.
// `reduce --matrices` reads the folder.

#include <filesystem>
#include <string>
#include <vector>

#include "mesh/machine/kinematics.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/full_model.h"

namespace thermotwin::solver {

struct NamedValue {
  std::string name, unit;
  double value = 0;  ///< for the standing machine, in the unit
};

/// Content of names.toml.
struct MatrixNames {
  std::vector<NamedValue> films, inputs;
  std::vector<NamedValue> outputs;  ///< without values
};
/// Names are unique and valid in a file name: "film.hall", "contact.guide.3" (grid node), "source.motor.1.1" (place,
/// grid node).
MatrixNames matrix_names(const ThermalSystem& thermal, const mesh::Machine& machine, const mesh::Pose& pose);

struct MatrixFiles {
  MatrixNames names;
  std::vector<std::string> files;
  std::vector<std::string> notes;  ///< parts of the model that the matrices do not contain
  Eigen::Index size = 0;           ///< number of unknowns
};
/// Writes all files or none, then removes D.mtx and A_film_NAME.mtx of an earlier export.
/// @param pose  of the TCP error and of the values in names.toml
/// @throws InputError (neither a sensor nor [tcp], disk full, no permission)
MatrixFiles write_matrices(const std::filesystem::path& folder, const FullModel& full, const mesh::Pose& pose);

}  // namespace thermotwin::solver
