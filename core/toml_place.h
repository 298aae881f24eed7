// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Finds the line of a key again, for a message about a value that was read long before.

#include <filesystem>
#include <string>
#include <vector>

namespace thermotwin::core {

/// @param text, source  the file as read, its name for messages  @param table  empty: the key is in the root
/// @return "machine.toml:12 tcp.tool_body"; without a line if the text has no such table or key
std::string toml_place(const std::string& text, const std::string& source, const std::string& table,
                       const std::string& key);
/// The same of a file, which may be gone.
std::string toml_place(const std::filesystem::path& file, const std::string& table, const std::string& key);

/// @return for each id of [[table]] "channels.toml:12 channel 'T1'", without a line if the file does not have it
std::vector<std::string> toml_places_of_ids(const std::filesystem::path& file, const std::string& table,
                                            const std::vector<std::string>& ids);

}  // namespace thermotwin::core
