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

struct StudySensorsOptions : CommonOptions {
  std::filesystem::path case_path;
  std::vector<std::string> loads, bodies, without;
  int count = 0;  ///< 0: as many as the case has
  double spacing_mm = 60, noise_K = 0.05, bias_K = 0.1, every_min = 20;
  int exchanges = 3;
  bool any_loss = false, on_contacts = false, on_rotating = false;
  int confirm = 0;  ///< machines measured virtually
};

void study_variants(const StudyVariantsOptions& options);
void study_sensors(const StudySensorsOptions& options);

}  // namespace thermotwin::tools
