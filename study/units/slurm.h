// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Batch scripts for Slurm: an array job that computes the units, and a gathering job that runs after it whatever became
// of its tasks (afterany) and names what is missing. A task may be requeued: it goes on from its checkpoint. Neither
// accounting nor `sbatch --wait` is needed.

#include <filesystem>
#include <string>

namespace thermotwin::study {

struct SlurmJob {
  std::string name;     ///< of the study
  std::string command;  ///< the program for all hosts and its words, quoted for a shell, up to --part or --gather
  std::filesystem::path folder;  ///< for scripts and logs, absolute, shared by all hosts
  int tasks = 1;                 ///< of the array
  int threads = 1;               ///< a task
  double memory_GiB = 2;         ///< a task
  double hours = 24;             ///< time limit of a task
  std::string partition;         ///< empty: the cluster's default
};

/// The array job: task I computes part I of `tasks`.
std::string array_script(const SlurmJob& job);
/// The gathering job.
std::string gather_script(const SlurmJob& job);
/// Submits both from its own folder; needs sbatch.
std::string submit_script();

/// Writes array.sbatch, gather.sbatch and submit.sh. @throws InputError
void write_slurm(const SlurmJob& job);

}  // namespace thermotwin::study
