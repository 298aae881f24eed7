// SPDX-License-Identifier: GPL-3.0-or-later
#include <charconv>

#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"
#include "tools/options.h"

namespace thermotwin::tools {
namespace {

/// What `reduce` asks of a case only.
void add_reduced_case(CLI::App& verb, ReduceOptions& reduce, CLI::Option& of_case) {
  verb.add_flag("--resume", reduce.resume, "Keep finished results of the campaign.")->needs(&of_case);
  auto* bound =
      verb.add_flag(
              "--bound", reduce.bound,
              "Write bound.rom.h5 as well, for guaranteed error bounds, and print the bound for the held-out loads.")
          ->needs(&of_case);
  verb.add_option("--bound-pose", reduce.bound_poses,
                  "Pose of --bound, e.g. X=0,Y=0,Z=275,B=90; may be repeated (default: middle of the workspace).")
      ->needs(bound)
      ->take_all();
  add_mesh_options(verb, reduce.size, reduce.mesh_order, "--mesh-order");
  add_solver_option(verb, reduce.solver);
  for (const char* name : {"--size", "--mesh-order", "--solver"}) verb.get_option(name)->needs(&of_case);
}

/// What it asks of matrices only.
void add_matrices(CLI::App& verb, ReduceOptions& reduce, CLI::Option& of_case) {
  auto* matrices = verb.add_option("--matrices", reduce.matrices,
                                   "Folder of A.mtx, B.mtx and C.mtx (Matrix Market), with optional E.mtx, D.mtx and "
                                   "A_film_NAME.mtx, instead of a CASE.")
                       ->excludes(&of_case);
  verb.add_option("--method", reduce.method,
                  "Method: combined (default), krylov, pod, balanced or modal for a case; balanced (default), modal or "
                  "krylov for --matrices.");
  verb.add_option("--tolerance", reduce.tolerance, "With --matrices: error bound, relative to the H-infinity norm.")
      ->check(positive_number())
      ->needs(matrices)
      ->capture_default_str();
  verb.add_flag("--absolute", reduce.absolute, "With --matrices: the tolerance is absolute.")->needs(matrices);
  verb.add_flag("--compare", reduce.compare, "Print the true errors of all methods at several orders.");
  verb.add_option("--film", reduce.films,
                  "With --matrices: NAME=VALUE[,VALUE...], factors on A_film_NAME at which bases are computed and "
                  "joined (default: 1).")
      ->needs(matrices);
}

/// What it asks of the tables of a campaign only.
void add_from_campaign(CLI::App& verb, ReduceOptions& reduce, CLI::Option& of_case) {
  auto* from = verb.add_option_function<std::string>(
                       "--from-campaign",
                       [&reduce](const std::string& folder) {
                         reduce.identify = true;
                         if (folder != "true") reduce.campaign = folder;
                       },
                       "Identify a model from the tables of a campaign in DIR, without the full model (default DIR: "
                       "campaign/ in --out).")
                   ->expected(0, 1)
                   ->type_name("[DIR]")
                   ->needs(&of_case);
  for (const char* name :
       {"--resume", "--bound", "--size", "--mesh-order", "--solver", "--matrices", "--method", "--compare"})
    from->excludes(verb.get_option(name));
}

}  // namespace

void add_reduce(CLI::App& app) {
  const auto options = std::make_shared<ReduceOptions>();
  ReduceOptions& reduce = *options;
  CLI::App* verb = add_verb(
      app, "reduce",
      "Reduces a case, or the matrices of another program, to a small state-space model and prints its errors.",
      "thermotwin reduce cases/vmc5\n"
      "  thermotwin reduce cases/vmc5 --from-campaign out/campaign --out identified\n"
      "  thermotwin reduce --matrices rail --tolerance 1e-4 --out rail_reduced\n"
      "  thermotwin reduce --matrices spindle --film air=5,50 --film oil=1 --compare",
      options, &tools::reduce);
  auto* reduced_case = verb->add_option("CASE", reduce.case_path, "Case folder or case.toml.");
  verb->add_option_function<std::string>(
          "--order",
          [&reduce](const std::string& word) {
            reduce.order_by_observer = word == "observer";
            if (reduce.order_by_observer) return;
            const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), reduce.order);
            if (error == std::errc() && end == word.data() + word.size() && reduce.order >= 0 && reduce.order <= 2000)
              return;
            throw CLI::ValidationError("--order",
                                       "'" + word + "'; allowed: a whole number from 0 to 2000, or observer");
          },
          "Order: a number; 0: the smallest within the tolerance; observer: of a case, the smallest whose error is "
          "below the standard deviation that an observer leaves.")
      ->type_name("NUMBER|observer");
  add_reduced_case(*verb, reduce, *reduced_case);
  add_matrices(*verb, reduce, *reduced_case);
  add_from_campaign(*verb, reduce, *reduced_case);
}

}  // namespace thermotwin::tools
