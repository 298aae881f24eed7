// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The reduced model that a measurement is held against.

#include <filesystem>
#include <string>

#include "compensation/measurement.h"
#include "reduction/reduced_model.h"

namespace thermotwin::tools {

/// The reduced model of the verb; a measurement that does not fit is refused before any long work.
/// @param model  empty: made from the case
reduction::ReducedModel model_of(const compensation::Measurement& measurement, const std::filesystem::path& case_path,
                                 const std::filesystem::path& model, const std::filesystem::path& out);

}  // namespace thermotwin::tools
