// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Tables of earlier runs in the folder of a study. Those that the present results do not contain are moved to
// before/<number>.

#include <filesystem>
#include <string>
#include <vector>

#include "study/variants/variant_results.h"

namespace thermotwin::study {

/// Moves the tables that `results` does not contain to before/1, or to the next free number, and names them in a
/// warning. @throws InputError without write permission
/// @return the moved tables, relative to `study`
std::vector<std::string> set_aside(const std::filesystem::path& study, const VariantStudy& results);

}  // namespace thermotwin::study
