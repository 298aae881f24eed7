// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The verbs of `study`: their options and functions.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/options.h"

namespace thermotwin::tools {

/// Where the units of a study are computed.
struct ClusterOptions {
  bool local = false, slurm = false, gather = false;
  bool dry_run = false;
  std::string part;  ///< "I/N"; empty: all units
  int tasks = 0;     ///< of the array job; 0: one a unit, 200 at most
  int task_threads = 2;
  double task_memory_GiB = 4, task_hours = 24;
  std::string partition;
};

struct StudyVariantsOptions : CommonOptions {
  std::filesystem::path plan, model;
  bool reduced = false;
  ClusterOptions cluster;
  std::string solver = "auto";
  double checkpoint_every_s = 60;
};

struct StudyCampaignOptions : CampaignOptions {
  ClusterOptions cluster;
};

struct StudyValidateOptions : ValidateOptions {
  ClusterOptions cluster;
  double checkpoint_every_s = 60;
};

struct StudySensorsOptions : CommonOptions {
  std::filesystem::path case_path;
  std::string size;    ///< empty: the case's own
  int mesh_order = 0;  ///< 0: the machine's own
  std::vector<std::string> loads, bodies, without;
  int count = 0;  ///< 0: as many as the case has
  double spacing_mm = 60, noise_K = 0.05, bias_K = 0.1, every_min = 20;
  int exchanges = 3;
  bool any_loss = false, on_contacts = false, on_rotating = false;
  int confirm = 0;  ///< machines measured virtually
};

struct StudyTestsOptions : CommonOptions {
  std::filesystem::path case_path, model;
  double hours = 24, block_min = 60, interval_min = 5, every_min = 10;
  double leave_um = 0;  ///< the shortest test that leaves at most so much; 0: all hours
  std::vector<std::string> loads, programs, parameters;
  bool no_standard = false, no_programs = false, chamber = false, no_probe = false;
  std::string probe_pose;
  double probe_every_min = 60, probe_um = 0.5, bias_K = 0.1;
  int exchanges = 2, orders = 20;
  std::uint64_t seed = 1;
  int confirm = 0;  ///< machines measured virtually
};

void study_variants(const StudyVariantsOptions& options);
void study_campaign(const StudyCampaignOptions& options);
void study_validate(const StudyValidateOptions& options);
void study_sensors(const StudySensorsOptions& options);
void study_tests(const StudyTestsOptions& options);

}  // namespace thermotwin::tools
