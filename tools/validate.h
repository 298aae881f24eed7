// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The parts of `validate`: which machines are measured on full models, under which load programs, and where they are
// kept.

#include <cstdint>
#include <filesystem>
#include <vector>

#include "compensation/evaluation/measured_machines.h"
#include "compensation/evaluation/validation.h"
#include "solver/campaign/case.h"
#include "tools/options.h"

namespace thermotwin::tools {

/// @throws UsageError for more machines on full models than there are
void require_draws(const ValidateOptions& options);

/// Number of machines that are measured on full models, the first ones.
int full_draws(const ValidateOptions& options);

/// Folder of their measurements in --out.
std::filesystem::path measured_folder(const ValidateOptions& options);

compensation::ValidationOptions validation_settings(const ValidateOptions& options, const solver::Case& machine_case);

/// Load programs of the machine with this seed. @throws InputError if one is unknown
std::vector<compensation::MeasuredLoad> measured_loads(const ValidateOptions& options, const solver::Case& machine_case,
                                                       const compensation::ValidationOptions& settings,
                                                       std::uint64_t seed);

}  // namespace thermotwin::tools
