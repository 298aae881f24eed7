// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/linear/multigrid_levels.h"

#include <fmt/format.h>

#include <dlfcn.h>
#include <filesystem>
#include <mutex>
#include <string>

#include "core/error.h"
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
  // An installed program finds it from its own place; else the run path of the program or library that links this
  // one tells where it is (build folder, installed library), or LD_LIBRARY_PATH.
  std::error_code ignored;
  const std::filesystem::path installed =
      std::filesystem::read_symlink("/proc/self/exe", ignored).parent_path() / THERMOTWIN_MODULES / name;
  const bool is_installed = std::filesystem::exists(installed, ignored);
  void* module = dlopen(is_installed ? installed.c_str() : name, RTLD_NOW | RTLD_LOCAL);
  auto* build = module ? reinterpret_cast<Build>(dlsym(module, "thermotwin_multigrid_levels")) : nullptr;
  if (!build) {
    const char* error = dlerror();
    throw core::SolverError(std::string("multigrid: ") + name + " cannot be loaded (" +
                            (error != nullptr ? error : "it is not where the program is") + "); use --solver direct");
  }
  return build;
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
