// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The verbs of `study`: their options and functions.

#include <filesystem>
#include <string>
#include <vector>

#include "tools/options.h"

namespace thermotwin::tools {

struct StudyVariantsOptions : CommonOptions {
  std::filesystem::path plan, model;
  bool reduced = false;
  bool local = false, slurm = false, gather = false;
  std::string part;  ///< "I/N"; empty: all units
  int tasks = 0;     ///< of the array job; 0: one a unit, 200 at most
  int task_threads = 2;
  double task_memory_GiB = 4, task_hours = 24;
  std::string partition, solver = "auto";
  double checkpoint_every_s = 60;
};

void study_variants(const StudyVariantsOptions& options);

}  // namespace thermotwin::tools
