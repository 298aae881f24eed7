// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What a piece of work of bench_worker is asked for.

#include <filesystem>
#include <string>

#include "mesh/machine_mesh.h"
#include "solver/campaign/case.h"

namespace thermotwin::bench {

struct Options {
  std::string case_path = "cases/vmc5", size = "coarse", body = "column", set = "ambient", load;
  std::filesystem::path folder, model, out;
  int steps = 100, threads = 1, decks = 6, columns = 1, order = 0;
  long rows = 100000;
  bool apart = false, wall = false, cold = false;
};

/// The case, and its mesh of the size that was asked for.
struct Setup {
  solver::Case machine_case;
  double factor;
  explicit Setup(const Options& options)
      : machine_case(solver::read_case(options.case_path)),
        factor(mesh::size_factor(machine_case.machine, options.size)) {}
  mesh::MachineMesh mesh(const Options& options) const {
    return mesh::build_machine_mesh(machine_case.machine, {factor, options.folder / "cache"});
  }
};

}  // namespace thermotwin::bench
