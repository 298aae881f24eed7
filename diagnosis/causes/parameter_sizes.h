// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The differences in material data and stiffnesses between a machine and the one that a reduced model was made of, as
// factors of reduction::Parts.

#include <Eigen/Core>

#include "mesh/machine/machine.h"
#include "reduction/model/reduced_model.h"
#include "solver/operation/layout.h"

namespace thermotwin::diagnosis {

/// One value per item of the machine (capacity: bodies, then volumes): factors minus 1, logarithms of stiffness ratios.
struct PartChanges {
  Eigen::VectorXd capacity, bodies, scales, screws, stiffness;
  bool differs_in_rows(const PartChanges& other) const;
};
PartChanges part_changes(const mesh::Machine& base, const mesh::Machine& machine);
/// @return the factors on the derivatives with respect to ln k
Eigen::VectorXd stiffness_amounts(const reduction::Parts& parts, const PartChanges& changes);

/// The sources that a machine has in addition to the one that a reduced model was made of, each on a patch of the
/// model.
/// @throws InputError for a source at another place
struct AddedSources {
  solver::Layout layout;   ///< of the machine
  Eigen::MatrixXd inputs;  ///< (r x added) further columns of the inputs
};
AddedSources added_sources(const reduction::ReducedModel& model, const mesh::Machine& machine);

/// @return the reduced model of a changed machine, with its capacity, output rows, parts and inputs of added sources.
///   Everything else follows from the machine's coefficients. Without parts, only the machine differs. The capacity of
///   the result need not be the identity.
reduction::ReducedModel model_of_changed(const reduction::ReducedModel& model, const mesh::Machine& machine);

}  // namespace thermotwin::diagnosis
