// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The verbs of the group `measure`: what the command line asks for, and the verbs themselves, as in options.h.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "metrology/plan/plan_options.h"
#include "tools/options.h"

namespace thermotwin::tools {

struct MeasureOptions : CommonOptions {
  std::filesystem::path file;    ///< of uncertainty: the budget; of analyse: the folder
  std::vector<double> arcs_deg;  ///< of uncertainty: the spans of continuous R-Tests in place of a budget
  double radius_mm = 190, half_width_um = 3, rate_Hz = 100, feed_deg_min = 600, plane_offset_mm = 0;
  int draws = 4000;
  std::uint64_t seed = 1;
  std::string fit = "geometric";
  std::vector<std::filesystem::path> others;  ///< of analyse: further measurement folders for one table
  std::filesystem::path record;               ///< of analyse: loads and temperatures for the result's folder
  std::string ambient;                        ///< of analyse: the temperature of the gradients
  std::string channels;  ///< of analyse: in the result's folder, "errors" or "points"; empty: by the record
};

struct MeasurePlanOptions : CommonOptions {
  std::string kind;
  std::filesystem::path case_path;
  metrology::PlanOptions plan;  ///< kind and air are set by the verb
  std::vector<double> air_C, tool_offset_mm;
  std::string mount = "spindle";
  double contact_radius_mm = 0, noise_um = 0.1, repeatability_um = 0.2;
};

struct MeasureSimulateOptions : CommonOptions {
  std::filesystem::path plan, case_path;
  std::string size;
  int mesh_order = 0;
  std::string solver = "auto";
  std::uint64_t machine_seed = 0;  ///< of perturbed parameters; 0: nominal
  std::uint64_t seed = 1;          ///< of the noise
  std::string hide;                ///< "kind:where:value"; empty: nothing
  std::vector<std::string> add;    ///< "EXX1=20": known errors from the second cycle on
  bool surface = false;            ///< heights of the table's surface
  bool no_noise = false;
  double sensor_noise_K = 0.05;
  int draws = 0;
};

void measure_simulate(const MeasureSimulateOptions& options);
void measure_plan(const MeasurePlanOptions& options);
void measure_uncertainty(const MeasureOptions& options);
void measure_arcs(const MeasureOptions& options);
void measure_analyse(const MeasureOptions& options);

}  // namespace thermotwin::tools
