// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/units/slurm.h"

#include <fmt/format.h>

#include <cmath>

#include "core/file.h"

namespace thermotwin::study {
namespace {

namespace fs = std::filesystem;

/// A value behind #SBATCH: spaces and # are its own, and % begins no pattern.
std::string quoted(const std::string& text) {
  std::string made = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\' || c == '%') made += c == '%' ? '%' : '\\';
    made += c;
  }
  return made + "\"";
}

std::string time_limit(double hours) {
  const long minutes = std::max(1L, std::lround(60.0 * hours));
  return fmt::format("{}-{:02}:{:02}:00", minutes / 1440, minutes % 1440 / 60, minutes % 60);
}

/// @param log  its name below the folder; may hold a pattern
std::string head(const SlurmJob& job, const std::string& what, const std::string& log) {
  std::string text = "#!/bin/bash\n";
  const auto option = [&](const std::string& words) { text += "#SBATCH " + words + "\n"; };
  option("--job-name=" + quoted(job.name + "_" + what));
  option("--output=" + quoted(job.folder.string()) + "/" + log);
  option("--open-mode=append");
  option("--ntasks=1");
  option(fmt::format("--cpus-per-task={}", job.threads));
  option(fmt::format("--mem={}M", static_cast<long>(std::ceil(1024.0 * job.memory_GiB))));
  option("--time=" + time_limit(job.hours));
  if (!job.partition.empty()) option("--partition=" + quoted(job.partition));
  return text;
}

}  // namespace

std::string array_script(const SlurmJob& job) {
  std::string text = head(job, "units", "task_%a.log");
  text += fmt::format("#SBATCH --array=0-{}\n", job.tasks - 1);
  text += "#SBATCH --requeue\n";
  text += "#SBATCH --signal=B:USR1@120\n";
  text +=
      "# USR1 comes 2 min before the time limit: the checkpoint is written and the task goes back to the queue.\n"
      "# TERM (scancel, a node that is drained) writes the checkpoint too; Slurm itself requeues where it has to.\n";
  text += fmt::format("{} --part \"$SLURM_ARRAY_TASK_ID/{}\" --threads \"${{SLURM_CPUS_PER_TASK:-{}}}\" --quiet &\n",
                      job.command, job.tasks, job.threads);
  text +=
      "program=$!\n"
      "trap 'kill -TERM $program; wait $program; scontrol requeue "
      "\"${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}\"; exit 0' USR1\n"
      "trap 'kill -TERM $program; wait $program; exit 143' TERM\n"
      "wait $program\n"
      "status=$?\n"
      "# Killed from outside: again, three times at most. The gathering job names what is still missing.\n"
      "if [ $status -gt 130 ] && [ \"${SLURM_RESTART_COUNT:-0}\" -lt 3 ]; then\n"
      "  scontrol requeue \"${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}\"\n"
      "fi\n"
      "exit $status\n";
  return text;
}

std::string gather_script(const SlurmJob& job) {
  std::string text = head(job, "gather", "gather.log");
  text += "#SBATCH --requeue\n";
  text += fmt::format("exec {} --gather --threads \"${{SLURM_CPUS_PER_TASK:-{}}}\"\n", job.command, job.threads);
  return text;
}

std::string submit_script() {
  return "#!/bin/bash\n"
         "# Submits the units of the study and, after them, the job that gathers what they left.\n"
         "set -euo pipefail\n"
         "if ! command -v sbatch >/dev/null; then\n"
         "  echo 'no Slurm here: sbatch is not found; submit on a login node, or use --local' >&2\n"
         "  exit 3\n"
         "fi\n"
         "cd \"$(dirname \"$0\")\"\n"
         "array=$(sbatch --parsable array.sbatch)\n"
         "array=${array%%;*}\n"
         "gather=$(sbatch --parsable --dependency=\"afterany:$array\" gather.sbatch)\n"
         "echo \"units: job $array; gathering: job ${gather%%;*}\"\n";
}

void write_slurm(const SlurmJob& job) {
  core::write_files_by(job.folder, [&](const fs::path& staged) {
    core::write_file(staged / "array.sbatch", array_script(job));
    core::write_file(staged / "gather.sbatch", gather_script(job));
    core::write_file(staged / "submit.sh", submit_script());
    return std::vector<fs::path>{"array.sbatch", "gather.sbatch", "submit.sh"};
  });
}

}  // namespace thermotwin::study
