// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The heat balance of a run: the energy in J that each source, film, mount, coolant and exchange brought into the
// machine. A step of either time scheme satisfies
//   E (T1 - T0) = h (S q - K T) with T and q weighted means of its stages,
// so that, with the column sums of E, K_j and S, the stored energy equals the sum of the flows, to the residual of the
// iterations. Heat that passes between bodies cancels and is not listed.

#include <Eigen/SparseCore>

#include <string>
#include <vector>

#include "core/binary.h"
#include "solver/thermal/local_terms.h"
#include "solver/thermal/system.h"

namespace thermotwin::solver {

class HeatBalance {
public:
  HeatBalance(const mesh::Machine& machine, const ThermalSystem& system);

  /// @param start, end, mean  (size) temperatures   @param p, q  of the step, q its weighted mean
  /// @param local  change of the step by local terms (radiation, materials over temperature), or null
  void add(const Eigen::VectorXd& start, const Eigen::VectorXd& end, const Eigen::VectorXd& mean,
           const Eigen::VectorXd& p, const Eigen::VectorXd& q, double step_s, const LocalTerms::Change* local);

  /// Names of amounts() as powers, for a table of what flows between two times: stored_W, then power_W of
  /// sources, films, mounts and volumes' exchanges (into the machine) and, out of it,
  ///   coolant.ID.cooling_power_W: m c (T_return - T_inlet), what its chiller takes (Gebhardt, 5.20)
  ///   coolant.ID.SEGMENT.cooling_power_W: what the walls of a segment give to the fluid
  /// so that stored = powers - cooling of the coolants. Segments are parts of their coolant, but for what
  /// the fluid itself stores; they do not count in that sum. Nor does film.ID.power_W of a film whose ambient is a
  /// volume: what the volume gives to the bodies, within the machine.
  std::vector<std::string> columns() const;
  Eigen::VectorXd amounts() const;  ///< (columns) J since the start

  struct Item {
    std::string id;
    double heat;
  };  ///< J, into the machine
  /// Sources, films, mounts, coolants, volumes' exchanges, in the order of the machine file.
  std::vector<Item> items() const;
  double stored() const { return stored_; }          ///< J, change since the start
  double throughput() const { return throughput_; }  ///< J, sum of |heat| over all items and steps
  /// |stored - sum of the heats| over the throughput, or over what warms the machine by 1 nK where less flows.
  double gap() const;
  std::string brief() const;

  void save(core::BinaryWriter& out) const;
  void load(core::BinaryReader& in);

private:
  struct Sum {
    Eigen::SparseVector<double> of;
    int item;
  };
  Eigen::VectorXd capacity_;                    // column sums of E
  std::vector<Sum> terms_;                      // column sums of each K_j
  std::vector<std::pair<double, int>> inputs_;  // sum of each column of S, and its item
  std::vector<std::string> names_, columns_;    // of items; of items as powers
  Eigen::VectorXd heat_, sign_;                 // (items) J; -1: counted as it leaves
  struct Inner {
    std::string column;
    std::size_t term;
    double sign;  // 1: counted from the bodies
    Eigen::SparseVector<double> walls;
  };
  std::vector<Inner> inner_;  // segments, films in volumes: column sums of K_j over the bodies' rows
  Eigen::VectorXd carried_;   // (inner_) J
  int local_item_ = -1;
  double stored_ = 0, throughput_ = 0;
};

}  // namespace thermotwin::solver
