// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The static deck: springs, scales and supports.

#include <string>

#include "solver/export/calculix_model.h"

namespace thermotwin::solver::calculix {

/// Thermometers of the tapes, for both decks, and the static model that uses them.
struct Statics {
  std::string heat_model;  ///< nodes, elements, equations of the thermometers
  std::string model;       ///< springs, scales and supports of static.inp
};

Statics statics(Model& model);

}  // namespace thermotwin::solver::calculix
