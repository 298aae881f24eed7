// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Joints at the positions of their grids.

#include <vector>

#include "solver/operation/layout.h"
#include "solver/thermal/surfaces.h"

namespace thermotwin::solver::assembly {

/// One joint at one grid node: its matrix, and where frictional heat of its two sides goes.
struct JointTerm {
  SparseMatrix matrix;
  double area = 0;
  SparseColumn slave_load, master_load;  ///< integrals of N over the area in contact
};

std::vector<JointGrid> joint_grids(const mesh::MachineMesh& mesh);

/// The joints at all nodes of their grids, in parallel. @param rules  for those with the ground, which
/// are films   @param size  of the system
/// @throws InputError for a joint that touches nowhere
std::vector<std::vector<JointTerm>> joint_terms(const mesh::MachineMesh& mesh, const std::vector<JointGrid>& grids,
                                                ElementRules rules, Eigen::Index size);

/// Frictional heat of one W at a joint: shares of both sides, sum 1 whatever the contact area is.
SparseColumn joint_source(const mesh::MachineMesh& mesh, const mesh::JointSpec& joint, const mesh::SourcePlace& place,
                          const JointTerm& term);

}  // namespace thermotwin::solver::assembly
