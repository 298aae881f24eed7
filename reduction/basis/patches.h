// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Pieces of all bodies' skins where heat may enter that no source of machine.toml explains. Boundary
// triangles are clustered about seeds that lie far apart (farthest point first, then moved to the
// middle of their clusters); a patch is what the rule of a [[surface]] picks, the box around a cluster,
// so that a machine.toml with that surface means the same on every mesh. All without chance.

#include "reduction/model/reduced_model.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/full_model.h"

namespace thermotwin::reduction {

/// @param count  of all bodies together, less where patches would be smaller than 3 cm
std::vector<Patch> surface_patches(const mesh::MachineMesh& mesh, int count);

/// Heat of 1 W spread evenly over each patch, (size x patches).
solver::SparseMatrix patch_loads(const solver::FullModel& full, const std::vector<Patch>& patches);

}  // namespace thermotwin::reduction
