// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Writes files that appear whole or not at all. Text goes to a temporary neighbour first, which is renamed once it is
// written, flushed and closed without an error. A full disk is an InputError that names the file.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace thermotwin::core {

/// @return the content of the file  @throws InputError if it cannot be read
std::string read_file(const std::filesystem::path& path);

/// Writes the text to path by way of a temporary neighbour; makes missing folders.
/// @throws InputError (disk full, no permission); an earlier file at path is then unchanged
void write_file(const std::filesystem::path& path, std::string_view text);
/// The same for a thread of its own. @return what went wrong; empty: nothing
std::string write_file_or_say(const std::filesystem::path& path, const std::string& text);

/// Does the same for libraries that write files themselves: writer receives the temporary path (same extension as
/// path), which is renamed to path after writer returns.
/// @throws what writer throws, after the temporary file was removed
void write_file_by(const std::filesystem::path& path,
                   const std::function<void(const std::filesystem::path& temporary)>& writer);

/// Writes files that belong together. The writer fills an empty folder and returns the names of its files, which then
/// replace the files of the same names in folder. The last one marks the set as complete: it is removed first and
/// written last.
/// @throws what writer throws, InputError; if the writer fails, nothing in folder has changed
void write_files_by(
    const std::filesystem::path& folder,
    const std::function<std::vector<std::filesystem::path>(const std::filesystem::path& staged)>& writer);

/// @return the 64-bit FNV-1a hash of the bytes as 16 hexadecimal digits, equal on all machines
std::string content_hash(std::string_view bytes);

}  // namespace thermotwin::core
