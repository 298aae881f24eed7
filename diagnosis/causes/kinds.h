// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The kinds of causes.

#include <string>
#include <vector>

#include "diagnosis/causes/parameter.h"

namespace thermotwin::diagnosis {

/// The kinds that candidate_parameters knows, as README.md lists them.
struct Kind {
  std::string kind, where;        ///< what `where` refers to, in words
  std::string name, unit, sense;  ///< of its one parameter; sense "ratio" or "absolute"
  double low, high, step;         ///< bounds, step of the finite difference
};

const std::vector<Kind>& known_kinds();

/// It changes what is read, not what the machine does: no run of the model is needed.
bool acts_on_readings(const std::string& kind);

/// It changes heat that enters somewhere, and nothing else.
bool adds_heat(const std::string& kind);

/// It changes matrices of single bodies, joints, scales or screws: see parameter_sizes.h.
bool needs_parts(const std::string& kind);

/// The parameter of a kind at an item, with the kind's name, unit, bounds and nominal value.
/// @throws InputError: unknown kind
Parameter make_parameter(const std::string& kind, const std::string& where);

}  // namespace thermotwin::diagnosis
