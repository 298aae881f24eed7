// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The items of machine.toml that a kind of parameter may refer to, with the uncertainty that the file states.

#include <string>
#include <vector>

#include "diagnosis/causes/kinds.h"
#include "mesh/machine/machine.h"

namespace thermotwin::study {

struct Item {
  std::string id;            ///< as `where` in diagnosis.json
  double std_percent = 0;    ///< of the kind's value in machine.toml; 0: none is stated
  double size = 1;           ///< of that value, in the kind's unit, where the kind adds to it; else 1
  double low = 0, high = 0;  ///< of the kind's factor, or of what it adds
  /// Of the kind's factor, or of what it adds; 0: none is stated, or that of the value 0.
  double std() const { return size * std_percent / 100.0; }
};

/// @return the items of the machine that the kind acts on, as a diagnosis offers them without a measurement; empty for
///   a kind that acts on none
std::vector<Item> items_of(const mesh::Machine& machine, diagnosis::Kind kind);

/// The kinds that a plan may name: they act on the machine, not on readings.
std::vector<std::string> kinds_of_plans();

/// Whether variants of the kind share mesh, matrices and output rows: powers, films, contacts, flows, surroundings.
bool shares_matrices(diagnosis::Kind kind);

}  // namespace thermotwin::study
