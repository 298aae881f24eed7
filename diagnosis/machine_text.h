// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A change of one number in a TOML text that leaves every other byte as the user wrote it. Only the
// outline of the text is read (headers, keys, where values begin and end); the file was parsed and
// checked before.

#include <string>

#include "diagnosis/machine_value.h"
#include "mesh/machine.h"

namespace thermotwin::diagnosis {

/// @param source   name for messages
/// @param number   new value; `{value = .., std_percent = ..}` keeps its form and its percentage
/// @param comment  line put above the key, without '#'
/// A key that is absent is added below the table's id.
/// @throws InputError if the table, written as [[table]], or a number cannot be found
std::string changed_text(const std::string& text, const std::string& source, const MachineValue& place,
                         double number, const std::string& comment);

/// The text with a material that is a copy of another under a new id, and that of one body.
/// @throws InputError if material or body cannot be found
std::string with_own_material(const std::string& text, const std::string& source, const std::string& material,
                              const std::string& copy, const std::string& body);

/// The text for another folder: the path of each body's CAD file that can be found, relative to that folder,
/// so that case and results may be moved together; whole where no relative path leads there.
/// @param machine  what was read from the text, at its own place
/// @param folder   where the text will stand; it need not exist yet
std::string with_cad_paths(const std::string& text, const mesh::Machine& machine, const std::filesystem::path& folder);

}  // namespace thermotwin::diagnosis
