// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
// Writes records to standard output. Only whole records are written, also when a signal ends the process.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "nc/rs274/records.h"

namespace thermotwin::nc::rs274 {

/// Reserves standard output for records. Output of libraries to standard output and standard error is discarded.
void take_standard_output();
/// @param index  its meaning depends on the kind, see Kind  @param line  of the program
/// @param values  (count) at most 16; the record leaves out those unchanged since the last one of the same kind, but
///   for offsets and settings
void write_values(Kind kind, std::uint8_t index, std::uint32_t line, const double* values, int count);
/// @param second  second value of the setting, such as the tolerance of path_mode
void write_setting(Setting setting, double value, double second = 0.0);
/// @param text  is cut at 60,000 bytes
void write_text(Kind kind, std::uint8_t index, std::uint32_t line, std::string_view text);
/// Safe in a signal handler between records.
void flush();

/// Limits of the helper's work. The move or line beyond a limit ends the process with an error record.
struct Limits {
  std::uint64_t moves = 0;        ///< of the program
  std::uint64_t idle_blocks = 0;  ///< lines in succession without a move
};
void set_limits(const Limits& limits);
/// A line of the program begins. @param depth  of subprograms
void begin_block(std::uint32_t line, int depth);
/// States that the interpreter has executed the line. A line without it counts as skipped.
void block_ran();
/// @return whether the line that has begun last was executed
bool has_run();
/// Line that has begun last.
std::uint32_t current_line();

/// Writes the error and ends the process.
[[noreturn]] void stop(Stop reason, std::string_view text);

}  // namespace thermotwin::nc::rs274
