// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The areas of surfaces whose rules have boxes. A box takes whole triangles, by their centres, so the area of such a
// surface depends on the mesh. Cutting the triangles of the same faces at the box gives the area that was drawn.

#include <vector>

#include "mesh/machine_mesh.h"

namespace thermotwin::mesh {

/// Share of the cut area by which that of the triangles may differ without a warning.
inline constexpr double largest_area_error = 0.1;

/// @return for each surface the area in m^2 of its faces cut at the boxes of its rules; NaN without a box. A face is
///   the triangles that connect without an edge sharper than 40 deg. It takes part if one of them belongs to the
///   surface, and counts whole if all do and the box leaves out less than a tenth of it
std::vector<double> cut_areas(const MachineMesh& machine);

/// Warns of each surface whose triangles differ from its cut area by more than largest_area_error, with place, both
/// areas and the remedy.
void warn_of_box_areas(const MachineMesh& machine, const std::vector<double>& cut);

}  // namespace thermotwin::mesh
