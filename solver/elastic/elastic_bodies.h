// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The elastic bodies of a machine, each factorised once in its own frame, and what they answer to unit loads.

#include <Eigen/Core>

#include <memory>
#include <vector>

#include "mesh/machine_mesh.h"
#include "solver/elastic/assembly.h"
#include "solver/elastic/functionals.h"
#include "solver/elastic/model.h"
#include "solver/elastic/system.h"
#include "solver/linear/spd_solver.h"
#include "solver/thermal/memory_plan.h"

namespace thermotwin::solver {

struct ElasticBodies {
  mesh::Machine machine;
  std::vector<Eigen::Index> first_node;
  UnitFunctionals units;
  std::vector<int> elastic;         ///< bodies that are, rising
  std::vector<ElasticBody> bodies;  ///< per Machine::bodies; empty where not elastic
  std::vector<std::unique_ptr<SpdSolver>> factors;
  std::vector<BodyResponse> responses;   ///< per Machine::bodies
  std::vector<Eigen::MatrixXd> thermal;  ///< (n x units) F^T K^+ w
  ElasticModel::Summary summary;

  explicit ElasticBodies(const mesh::MachineMesh& mesh);

  Eigen::Index nodes(int body) const { return first_node[body + 1] - first_node[body]; }
  /// @throws SolverError, MeshError
  void factorise(const mesh::MachineMesh& mesh, const ElasticOptions& options);
  /// Once all units are there, fills responses and thermal.
  void solve_units();
  /// K^+ loads, (3n x m).
  Eigen::MatrixXd apply_inverse(int body, Eigen::MatrixXd loads) const;

private:
  MemoryNeed memory_need(const std::vector<SparseAnalysis>& analyses) const;
  void solve_units(int body);
};

}  // namespace thermotwin::solver
