// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The place of a parameter: the numbers in the machine and the keys of machine.toml that hold them.

#include <string>
#include <vector>

#include "diagnosis/causes/hypothesis.h"
#include "diagnosis/causes/parameter.h"

namespace thermotwin::diagnosis {

struct MachineValue {
  std::string table;  ///< "source": the [[source]] ...
  std::string id;     ///< ... with this id
  std::string part;   ///< value of part_key in the nested table that has the key; empty: the table itself has it
  std::string key;
  double* value = nullptr;                              ///< in the machine given to machine_values()
  double per_unit = 1;                                  ///< `value` for 1 in the unit of the key
  std::string id_key = "id";                            ///< key that holds the id
  std::string part_table = "segment", part_key = "id";  ///< `[[<table>.<part_table>]]` whose part_key is `part`
  int part_number = 0;                                  ///< of tables with the same part, from 0
  bool may_lack = false;                                ///< if absent, the table is added at the end of the file
};

/// @return all numbers that the parameter changes: both stiffnesses of a joint, a material and its copies, else one.
///   Missing items are added to the machine: a [[reading]], or a body's own material.
/// @throws InputError for an unknown kind or item
std::vector<MachineValue> machine_values(mesh::Machine& machine, const Parameter& parameter);

/// @return the number in the file for a value of the parameter: a ratio multiplies it, else the value is added
double changed_value(double in_file, const Parameter& parameter, double value);

/// @return the id of the body's own material, or of the copy that it would get
std::string own_material_id(const mesh::Machine& machine, const mesh::BodySpec& body);

/// @return the bodies that have a material, or a copy of it that own_material_id() names
std::vector<const mesh::BodySpec*> bodies_of_material(const mesh::Machine& machine, const std::string& material);

}  // namespace thermotwin::diagnosis
