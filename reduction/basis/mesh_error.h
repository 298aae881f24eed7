// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// How far a mesh is from convergence, from the same loads on a second mesh. Linear tetrahedra are too stiff in bending,
// which another size of them hardly shows: they are compared with quadratic ones, whose own error is far smaller.
// Quadratic tetrahedra are compared with those of another size (Richardson). Joints touch in the mean of each pad and
// not from point to point: they are compared with joints divided twice as finely.

#include <vector>

#include "mesh/machine/machine.h"
#include "reduction/model/reduced_model.h"
#include "solver/campaign/load_result.h"

namespace thermotwin::reduction {

struct SecondMesh {
  int order = 2;        ///< of its tetrahedra
  double factor = 1.0;  ///< on the element size
};

/// Meshes to compare with, to be tried until one tells: coarser ones cost less, but walls and bores that set the size
/// themselves do not become coarser. @param order  of the tetrahedra of the first mesh
std::vector<SecondMesh> second_meshes(int order);

/// Edge length of the second mesh over that of the first, from the elements that a fixed volume has.
double edge_ratio(double elements, double elements_of_second);

/// Factor from the difference between the meshes to the error of the first: 1 of linear tetrahedra beside quadratic
/// ones, else 1 / |ratio^p - 1| with p = assumed_rate; 0: the meshes differ by too little for an estimate.
double error_of_difference(int order, int order_of_second, double ratio);

/// RMS of the differences of each channel's change since its first output, as shares, times the factor: of a sensor,
/// over the RMS of its change; of a direction of the TCP, over that of the motion in its three directions. Sensors that
/// hardly move take the median of the others; no share exceeds largest_mesh_error.
/// @param first, second  the same loads on both meshes
/// @param factor  error_of_difference of the meshes
MeshError estimate_mesh_error(const mesh::Machine& machine, const std::vector<solver::LoadResult>& first,
                              const std::vector<solver::LoadResult>& second, double factor);

/// Of two errors that are independent: the root of the sum of squares of each share, at most largest_mesh_error.
MeshError both_errors(const MeshError& one, const MeshError& other);

/// Of quadratic tetrahedra: less than in theory (4 for such functionals), since edges of contacts and of sources spoil
/// it.
inline constexpr double assumed_rate = 3.0;
inline constexpr double largest_mesh_error = 0.2;
/// Factor from the difference between joints as stated and those divided twice as finely (mesh::with_finer_pads) to the
/// error of the stated ones, which falls with the square of the pads' size.
inline constexpr double error_of_pads = 4.0 / 3.0;

}  // namespace thermotwin::reduction
