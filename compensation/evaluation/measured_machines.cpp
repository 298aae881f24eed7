// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/evaluation/measured_machines.h"

#include <fmt/format.h>

#include "core/file.h"
#include "core/progress.h"
#include "mesh/machine/kinematics.h"
#include "reduction/basis/reduce.h"
#include "reduction/model/reduced_simulation.h"
#include "solver/campaign/case.h"
#include "solver/campaign/files.h"

namespace thermotwin::compensation {

namespace fs = std::filesystem;

namespace {

const char* word(Perturb what) { return what == Perturb::all ? "all" : what == Perturb::thermal ? "thermal" : "none"; }

}  // namespace

std::string words_of_measured(const solver::Case& machine_case, const VirtualOptions& options) {
  const solver::TimeOptions& time = options.time;
  std::string words = fmt::format("{} {} {} {} {}", options.size_factor, options.sensor_noise_K, options.probe_noise_um,
                                  options.seed, farthest_std);
  words += fmt::format(" {} {} {} {} {} {}", word(options.what), solver::word(time.scheme), time.tolerance_K,
                       time.shortest_step, time.longest_step, options.refine);
  if (options.coolant_rise) words += " coolant_rise";
  for (const mesh::Pose& pose : machine_case.check_points) words += " " + mesh::format_pose(machine_case.machine, pose);
  return words;
}

MeasuredMachines::MeasuredMachines(const solver::Case& machine_case, VirtualOptions options, fs::path keep,
                                   const reduction::ReducedModel* reference)
    : case_(machine_case),
      options_(std::move(options)),
      keep_(std::move(keep)),
      reference_(reference) {}

std::string MeasuredMachines::stamp(std::uint64_t seed, const std::string& load_text) {
  if (mesh_hash_.empty()) {
    const mesh::MachineMesh mesh = mesh::build_machine_mesh(case_.machine, {options_.size_factor, options_.mesh_cache});
    mesh_hash_ = solver::hash_of_mesh(mesh);
    nodes_ = mesh.nodes();
  }
  VirtualOptions options = options_;
  options.seed = seed;
  return core::content_hash(case_.machine.hash + " " + mesh_hash_ + " " + words_of_measured(case_, options) +
                            load_text) +
         "\n";
}

Measurement MeasuredMachines::measure(std::uint64_t seed, const MeasuredLoad& measured_load) {
  const solver::LoadProgram& load = measured_load.program;
  VirtualOptions options = options_;
  options.seed = seed;
  const mesh::Machine machine = perturbed(case_.machine, seed, 1.0, options.what);
  const fs::path folder = keep_ / load.name() / fmt::format("machine_{}", seed), vouch = folder / "made_from.txt";
  const bool kept = !keep_.empty() && reference_ == nullptr;
  const std::string made_from = kept ? stamp(seed, measured_load.text) : "by a reduced model\n";
  if (kept && fs::exists(vouch) && core::read_file(vouch) == made_from) return read_measurement(folder);
  Measurement measured;
  if (reference_ != nullptr) {
    reduction::ReducedRun how;
    how.refine = options.refine;
    how.exact = true;  // another scheme than the compensator's here too
    how.tell = false;
    measured = measure_run(reduction::simulate_reduced(*reference_, machine, load, case_.check_points, how), machine,
                           case_.check_points, options);
  } else {
    if (!full_ || full_seed_ != seed) {
      full_.reset();  // before the next one: two do not fit into a small memory
      full_.emplace(solver::build_full_model(machine, {options.size_factor, options.mesh_cache}));
      full_seed_ = seed;
      nodes_ = full_->mesh.nodes();
    }
    core::log_line(fmt::format("simulating the measurement of virtual machine {}, {}", seed, load.name()));
    measured = measure_virtually(*full_, load, case_.check_points, options);
  }
  if (keep_.empty()) return measured;
  core::write_files_by(folder, [&](const fs::path& staged) {
    write_measurement(staged, measured);
    core::write_file(staged / "made_from.txt", made_from);
    return std::vector<fs::path>{"data.csv", "channels.toml", "made_from.txt"};
  });
  return read_measurement(folder);
}

}  // namespace thermotwin::compensation
