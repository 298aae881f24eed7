// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Changes one number in a TOML text and leaves every other byte as the user wrote it. Only the outline of the text is
// read: headers, keys, and the limits of values. The file was parsed and checked before.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/causes/machine_value.h"
#include "mesh/machine/machine.h"

namespace thermotwin::diagnosis {

/// @return the text with the number changed. A key that is absent is added below the id of the table.
/// @param source   name for messages
/// @param number   new value; `{value = .., std_percent = ..}` keeps its form and its percentage
/// @param comment  line put above the key, without '#'
/// @throws InputError if the table, written as [[table]], or a number cannot be found
std::string changed_text(const std::string& text, const std::string& source, const MachineValue& place, double number,
                         const std::string& comment);

/// @return the text with a copy of a material under a new id, assigned to one body
/// @throws InputError if the material or the body is not found
std::string with_own_material(const std::string& text, const std::string& source, const std::string& material,
                              const std::string& copy, const std::string& body);

/// A self-contained machine: its text names CAD files beside it, so that its folder can be moved or sent.
struct MovableText {
  std::string text;
  std::vector<std::pair<std::filesystem::path, std::filesystem::path>>
      files;  ///< files to copy: source, and "cad/NAME" beside the text
};
/// A body whose CAD file is not found keeps its path, and so does a .gltf, which has buffers beside it.
/// @param machine  as read from the text, with its own path
MovableText movable_text(const std::string& text, const mesh::Machine& machine);

}  // namespace thermotwin::diagnosis
