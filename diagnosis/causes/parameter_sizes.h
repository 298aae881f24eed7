// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// How far material data and stiffnesses of a machine are from those of the machine that a reduced
// model was made of: the factors of reduction::Parts.

#include <Eigen/Core>

#include "mesh/machine/machine.h"
#include "reduction/model/reduced_model.h"
#include "solver/operation/layout.h"

namespace thermotwin::diagnosis {

/// One an item of the machine (capacity: bodies, then volumes): factors less 1, logarithms of stiffness ratios.
struct PartChanges {
  Eigen::VectorXd capacity, bodies, scales, screws, stiffness;
  bool differs_in_rows(const PartChanges& other) const;
};
PartChanges part_changes(const mesh::Machine& base, const mesh::Machine& machine);
/// What multiplies the derivatives by ln k.
Eigen::VectorXd stiffness_amounts(const reduction::Parts& parts, const PartChanges& changes);

/// Sources that a machine has beyond those of the machine that a reduced model was made of: each on one of the
/// model's patches. @throws InputError where one is elsewhere
struct AddedSources {
  solver::Layout layout;   ///< of the machine
  Eigen::MatrixXd inputs;  ///< (r x added) the columns that its inputs have at the end
};
AddedSources added_sources(const reduction::ReducedModel& model, const mesh::Machine& machine);

/// The reduced model of another machine: capacity, output rows and parts as its material data and
/// stiffnesses want them, inputs of added sources (all else follows from the machine's own coefficients). Without
/// parts, only the machine is another. The capacity of the result need not be the identity.
reduction::ReducedModel model_of_changed(const reduction::ReducedModel& model, const mesh::Machine& machine);

}  // namespace thermotwin::diagnosis
