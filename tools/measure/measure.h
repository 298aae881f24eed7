// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The verbs of the group `measure`: what the command line asks for, and the verbs themselves, as in options.h.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/options.h"

namespace thermotwin::tools {

struct MeasureOptions : CommonOptions {
  std::filesystem::path file;    ///< of uncertainty: the budget; of analyse: the folder
  std::vector<double> arcs_deg;  ///< of uncertainty: the spans of continuous R-Tests in place of a budget
  double radius_mm = 190, half_width_um = 3, rate_Hz = 100, feed_deg_min = 600, plane_offset_mm = 0;
  int draws = 4000;
  std::uint64_t seed = 1;
  std::string fit = "geometric";
  std::filesystem::path record;  ///< of analyse: loads and temperatures for the result's folder
  std::string ambient;           ///< of analyse: the temperature of the gradients
};

void measure_uncertainty(const MeasureOptions& options);
void measure_arcs(const MeasureOptions& options);
void measure_analyse(const MeasureOptions& options);

}  // namespace thermotwin::tools
