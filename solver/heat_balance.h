// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Where the heat of a run came from and went to. A step of either scheme satisfies
//   E (T1 - T0) = h (S q - K T) with T and q weighted means of its stages,
// so that with the column sums of E, K_j and S what is stored equals what came in, up to what the
// iterations leave. Heat that passes between bodies cancels and is not listed.

#include <Eigen/SparseCore>
#include <string>
#include <vector>

#include "core/binary.h"
#include "solver/local_terms.h"
#include "solver/thermal_system.h"

namespace thermotwin::solver {

class HeatBalance {
 public:
  HeatBalance(const mesh::Machine& machine, const ThermalSystem& system);

  /// @param start, end, mean  (size) temperatures   @param p, q  of the step, q its weighted mean
  /// @param local  what local terms changed in the step, or null
  void add(const Eigen::VectorXd& start, const Eigen::VectorXd& end, const Eigen::VectorXd& mean, const Eigen::VectorXd& p,
           const Eigen::VectorXd& q, double step_s, const LocalTerms::Change* local);

  struct Item { std::string id; double heat; };   ///< J, into the machine
  /// Sources, films, mounts, coolants, volumes' exchanges, in the order of the machine file.
  std::vector<Item> items() const;
  double stored() const { return stored_; }       ///< J, more than at the start
  double throughput() const { return throughput_; }  ///< J, what passed through each item in each step, added up
  /// |stored - what came in| over the throughput.
  double gap() const;
  std::string brief() const;

  void save(core::BinaryWriter& out) const;
  void load(core::BinaryReader& in);

 private:
  struct Sum { Eigen::SparseVector<double> of; int item; };
  Eigen::VectorXd capacity_;                      // column sums of E
  std::vector<Sum> terms_;                        // column sums of each K_j
  std::vector<std::pair<double, int>> inputs_;    // sum of each column of S, and its item
  std::vector<std::string> names_;
  Eigen::VectorXd heat_;                          // (items) J
  int local_item_ = -1;
  double stored_ = 0, throughput_ = 0;
};

}  // namespace thermotwin::solver
