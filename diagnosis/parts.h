// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What heat content and outputs owe to each part of the machine, on the basis of a reduced model. The
// capacity is a sum over bodies, the output rows are sums over the expansions of bodies, tapes and
// screws, so both are affine in material data of single bodies:
//   E = E_0 + sum_b (c_b / c_b0 - 1) E_b,   C = C_0 + sum_b (a_b / a_b0 - 1) C_b.
// With a joint's stiffness k the rows change by ln(k / k0) dC / d ln k, which is its first order.

#include <Eigen/Core>
#include <vector>

#include "mesh/machine.h"
#include "reduction/reduced_model.h"

namespace thermotwin::diagnosis {

struct Parts {
  std::vector<Eigen::MatrixXd> capacity;            ///< (bodies) (r x r) each
  /// Poses as in the model's own outputs; rows of one part each, in the order of the machine.
  std::vector<reduction::ReducedOutputs> bodies, scales, screws;
  std::vector<reduction::ReducedOutputs> stiffness; ///< (joints) per unit of ln k
};

/// How far a machine's parts are from those of a base: factors less 1, logarithms of stiffness ratios.
struct PartChanges {
  Eigen::VectorXd capacity, bodies, scales, screws, stiffness;
  bool any_rows() const;
};
PartChanges part_changes(const mesh::Machine& base, const mesh::Machine& machine);

}  // namespace thermotwin::diagnosis
