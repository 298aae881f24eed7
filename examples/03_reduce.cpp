// SPDX-License-Identifier: GPL-3.0-or-later
// Example 3: a reduced model of a machine, and its error on a load program that it has not seen.
//
// With a basis V that is orthonormal in the heat capacity, T = V x turns the equation of all nodes into a small one of
// the same form. Films, contacts, powers and axis positions keep their meaning in it, and the TCP error is C V x.
//
// Usage: 03_reduce [CASE [MODEL]]    writes MODEL, default model.rom.h5, which examples 4 and 5 read
#include <chrono>
#include <cstdio>

#include "core/error.h"
#include "core/progress.h"
#include "reduction/basis/reduce.h"
#include "reduction/model/model_file.h"
#include "reduction/model/reduced_simulation.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/case.h"

using namespace thermotwin;

namespace {

double seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

int run(const char* folder, const char* file) {
  const solver::Case machine_case = solver::read_case(folder);
  const mesh::Machine& machine = machine_case.machine;
  mesh::MeshOptions meshing;
  meshing.size_factor = mesh::size_factor(machine, machine_case.size);
  const solver::FullModel full = solver::build_full_model(machine, meshing);

  // 1. Training data: temperatures of the full model under the training loads. No poses are named, so the TCP error is
  //    recorded at the whole grid of the workspace; reduce() judges orders by it.
  std::vector<solver::LoadProgram> loads;
  for (const std::string& name : machine_case.train) loads.push_back(machine_case.load(name));
  solver::CampaignOptions campaign;
  campaign.keep_snapshots = true;
  const std::vector<solver::LoadResult> training = solver::run_campaign(full, loads, campaign);

  // 2. The reduced model: the smallest order that keeps the tolerance on the training loads.
  reduction::ReduceOptions options;
  options.tolerance_um = machine_case.tolerance_um;
  reduction::ReduceSummary summary;
  reduction::ReducedModel model = reduction::reduce(full, loads, training, options, &summary);
  model.size = machine_case.size;
  std::printf("order %td instead of %td unknowns, %.1f s\n  order   error on the training loads, um\n",
              model.system.order(), full.thermal.size, summary.seconds());
  for (const auto& [order, error_um] : summary.order_error_um) std::printf("%7td   %.4f\n", order, error_um);

  // 3. Held-out loads, on both models.
  bool good = !machine_case.holdout.empty();
  for (const std::string& name : machine_case.holdout) {
    const solver::LoadProgram load = machine_case.load(name);
    const double start = seconds();
    const solver::LoadResult of_full = solver::run_campaign(full, {load}, {}).front();
    const double between = seconds();
    const solver::LoadResult of_reduced =
        reduction::simulate_reduced(model, machine, load, mesh::workspace_poses(machine));
    const double end = seconds();
    const reduction::ReductionErrors error = reduction::compare(of_full, of_reduced);
    std::printf("held out    %s: TCP error up to %.1f um; reduced minus full at most %.3f um, RMS %.3f um\n",
                name.c_str(), error.peak_um, error.max_um, error.rms_um);
    std::printf("            full model %.2f s, reduced model %.2f s\n", between - start, end - between);
    model.errors.push_back(error);  // the file states them, and the compensator's std contains them
    good = good && error.max_um < 0.02 * error.peak_um;
  }

  // 4. One HDF5 file, with the text of machine.toml inside.
  reduction::write_model(file, model);
  const reduction::ReducedModel read = reduction::read_model(file);
  std::printf("wrote %s\n", file);
  return good && read.system.conduction == model.system.conduction ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  core::set_quiet(true);
  try {
    return run(argc > 1 ? argv[1] : TOY_CASE, argc > 2 ? argv[2] : "model.rom.h5");
  } catch (const core::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return error.exit_status();
  }
}
