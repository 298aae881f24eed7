// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Errors of known size in a virtual test, so that its evaluation can be judged: as if the chain had got them after the
// first cycle.

#include <map>
#include <string>

#include "metrology/twin/virtual_run.h"

namespace thermotwin::metrology {

/// "EXX1=20" -> 20e-6. @throws InputError: no number behind an equals sign, beyond 1e5
std::pair<std::string, double> known_error(const std::string& text);

/// Adds the errors to the deviations of all points but those of the first cycle.
/// @param errors  SI by name, of error_terms.h @throws InputError for a name that the chain does not have
void add_known_errors(const mesh::Machine& machine, const std::vector<PlannedPoint>& points,
                      const std::map<std::string, double>& errors, VirtualRun& run);

}  // namespace thermotwin::metrology
