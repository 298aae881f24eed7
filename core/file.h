// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Files that appear whole or not at all: text goes to "<path>.part-<pid>" first and is renamed
// once written, flushed and closed without an error. A full disk is an InputError that names it.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace thermotwin::core {

/// @return the whole file  @throws InputError if it cannot be read
std::string read_file(const std::filesystem::path& path);

/// Writes the text to path by way of a temporary neighbour; makes missing folders.
/// @throws InputError (disk full, no permission); an earlier file at path is then unchanged
void write_file(const std::filesystem::path& path, std::string_view text);

/// As write_file, for libraries that write by themselves: writer gets the temporary path (same
/// extension as path), which is renamed to path when it returns.
/// @throws what writer throws, after the temporary file was removed
void write_file_by(const std::filesystem::path& path,
                   const std::function<void(const std::filesystem::path& temporary)>& writer);

/// Writes files that belong together. The writer fills an empty folder and returns their names in
/// it; these then replace the files of the same names in folder. The last one vouches for the
/// others: it goes first and comes back last.
/// @throws what writer throws, InputError; if the writer fails, nothing in folder has changed
void write_files_by(
    const std::filesystem::path& folder,
    const std::function<std::vector<std::filesystem::path>(const std::filesystem::path& staged)>& writer);

/// 64-bit FNV-1a of the bytes, as 16 hexadecimal digits; stable across machines.
std::string content_hash(std::string_view bytes);

}  // namespace thermotwin::core
