// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
// Writes records to standard output. Only whole records leave, also when a signal ends the work.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "nc/rs274/records.h"

namespace thermotwin::nc::rs274 {

/// Records keep standard output for themselves; what libraries print goes nowhere.
void take_standard_output();
void write_values(Kind kind, std::uint8_t index, std::uint32_t line, const double* values, int count);
void write_setting(Setting setting, double value, double second = 0.0);
void write_text(Kind kind, std::uint8_t index, std::uint32_t line, std::string_view text);
/// Safe in a signal handler between records.
void flush();

/// Limits of the work; a move or line beyond ends the process with a record that says so.
struct Limits {
  std::uint64_t moves = 0, idle_blocks = 0;
};
void set_limits(const Limits& limits);
void begin_block(std::uint32_t line, int depth);
/// The interpreter has executed the block; without this it has skipped it.
void block_ran();
bool has_run();
/// Line of the last block.
std::uint32_t current_line();

/// Writes the error and ends the process.
[[noreturn]] void stop(Stop reason, std::string_view text);

}  // namespace thermotwin::nc::rs274
