// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Direct or iterative, decided before anything large is made: what the factors would take, counted
// by CHOLMOD's symbolic analysis, against what the machine or its cgroup has left.

#include <string>
#include <vector>

#include "solver/thermal/system.h"

namespace thermotwin::solver {

enum class SolverChoice { automatic, direct, iterative };
/// @param place  for the message, e.g. "--solver"  @throws InputError
SolverChoice solver_choice(const std::string& word, const std::string& place);

struct MemoryNeed {
  double factors = 0;    ///< bytes that stay
  double work = 0;       ///< bytes beside them at the worst moment
  double other = 0;      ///< matrices and dense blocks that both ways need
  double iterative = 0;  ///< multigrid in place of factors and work, roughly
  double direct_total() const { return factors + work + other; }
  double iterative_total() const { return iterative + other; }
};

struct MemoryPlan {
  double available = 0;  ///< bytes when it was made
  MemoryNeed heat, elastic;
  LinearSolver heat_solver = LinearSolver::direct, elastic_solver = LinearSolver::direct;
  bool wide = false;  ///< a factor needs 64-bit indices
  std::string brief() const;
};

/// What solving for temperatures takes; wide is set where a factor needs 64-bit indices.
MemoryNeed heat_memory_need(const ThermalSystem& system, SolverChoice choice, bool& wide);

/// Fills in available and the solvers: heat first, it is the smaller one. Automatic is direct while
/// it takes less than a share of what is available.
/// @throws SolverError: direct is asked for and cannot fit; nothing fits
void decide(MemoryPlan& plan, SolverChoice choice, double available);

}  // namespace thermotwin::solver
