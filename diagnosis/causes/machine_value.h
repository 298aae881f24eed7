// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Where a parameter lives: the numbers in the machine and the keys in machine.toml that hold them.

#include <string>
#include <vector>

#include "diagnosis/causes/hypothesis.h"
#include "diagnosis/causes/parameter.h"

namespace thermotwin::diagnosis {

struct MachineValue {
  std::string table;  ///< "source": the [[source]] ...
  std::string id;     ///< ... with this id
  std::string part;   ///< the table below it that this names; empty: the table itself
  std::string key;
  double* value = nullptr;                              ///< into the machine it was asked of
  double per_unit = 1;                                  ///< the machine's value of one unit of the key
  std::string id_key = "id";                            ///< key that holds the id
  std::string part_table = "segment", part_key = "id";  ///< [[<table>.<part_table>]] whose part_key is `part`
  bool may_lack = false;  ///< the table itself is added at the end of the file where it is not there
};

/// All that the parameter changes (both stiffnesses of a joint; else one). What the machine lacks is
/// added to it: a [[reading]], a material of the body's own.
/// @throws InputError: unknown kind or item
std::vector<MachineValue> machine_values(mesh::Machine& machine, const Parameter& parameter);

/// The number in the file once the parameter has the value: a ratio multiplies, else it adds.
double changed_value(double in_file, const Parameter& parameter, double value);

/// Id of the material that only this body has: its own already, or a copy's.
std::string own_material_id(const mesh::Machine& machine, const mesh::BodySpec& body);

}  // namespace thermotwin::diagnosis
