// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/study/cluster.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "core/error.h"
#include "core/file.h"
#include "core/folder_guard.h"
#include "core/folder_lock.h"
#include "core/progress.h"
#include "core/quoted.h"
#include "core/text.h"
#include "solver/linear/available_memory.h"
#include "study/units/slurm.h"
#include "tools/chain.h"
#include "tools/page.h"

namespace thermotwin::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int most_tasks = 200;
constexpr std::size_t most_shown = 24;

/// Of the units that are left.
struct Needs {
  std::vector<std::size_t> pending;
  double disk_bytes = 0;
  study::MemoryWanted memory;
};

Needs needs_of(const ClusterOptions& cluster, const UnitStudy& study) {
  Needs needs;
  needs.pending = study::pending_units(study.folder, study.units, study::part_of(cluster.part));
  if (needs.pending.empty()) return needs;
  for (const std::size_t u : needs.pending) needs.disk_bytes += study.disk_bytes(u);
  needs.memory = study.memory(needs.pending);
  return needs;
}

/// Before the first unit. Tasks of an array job have --task-memory each.
void require_resources(const ClusterOptions& cluster, const UnitStudy& study) {
  const Needs needs = needs_of(cluster, study);
  if (needs.pending.empty()) return;
  study::require_disk(study.folder, needs.disk_bytes);
  if (cluster.slurm)
    study::require_memory(needs.memory, "--task-memory", study::GiB * cluster.task_memory_GiB);
  else
    study::require_memory(needs.memory, study.origin.string(), solver::available_memory());
}

void print_dry_run(const CommonOptions& options, const UnitStudy& study, const Needs& needs) {
  const std::size_t all = study.units.size(), left = needs.pending.size();
  std::vector<std::string> words;
  for (const std::size_t u : needs.pending) words.push_back(study.units[u].words);
  const double disk = needs.disk_bytes / study::GiB, free = study::free_disk(study.folder) / study::GiB;
  const double memory = needs.memory.bytes / study::GiB, available = solver::available_memory() / study::GiB;
  std::string text = fmt::format("{} of {} units are to be computed, {} are done\n", left, all, all - left);
  for (std::size_t k = 0; k < std::min(left, most_shown); ++k) text += "  " + words[k] + "\n";
  if (left > most_shown) text += fmt::format("  and {} more\n", left - most_shown);
  if (left > 0) {
    text += fmt::format("tables need {:.2g} GiB of disk, {:.3g} GiB are free\n", disk, free);
    text += memory > 0 ? fmt::format("{} need {:.2g} GiB of memory at least, {:.3g} GiB are available here\n",
                                     needs.memory.words, memory, available)
                       : "the memory that they need is not known\n";
  }
  const json summary = {{"units", all},
                        {"done", all - left},
                        {"to_compute", words},
                        {"disk_GiB", disk},
                        {"free_disk_GiB", std::isfinite(free) ? json(free) : json()},
                        {"memory_GiB", memory > 0 ? json(memory) : json()},
                        {"available_memory_GiB", available}};
  print_summary(options, text, summary.dump());
}

void write_scripts(const CommonOptions& options, const ClusterOptions& cluster, const UnitStudy& study) {
  study::SlurmJob job;
  job.name = study.folder.filename().string();
  job.command = core::shell_word(fs::read_symlink("/proc/self/exe")) + " " + study.command + " --out " +
                core::shell_word(fs::absolute(options.out));
  job.folder = fs::absolute(study.folder / "slurm");
  job.tasks = std::min<std::size_t>(study.units.size(), cluster.tasks > 0 ? cluster.tasks : most_tasks);
  job.threads = cluster.task_threads;
  job.memory_GiB = cluster.task_memory_GiB;
  job.hours = cluster.task_hours;
  job.partition = cluster.partition;
  study::write_slurm(job);
  const fs::path submit = job.folder / "submit.sh";
  if (std::system("command -v sbatch >/dev/null 2>&1") != 0)
    core::warn("sbatch is not found here: the scripts are for a host with Slurm that shares " + job.folder.string());
  print_summary(options,
                fmt::format("{} units in {} tasks; submit them: bash {}\n", study.units.size(), job.tasks,
                            core::shell_word(submit)),
                json({{"units", study.units.size()}, {"tasks", job.tasks}, {"submit", submit.string()}}).dump());
}

