// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Loads of a deck, as amplitudes over its increments.

#include <string>
#include <vector>

#include "solver/export/calculix_model.h"

namespace thermotwin::solver::calculix {

/// Keywords of a CalculiX deck. *AMPLITUDE goes before the steps, films, fluxes and temperatures into the first step.
struct Loads {
  std::string amplitudes, lines;
  bool has_level = false;  ///< a film, mount or coolant fixes the temperature level, so that a steady state exists
};

/// @param contact  the points of each joint
Loads loads_text(Model& model, const Program& program, const std::vector<std::vector<ContactPoint>>& contact);

}  // namespace thermotwin::solver::calculix
