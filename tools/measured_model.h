// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The reduced model that a measurement is held against.

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

/// Blanks a few temperatures that cannot be and warns of them, see compensation::blank_implausible.
void keep_plausible(compensation::Measurement& measurement, const mesh::PlausibleRange& range);

/// @param measurement  see keep_plausible  @throws InputError unless it is one of the machine
void require_measured_on(const mesh::Machine& machine, compensation::Measurement& measurement);

/// The reduced model of the verb; a measurement that does not fit is refused before any long work.
/// @param measurement  see keep_plausible  @param model  empty: made from the case
reduction::ReducedModel model_of(compensation::Measurement& measurement, const std::filesystem::path& case_path,
                                 const std::filesystem::path& model, const std::filesystem::path& out);

/// The load programs of a case (training and held-out ones), for a machine of its kind.
std::vector<solver::LoadProgram> programs_of(const solver::Case& machine_case, const mesh::Machine& machine);

/// The machine with the causes of a diagnosis marked, on a coarse mesh; empty, with a word on stderr, where it cannot
/// be meshed.
diagnosis::Scene scene_of(const mesh::Machine& machine, const diagnosis::Diagnosis& found,
                          const std::filesystem::path& cache);

}  // namespace thermotwin::tools
