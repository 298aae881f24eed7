// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Checks statements of machine.toml against each other that single values do not show: the chain of ISO 10791-1 against
// the bodies' tree, sides of joints, the table's point, and powers in the wrong unit.

#include <string>

#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

/// Warns of an axis that only the chain or only the machine has.
/// @param place  of the key kinematic_chain
/// @throws InputError for an axis of another kind, on the other side of the bed, or in another order than the parents
///   and axes of tool_body and table_body have
void check_chain(const Draft& draft, const std::string& place);

/// Warns of a joint with exchanged sides, a table point far from the table's axis, and a source of an unlikely power.
/// The tree must have been checked.
void check_structure(const Draft& draft);

}  // namespace thermotwin::mesh::reader
