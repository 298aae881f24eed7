// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Patches of the skins of all bodies, where heat may enter that no source of machine.toml has. Boundary triangles are
// clustered about seeds that lie far apart: each new seed is the point farthest from the others, then the seeds move to
// the middle of their clusters. A patch is the [[surface]] that a box around a cluster selects, so this surface in a
// machine.toml selects the same region on every mesh. No step is random.

#include "reduction/model/reduced_model.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/full_model.h"

namespace thermotwin::reduction {

/// @param count  number of patches on all bodies together; there are fewer if patches would be smaller than 3 cm
std::vector<Patch> surface_patches(const mesh::MachineMesh& mesh, int count);

/// Heat of 1 W spread evenly over each patch, (size x patches).
solver::SparseMatrix patch_loads(const solver::FullModel& full, const std::vector<Patch>& patches);

}  // namespace thermotwin::reduction
