// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Unknowns beside the bodies' nodes, and their matrices: coolants, one-dimensional along their channels, and well-mixed
// volumes. A coolant's temperature is linear in each cell of a segment, with unknowns at its inlet and its outlet.
// Inflow between cells is upwind (discontinuous Galerkin of order 1, mass flow m):
//   m c [ int phi_i dT/dxi + phi_i(0) (T(0) - T_in) ].
// Along a wall of uniform temperature, the outlet of a cell errs by NTU^4 / 72 of the difference between inlet and
// wall. T_in is the mean of the upstream segments, weighted by their flows. The flow matrix G has G + G^T >= 0, because
// inflow and outflow of a segment are equal. A wall point at s along the path exchanges heat with the fluid at s.
// Without a path, all cells exchange heat with the whole wall.

#include <vector>

#include "mesh/machine/flow_network.h"
#include "mesh/machine_mesh.h"
#include "solver/thermal/elements.h"
#include "solver/thermal/surfaces.h"

namespace thermotwin::solver {

class FluidNodes {
public:
  /// @param first  number of the first of them
  FluidNodes(const mesh::Machine& machine, Eigen::Index first);

  int count() const { return count_; }
  int volume(int item) const { return first_volume_ + item; }
  /// Heat capacity of each, J/K: those of a cell take half of it each.
  std::vector<double> capacities() const;

  using Triplets = std::vector<Eigen::Triplet<double, int>>;
  /// For a flow of 1 kg/s in the circuit, a film coefficient of 1 W/(m^2 K) on the wall.
  void add_flow(int coolant, Triplets& triplets) const;
  void add_wall(const mesh::MachineMesh& mesh, int coolant, int segment, Triplets& triplets) const;
  /// Heat into the unknowns from an inlet 1 K warmer, W at 1 kg/s.
  SparseColumn inlet(int coolant) const;
  /// Temperature of the mixed return, as weights of unknowns.
  SparseColumn outflow(int coolant) const;

private:
  int node(int coolant, int segment, int cell, int end) const;

  const mesh::Machine& machine_;
  std::vector<std::vector<int>> first_node_;  // of each coolant's segments
  std::vector<mesh::FlowNetwork> networks_;
  int first_ = 0, first_volume_ = 0, count_ = 0;
};

}  // namespace thermotwin::solver
