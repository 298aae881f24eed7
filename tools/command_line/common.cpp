// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/command_line/common.h"

namespace thermotwin::tools {

void add_common_options(CLI::App& verb, CommonOptions& options) {
  verb.add_option("--out", options.out, "folder for results")->capture_default_str();
  verb.add_option("--threads", options.threads, "threads (0: all cores); results do not depend on it")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  verb.add_flag("--quiet", options.quiet, "no progress on stderr");
  verb.add_flag("--json", options.json, "summary as one JSON object on stdout");
}

void add_mesh_options(CLI::App& verb, std::string& size, int& order, const std::string& order_name) {
  verb.add_option("--size", size, "mesh: coarse, standard, fine, or a factor of the element sizes");
  verb.add_option(order_name, order, "tetrahedra: 1 linear, 2 quadratic (absent: as machine.toml says)")
      ->check(CLI::Range(1, 2));
}

void add_checkpoint_option(CLI::App& verb, double& every_s) {
  verb.add_option("--checkpoint-every", every_s, "seconds of computing between checkpoints")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
}

void add_solver_option(CLI::App& verb, std::string& solver) {
  verb.add_option("--solver", solver,
                  "linear solver: direct while its factors fit into memory (auto), direct, iterative")
      ->check(CLI::IsMember({"auto", "direct", "iterative"}))
      ->capture_default_str();
}

}  // namespace thermotwin::tools
