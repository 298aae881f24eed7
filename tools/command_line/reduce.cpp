// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"
#include "tools/options.h"

namespace thermotwin::tools {
namespace {

/// What `reduce` asks of a case only.
void add_reduced_case(CLI::App& verb, ReduceOptions& reduce, CLI::Option& of_case) {
  verb.add_flag("--resume", reduce.resume, "keep campaign results that are finished")->needs(&of_case);
  auto* bound =
      verb.add_flag("--bound", reduce.bound,
                    "bound.rom.h5 too, for a guaranteed bound of the error at a pose; tells it for the held-out loads")
          ->needs(&of_case);
  verb.add_option("--bound-pose", reduce.bound_poses,
                  "of --bound: e.g. X=0,Y=0,Z=275,B=90, again for more (absent: the middle of the workspace)")
      ->needs(bound)
      ->take_all();
  add_mesh_options(verb, reduce.size, reduce.mesh_order, "--mesh-order");
  add_solver_option(verb, reduce.solver);
  for (const char* name : {"--size", "--mesh-order", "--solver"}) verb.get_option(name)->needs(&of_case);
}

/// What it asks of matrices only.
void add_matrices(CLI::App& verb, ReduceOptions& reduce, CLI::Option& of_case) {
  auto* matrices =
      verb.add_option("--matrices", reduce.matrices,
                      "instead of a CASE: folder of A.mtx, B.mtx, C.mtx (Matrix Market), E.mtx where it is not the "
                      "identity, D.mtx and A_film_NAME.mtx where there are any; results: the same files, reduced, "
                      "and system.rom.h5")
          ->excludes(&of_case);
  verb.add_option("--method", reduce.method,
                  "of a case: combined (absent), krylov, pod, balanced, modal; of --matrices: balanced "
                  "truncation (absent), modal truncation (dominant modes), rational krylov");
  verb.add_option("--tolerance", reduce.tolerance, "of --matrices: bound of the error, relative to the H-infinity norm")
      ->check(CLI::PositiveNumber)
      ->needs(matrices)
      ->capture_default_str();
  verb.add_flag("--absolute", reduce.absolute, "the tolerance is the bound itself")->needs(matrices);
  verb.add_flag("--compare", reduce.compare, "true errors of all methods at several orders");
  verb.add_option("--film", reduce.films,
                  "of --matrices: NAME=VALUE[,VALUE...], factor of A_film_NAME where the bases are made "
                  "(absent: 1); several values: a basis of --order for each combination, joined")
      ->needs(matrices);
}

/// What it asks of the tables of a campaign only.
void add_from_campaign(CLI::App& verb, ReduceOptions& reduce, CLI::Option& of_case) {
  auto* from =
      verb.add_option_function<std::string>(
              "--from-campaign",
              [&reduce](const std::string& folder) {
                reduce.identify = true;
                if (folder != "true") reduce.campaign = folder;
              },
              "identify a model from the tables of a campaign alone (folder of inputs.csv, sensors.csv, tcp.csv per "
              "load; "
              "absent: campaign/ in --out), without the full model; results: system.rom.h5 and E, A, B, C as .mtx")
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
  CLI::App* verb = add_verb(app, "reduce",
                            "reduced state-space model model.rom.h5 of a case, with order and error table; or, with "
                            "--matrices, of the system E x' = A x + B u, y = C x + D u of another program",
                            "thermotwin reduce cases/vmc5\n"
                            "  thermotwin reduce cases/vmc5 --from-campaign out/campaign --out identified\n"
                            "  thermotwin reduce --matrices rail --tolerance 1e-4 --out rail_reduced\n"
                            "  thermotwin reduce --matrices spindle --film air=5,50 --film oil=1 --compare",
                            options, &tools::reduce);
  auto* reduced_case = verb->add_option("CASE", reduce.case_path, "case folder or case.toml");
  verb->add_option_function<std::string>(
          "--order",
          [&reduce](const std::string& word) {
            reduce.order_by_observer = word == "observer";
            if (!reduce.order_by_observer) reduce.order = std::stoi(word);
          },
          "order of the model (0: the smallest that meets the tolerance); of a case also observer: the smallest whose "
          "error is below "
          "what an observer with the machine's sensors is unsure of")
      ->check(CLI::Range(0, 2000) | CLI::IsMember({"observer"}));
  add_reduced_case(*verb, reduce, *reduced_case);
  add_matrices(*verb, reduce, *reduced_case);
  add_from_campaign(*verb, reduce, *reduced_case);
}

}  // namespace thermotwin::tools
