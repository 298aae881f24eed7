// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A machine measured virtually: the full model on another (finer) mesh, other time steps, nominal
// parameters perturbed at random within their stated uncertainty, sensor and probe noise. What is
// tested never sees how it was made.

#include <cstdint>
#include <filesystem>
#include <random>

#include "compensation/measurement.h"
#include "solver/campaign.h"

namespace thermotwin::compensation {

/// thermal: powers, films (of coolant walls too) and contact conductances only; all: every value that is
/// stated as uncertain, also expansions, capacities and stiffnesses, which no thermometer sees.
enum class Perturb { all, thermal };

/// Standard deviations that a machine of the type is off by, at the most: what is further off is a fault.
inline constexpr double farthest_std = 2.5;

/// Multiplies every Uncertain nominal by 1 + std_percent/100 * N(0,1) (films, powers, contact
/// conductances; at least 0.2 of nominal), N within farthest_std. @param scale  factor on all standard deviations
mesh::Machine perturbed(const mesh::Machine& machine, std::uint64_t seed, double scale = 1.0, Perturb what = Perturb::all);

struct VirtualOptions {
  double size_factor = 0.7;          ///< of the measured machine's mesh
  double refine = 0.63;              ///< its time steps
  bool backward_euler = false;
  double sensor_noise_K = 0.05;
  double probe_noise_um = 0.3;
  std::uint64_t seed = 1;
  Perturb what = Perturb::all;
  std::filesystem::path mesh_cache;
};

/// Runs the load on the given full model of the perturbed machine and makes a measurement of
/// sensors, inputs and displacements dx dy dz at the poses.
Measurement measure_virtually(const solver::FullModel& perturbed_machine,
                              const solver::LoadProgram& load,
                              const std::vector<mesh::Pose>& poses, const VirtualOptions& options);

/// The same of a run that is at hand: its tcp at the poses, sensors and inputs.
Measurement measure_run(const solver::LoadResult& truth, const mesh::Machine& machine, const std::vector<mesh::Pose>& poses,
                        const VirtualOptions& options);

}  // namespace thermotwin::compensation
