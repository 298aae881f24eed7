// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The page of `evaluate`: which model removes how much, what it predicts, the tables.

#include <string>

#include "compensation/evaluation/result.h"
#include "tools/options.h"

namespace thermotwin::tools {

/// @return a self-contained HTML document
std::string evaluation_page(const EvaluateOptions& options, const compensation::Evaluation& evaluation);

}  // namespace thermotwin::tools
