// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/memory_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <sstream>
#include <sys/resource.h>
#include <unistd.h>

#include "core/error.h"

namespace thermotwin::solver {
namespace {

constexpr double usable = 0.85;      // share of the available memory that a plan may fill
constexpr double kept_free = 256e6;  // bytes for all that is not counted
constexpr double GiB = 1024.0 * 1024.0 * 1024.0;

}  // namespace

SolverChoice solver_choice(const std::string& word, const std::string& place) {
  if (word == "auto") return SolverChoice::automatic;
  if (word == "direct") return SolverChoice::direct;
  if (word == "iterative") return SolverChoice::iterative;
  throw core::InputError(place, "'" + word + "'", "auto, direct or iterative");
}

void decide(MemoryPlan& plan, SolverChoice choice, double available) {
  plan.available = available;
  const double room = std::max(0.0, usable * available - kept_free);
  const auto ask = [](LinearSolver solver, const MemoryNeed& need) {
    return solver == LinearSolver::direct ? need.direct_total() : need.iterative_total();
  };
  const auto total = [&] { return ask(plan.heat_solver, plan.heat) + ask(plan.elastic_solver, plan.elastic); };
  plan.heat_solver = plan.elastic_solver =
      choice == SolverChoice::iterative ? LinearSolver::iterative : LinearSolver::direct;
  if (choice == SolverChoice::automatic && total() > room) {
    plan.elastic_solver = LinearSolver::iterative;
    if (total() > room) plan.heat_solver = LinearSolver::iterative;
  }
  if (total() > available) {
    throw core::SolverError(
        fmt::format("memory: {:.2f} GiB are needed ({} solvers), {:.2f} GiB are available; {}", total() / GiB,
                    plan.elastic_solver == LinearSolver::direct ? "direct" : "iterative", available / GiB,
                    choice == SolverChoice::direct ? "--solver iterative or a coarser --size needs less"
                                                   : "a coarser --size needs less"));
  }
}

std::string MemoryPlan::brief() const {
  const auto word = [](LinearSolver solver) { return solver == LinearSolver::direct ? "direct" : "iterative"; };
  return fmt::format(
      "memory: {:.2f} GiB available; direct needs {:.2f} GiB (factors: elasticity {:.2f}, heat {:.2f}{}), iterative "
      "{:.2f} GiB; "
      "elasticity {}, heat {}",
      available / GiB, (heat.direct_total() + elastic.direct_total()) / GiB, elastic.factors / GiB, heat.factors / GiB,
      wide ? ", 64-bit indices" : "", (heat.iterative_total() + elastic.iterative_total()) / GiB, word(elastic_solver),
      word(heat_solver));
}

}  // namespace thermotwin::solver
