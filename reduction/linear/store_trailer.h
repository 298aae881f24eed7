// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The last line of a file of StoreWriter (hdf5_store.h): a hash of all bytes before it, FNV-1a on words of eight bytes;
// on single bytes in files of earlier versions. The line tells which model a file holds without reading the rest.

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace thermotwin::reduction {

inline constexpr std::size_t store_trailer_size = 38;

/// @return the line behind the bytes, with the newline before it
std::string store_trailer(std::string_view bytes);
/// @return whether the line has the form of one, of this or of an earlier version
bool is_store_trailer(std::string_view line);
/// @return whether the line is that of the bytes
bool store_trailer_holds(std::string_view bytes, std::string_view line);

/// @return the line of a file; empty: the file has none or cannot be read
std::string read_store_trailer(const std::filesystem::path& file);
/// Reads the whole file, a piece at a time. @return whether it ends with the line of all bytes before
bool store_file_holds(const std::filesystem::path& file);

}  // namespace thermotwin::reduction
