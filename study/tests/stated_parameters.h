// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The values of machine.toml that have a std_percent, as parameters that a test shall tell.

#include <string>
#include <vector>

#include "mesh/machine/machine.h"
#include "study/placement/responses.h"

namespace thermotwin::study {

/// @param with_parts  whether capacities, expansions and stiffnesses count too: the reduced model then needs parts
/// @return powers, films, contacts, flows, volumes, capacities, expansions and stiffnesses, in the order of the kinds
std::vector<UncertainParameter> stated_parameters(const mesh::Machine& machine, bool with_parts);

/// @param names  "kind:where" as in diagnosis.json; empty: all
/// @throws InputError for a name that is not among them, with the nearest; if machine.toml states no std_percent
std::vector<UncertainParameter> chosen_parameters(std::vector<UncertainParameter> all,
                                                  const std::vector<std::string>& names, const mesh::Machine& machine);

/// "kind:where"
std::string key_of(const UncertainParameter& parameter);

}  // namespace thermotwin::study
