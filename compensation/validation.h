// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Online validation: machines measured virtually (perturbed parameters, another mesh, other time
// steps, noise) run unseen load programs, the compensator runs beside them from inputs and sensors
// alone, and the TCP error before and after is compared at the check points.

#include <string>
#include <vector>

#include "compensation/virtual_measurement.h"
#include "reduction/reduced_model.h"
#include "solver/campaign.h"

namespace thermotwin::compensation {

struct ValidationOptions {
  std::vector<std::string> loads;   ///< names of load programs
  int draws = 5;
  std::uint64_t first_seed = 1;     ///< draw i perturbs and adds noise with first_seed + i
  VirtualOptions machine;           ///< mesh, steps, noise of the measured machine
};

/// RMS over time of the translations' error vector at one check point.
struct ValidationRow {
  std::string load;
  int draw = 0;
  std::string pose;
  double rms_before_um = 0;         ///< no compensation
  double rms_model_um = 0;          ///< reduced model, no temperature sensor
  double rms_sensors_um = 0;        ///< reduced model with observer
  double largest_before_um = 0, largest_sensors_um = 0;
};

struct Validation {
  std::vector<ValidationRow> rows;
  Eigen::Index measured_nodes = 0;
  /// Median over draws of the reduction of the RMS over all check points, percent.
  double median_reduction(const std::string& load, bool sensors) const;
  std::string brief() const;        ///< table per load and draw, medians last
};

/// @throws InputError if the case has no check points or a load is unknown
Validation validate_online(const solver::Case& machine_case, const reduction::ReducedModel& model,
                           const ValidationOptions& options);

/// Runs the compensator along a measurement: error of the TCP left at each displacement pose.
/// Rows of RMS for one measured load.
std::vector<ValidationRow> judge_compensation(const Measurement& measurement,
                                              const mesh::Machine& machine,
                                              const reduction::ReducedModel& model,
                                              const std::string& load, int draw);

}  // namespace thermotwin::compensation
