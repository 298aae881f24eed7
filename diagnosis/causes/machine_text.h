// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A change of one number in a TOML text that leaves every other byte as the user wrote it. Only the
// outline of the text is read (headers, keys, where values begin and end); the file was parsed and
// checked before.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/causes/machine_value.h"
#include "mesh/machine/machine.h"

namespace thermotwin::diagnosis {

/// @param source   name for messages
/// @param number   new value; `{value = .., std_percent = ..}` keeps its form and its percentage
/// @param comment  line put above the key, without '#'
/// A key that is absent is added below the table's id.
/// @throws InputError if the table, written as [[table]], or a number cannot be found
std::string changed_text(const std::string& text, const std::string& source, const MachineValue& place, double number,
                         const std::string& comment);

/// The text with a material that is a copy of another under a new id, and that of one body.
/// @throws InputError if material or body cannot be found
std::string with_own_material(const std::string& text, const std::string& source, const std::string& material,
                              const std::string& copy, const std::string& body);

/// A machine that stands by itself: its text names CAD files beside it, so that its folder may be moved or sent.
struct MovableText {
  std::string text;
  std::vector<std::pair<std::filesystem::path, std::filesystem::path>>
      files;  ///< to be copied: from where, to "cad/NAME" beside the text
};
/// Bodies whose CAD file cannot be found keep the path that they have; a .gltf, which has buffers beside it, is named
/// where it is. @param machine  what was read from the text, at its own place
MovableText movable_text(const std::string& text, const mesh::Machine& machine);

}  // namespace thermotwin::diagnosis
