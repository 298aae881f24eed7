// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Loads of a deck, as amplitudes over its increments.

#include <string>
#include <vector>

#include "solver/export/calculix_model.h"

namespace thermotwin::solver::calculix {

/// Amplitudes to be written before the steps, and the loads of the first step.
struct Loads {
  std::string amplitudes, lines;
  bool has_level = false;  ///< something knows a temperature: a steady state is one
};

Loads loads_text(Model& model, const Program& program, const std::vector<std::vector<ContactPoint>>& contact);

}  // namespace thermotwin::solver::calculix
