// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The reduced model that a measurement is compared with, and checks that both belong together.

#include <filesystem>
#include <string>
#include <vector>

#include "compensation/measurement/measurement.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/judge/diagnosis.h"
#include "mesh/machine/plausible_range.h"
#include "reduction/model/reduced_model.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/case.h"

namespace thermotwin::tools {

/// Blanks implausible temperatures where they are few, and warns of them; see compensation::blank_implausible.
void keep_plausible(compensation::Measurement& measurement, const mesh::PlausibleRange& range);

/// @param measurement  see keep_plausible  @throws InputError if its channels do not fit the machine
void require_measured_on(const mesh::Machine& machine, compensation::Measurement& measurement);

/// The reduced model that a verb works with. A measurement that does not fit is refused before any long work.
/// @param measurement  see keep_plausible  @param model  empty: made from the case
reduction::ReducedModel model_of(compensation::Measurement& measurement, const std::filesystem::path& case_path,
                                 const std::filesystem::path& model, const std::filesystem::path& out);

/// The load programs of a case (training and held-out ones), read for a machine with the case's channels.
std::vector<solver::LoadProgram> programs_of(const solver::Case& machine_case, const mesh::Machine& machine);

/// The machine with the causes of a diagnosis marked, on a coarse mesh. The scene is empty, with a message on stderr,
/// where the machine cannot be meshed.
diagnosis::Scene scene_of(const mesh::Machine& machine, const diagnosis::Diagnosis& found,
                          const std::filesystem::path& cache);

}  // namespace thermotwin::tools
