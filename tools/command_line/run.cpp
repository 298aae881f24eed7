// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"
#include "tools/options.h"

namespace thermotwin::tools {

void add_run(CLI::App& app) {
  const auto options = std::make_shared<RunOptions>();
  RunOptions& run = *options;
  CLI::App* verb = add_verb(
      app, "run",
      "Runs the whole chain of a case: mesh, campaign, reduced model, compensation of a held-out load, diagnosis.",
      "thermotwin run cases/vmc5 --out out", options, &tools::run);
  verb->add_option("CASE", run.case_path, "Case folder or case.toml.")->required();
  add_mesh_options(*verb, run.size, run.mesh_order);
  add_solver_option(*verb, run.solver);
  verb->add_flag("--resume", run.resume, "Continue an interrupted run with the same inputs.");
}

}  // namespace thermotwin::tools
