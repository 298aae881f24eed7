// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The verbs of the group `measure`: what the command line asks for, and the verbs themselves, as in options.h.

#include <filesystem>

#include "tools/options.h"

namespace thermotwin::tools {

struct MeasureOptions : CommonOptions {
  std::filesystem::path file;  ///< the budget
};

void measure_uncertainty(const MeasureOptions& options);

}  // namespace thermotwin::tools
