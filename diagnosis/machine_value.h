// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Where a parameter lives: the number in the machine and the key in machine.toml that holds it.

#include <string>

#include "diagnosis/hypothesis.h"

namespace thermotwin::diagnosis {

struct MachineValue {
  std::string table;        ///< "source": the [[source]] ...
  std::string id;           ///< ... with this id
  std::string segment;      ///< the [[<table>.segment]] below it with this id; empty: the table itself
  std::string key;
  double* value = nullptr;  ///< into the machine it was asked of, in the unit of the key
};

/// @throws InputError: unknown kind or item
MachineValue machine_value(mesh::Machine& machine, const Parameter& parameter);

/// The number in the file once the parameter has the value: a ratio multiplies, an offset adds.
double changed_value(double in_file, const Parameter& parameter, double value);

}  // namespace thermotwin::diagnosis
