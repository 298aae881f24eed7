// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The variants of a plan. A group is a mesh size with one combination of the fixed values; all groups have the same
// draws. If nothing is drawn, the combinations are the variants of one group. The design of Saltelli (2010) has, for
// each sample, the rows A, B and, for each drawn parameter i, A with the i-th value of B.

#include <Eigen/Core>

#include <cstdint>
#include <string>
#include <vector>

#include "mesh/machine/machine.h"
#include "study/plan/plan.h"

namespace thermotwin::study {

struct Group {
  std::string name;  ///< folder of its tables: the size, with a number where values are combined
  std::string size;
  Eigen::VectorXd fixed;  ///< (parameters) value of each fixed one; NaN: differs within the group
};

struct Variant {
  std::size_t group = 0;
  Eigen::VectorXd values;  ///< (parameters) factors, or added values
};

struct Design {
  std::vector<Group> groups;
  std::vector<Variant> variants;  ///< group by group
  std::vector<int> drawn;         ///< indices of the drawn parameters
  int rows = 1;                   ///< variants of a group

  std::vector<std::size_t> of_group(std::size_t group) const;
};

/// @return shares in (0, 1), (samples x dimensions): independent, or one in each of `samples` equal intervals of every
///   dimension
Eigen::MatrixXd drawn_shares(int samples, int dimensions, std::uint64_t seed, bool latin);

/// @return the number of variants of make_design(), without making them
double variant_count(const StudyPlan& plan);

Design make_design(const StudyPlan& plan);

/// @return the machine of a variant; its text and hash are those of the case
mesh::Machine machine_of(const StudyPlan& plan, const Eigen::VectorXd& values);

}  // namespace thermotwin::study
