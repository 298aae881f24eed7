// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Virtual measurements: the full model on a finer mesh, with another time scheme than the judged models (TR-BDF2 with
// error control instead of SDIRK2 at time_step_s), parameters perturbed at random within their stated uncertainty, and
// noise of sensors and probes. The judged models see the measurement only.

#include <cstdint>
#include <filesystem>
#include <random>

#include "compensation/measurement/measurement.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"

namespace thermotwin::compensation {

/// thermal: powers, films (of coolant walls too), and conductances of contacts and volumes only; all: every value with
/// a stated uncertainty, also expansions, capacities and stiffnesses; none: the machine as stated.
enum class Perturb { all, thermal, none };

/// Whether a control is told the temperature of an ambient: of the air only.
bool is_told(const mesh::AmbientSpec& ambient);

/// Largest perturbation of a value, in its standard deviations; a larger one would be a fault.
inline constexpr double farthest_std = 2.5;

/// Multiplies every Uncertain nominal by 1 + std_percent/100 * N(0,1) (films, powers, contact
/// conductances; at least 0.2 of nominal), N within farthest_std. @param scale  factor on all standard deviations
mesh::Machine perturbed(const mesh::Machine& machine, std::uint64_t seed, double scale = 1.0,
                        Perturb what = Perturb::all);

/// Time scheme of measured machines, whatever their load programs say.
inline constexpr solver::TimeOptions measured_time{solver::TimeScheme::adaptive, 0.1, 1.0, 21600};

struct VirtualOptions {
  double size_factor = 0.7;  ///< of the measured machine's mesh
  double refine = 0.63;      ///< factor of its tolerance; of its steps where a reduced model is the truth
  solver::TimeOptions time = measured_time;
  double sensor_noise_K = 0.05;
  double probe_noise_um = 0.3;
  /// A run of the full model also records the temperature rise of each coolant segment, outflow less inflow (Mares et
  /// al. 2019, dT_cool), as channel `coolant.<id>.<segment>.rise`.
  bool coolant_rise = false;
  std::uint64_t seed = 1;
  Perturb what = Perturb::all;
  std::filesystem::path mesh_cache;
  std::filesystem::path checkpoints{};  ///< folder, for a stopped run of the full model to go on; empty: none
  double checkpoint_s = 60;             ///< wall clock seconds between two
  void validate() const;                ///< @throws InputError
};

/// Runs the load on the given full model of the perturbed machine and makes a measurement of
/// sensors, inputs and displacements dx dy dz at the poses.
Measurement measure_virtually(const solver::FullModel& perturbed_machine, const solver::LoadProgram& load,
                              const std::vector<mesh::Pose>& poses, const VirtualOptions& options);

/// The same from the results of a finished run.
Measurement measure_run(const solver::LoadResult& truth, const mesh::Machine& machine,
                        const std::vector<mesh::Pose>& poses, const VirtualOptions& options);

}  // namespace thermotwin::compensation
