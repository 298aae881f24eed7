// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// ISO 230-3 tests of `measure analyse`: the table of one measurement folder, or one table of several.

#include <string>

#include "tools/measure/measure.h"

namespace thermotwin::tools {

/// Ranges and gradients of options.file, in OUT/thermal_table.json.
void analyse_thermal(const MeasureOptions& options);

/// One table of options.file and options.others, a row for each displacement and a column for each test, in
/// OUT/thermal_tests.json and .csv. @throws InputError for a folder without channels.toml
void analyse_thermal_tests(const MeasureOptions& options);

/// Warns of results of another kind of test in OUT, which this one does not replace. @param own  file of this one
void warn_of_other_results(const MeasureOptions& options, const std::string& own);

}  // namespace thermotwin::tools
