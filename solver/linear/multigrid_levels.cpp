// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/linear/multigrid_levels.h"

#include <fmt/format.h>

#include <mutex>
#include <string>

#include "core/error.h"
#include "core/module.h"
#include "solver/linear/available_memory.h"

namespace thermotwin::solver {
namespace {

constexpr double needed_to_load = 400e6;  // bytes, of it 200e6 libraries and 134e6 one buffer of OpenBLAS

using Build = bool (*)(const Eigen::SparseMatrix<double>&, int, const Eigen::MatrixXd&, std::vector<MultigridLevel>&,
                       std::string&);

Build load_module() {
  constexpr const char* name = "libthermotwin_petsc.so";
  // MPI's start waits without end for a thread of OpenBLAS that finds no memory.
  if (const double available = available_memory(); available < needed_to_load) {
    throw core::SolverError(fmt::format(
        "multigrid: not enough memory to load {}: {:.0f} MB are needed, {:.0f} MB are available; use --solver direct",
        name, needed_to_load / 1e6, available / 1e6));
  }
  return reinterpret_cast<Build>(
      core::module_function(name, "thermotwin_multigrid_levels", "multigrid", "use --solver direct"));
}

}  // namespace

std::vector<MultigridLevel> multigrid_levels(const Eigen::SparseMatrix<double>& spd, int block,
                                             const Eigen::MatrixXd& near_null) {
  static std::mutex mutex;  // PETSc is not made for several threads
  const std::lock_guard lock(mutex);
  static const Build build = load_module();
  std::vector<MultigridLevel> levels;
  std::string error;
  if (!build(spd, block, near_null, levels, error)) throw core::SolverError("multigrid: " + error);
  return levels;
}

}  // namespace thermotwin::solver
