// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The record of a virtual test as a folder. Of an R-Test: rtest.toml, points.csv, raw.csv, calibration.csv for `measure
// analyse`, loads/ (a measurement folder for its --record) and functionals.csv, the location errors of the machine
// itself in the middle of each cycle. Of a volumetric grid: grid.toml, points.csv and loads/. Of another test: a
// measurement folder with displacements at each of its poses, and mandrel/ with readings of five probes at the first of
// them. Of a run with a surface: surface/ as well, with heights of the table in the middle of each cycle.

#include <cstdint>
#include <filesystem>

#include "compensation/measurement/measurement.h"
#include "metrology/plan/plan_files.h"
#include "metrology/twin/virtual_run.h"

namespace thermotwin::metrology {

/// Distance of the two levels at which a rotation is probed, m.
inline constexpr double probe_levels = 0.1;

/// Displacements of a test that is no R-Test, beside sensors and inputs.
compensation::Measurement displacement_record(const mesh::Machine& machine, const PlanFolder& plan,
                                              const VirtualRun& run, double sensor_noise_K, std::uint64_t seed);

/// @param plan_folder  whose points.csv is copied  @param seed  of the noise
void write_record(const std::filesystem::path& folder, const std::filesystem::path& plan_folder,
                  const mesh::Machine& machine, const PlanFolder& plan, const VirtualRun& run, double sensor_noise_K,
                  std::uint64_t seed);

/// Standard deviation of one coordinate of a point of this test, m.
double std_of(const PlanFolder& plan);

}  // namespace thermotwin::metrology
