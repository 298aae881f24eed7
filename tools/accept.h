// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// diagnose --accept: a copy of the case with the extended machine, diagnosed again, and its gain in compensation.

#include <string>
#include <vector>

#include "compensation/measurement/measurement.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/record/diagnose_options.h"
#include "reduction/model/reduced_model.h"
#include "tools/options.h"

namespace thermotwin::tools {

/// @throws InputError where the copy would overwrite something; before any long work
void require_acceptable(const DiagnoseOptions& options);

/// Writes the copy, and says what the extended model's own diagnosis finds and how both models compensate.
/// @param diagnosis_folder  with extended/, as written  @return lines for the summary
std::string accept_extension(const DiagnoseOptions& options, const std::filesystem::path& diagnosis_folder,
                             const diagnosis::Diagnosis& diagnosed, const reduction::ReducedModel& nominal,
                             const std::vector<compensation::Measurement>& records,
                             const diagnosis::DiagnoseOptions& how);

}  // namespace thermotwin::tools
