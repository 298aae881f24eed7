// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Results of earlier runs in the folder of a study: tables that this plan does not make are moved to before/<number>.

#include <filesystem>
#include <string>
#include <vector>

#include "study/variants/variant_results.h"

namespace thermotwin::study {

/// Moves tables that the results do not have to before/1 (2, 3 ...), and warns which. @throws InputError
/// @return the tables, relative to the folder
std::vector<std::string> set_aside(const std::filesystem::path& study, const VariantStudy& results);

}  // namespace thermotwin::study