void require_some(const UnitStudy& study, const study::Work& work) {
  if (work.computed + work.kept > 0 || work.failed.empty()) return;
  const std::string none = "nothing can be computed: " + work.failed.front();
  if (work.unsolved) throw core::SolverError(study.origin.string() + ": " + none);
  throw core::InputError(study.origin.string(), none, "a machine that can be meshed and solved");
}

}  // namespace

void open_study(const ClusterOptions& cluster, const fs::path& folder, const fs::path& origin) {
  if (cluster.gather && !fs::exists(folder / study::origin_note)) {
    throw core::InputError(folder.string(), "no study was begun here, so there is nothing to gather",
                           "the --out that the units were computed in; is it mounted?");
  }
  if (cluster.dry_run) {
    study::require_folder_of(folder, origin);
    return;
  }
  require_writable(folder);
  study::claim_folder(folder, origin);
}

void carry_out(const CommonOptions& options, const ClusterOptions& cluster, const UnitStudy& study) {
  if (cluster.dry_run) return print_dry_run(options, study, needs_of(cluster, study));
  const Stopwatch time;
  const core::FolderGuard guard(options.out, study.folder / study::origin_note);
  if (!cluster.gather) require_resources(cluster, study);
  if (cluster.slurm) return write_scripts(options, cluster, study);
  if (const auto stale = study::stale_units(study.folder, study.units); !stale.empty()) {
    core::warn(fmt::format("{} units in {} belong to another plan, machine, model or version; they are not used",
                           stale.size(), (study.folder / "units").string()));
  }
  std::optional<core::FolderLock> lock;  // the tasks of an array lock their units only
  if (cluster.part.empty()) lock.emplace(study.folder);
  study::Work work;
  if (!cluster.gather) {
    work = study::compute(study.folder, study.units, study::part_of(cluster.part), study.compute);
    require_some(study, work);
  }
  if (cluster.part.empty()) return study.gather(work);
  const json summary = {{"units", study.units.size()}, {"computed", work.computed}, {"kept", work.kept},
                        {"failed", work.failed},       {"seconds", time.seconds()}, {"peak_GiB", peak_memory_GiB()}};
  print_summary(options,
                fmt::format("part {}: {} units computed, {} done before, {} failed\n", cluster.part, work.computed,
                            work.kept, work.failed.size()),
                summary.dump());
}

bool is_local(const ClusterOptions& cluster) {
  return !cluster.slurm && !cluster.gather && !cluster.dry_run && cluster.part.empty();
}

void require_none_missing(const UnitStudy& study, const std::vector<std::string>& missing) {
  if (missing.empty()) return;
  throw core::InputError(
      study.folder.string(),
      fmt::format("{} of {} units have no result: {}", missing.size(), study.units.size(), core::join(missing, "; ")),
      "all units done; submit the study again, or compute them with --local");
}

void require_none_failed(const UnitStudy& study, const study::Standing& standing) {
  if (standing.failed.empty()) return;
  throw core::SolverError(fmt::format("{}: {} of {} units could not be computed, reasons in {}: {}",
                                      study.origin.string(), standing.failed.size(), study.units.size(),
                                      (study.folder / "failures.csv").string(),
                                      core::join(study::failed_words(study.units, standing), "; ")));
}

void write_failures(const UnitStudy& study, const study::Standing& standing) {
  const fs::path file = study.folder / "failures.csv";
  std::error_code ignored;
  if (standing.failed.empty()) {
    fs::remove(file, ignored);
    return;
  }
  std::string text = "unit,what,reason\n";
  for (const auto& [u, reason] : standing.failed)
    text += fmt::format("{},{},{}\n", study.units[u].id, core::csv_cell(study.units[u].words), core::csv_cell(reason));
  core::write_file(file, text);
}

}  // namespace thermotwin::tools
