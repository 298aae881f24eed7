// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Rows of a control as lines of CSV.

#include <cstddef>
#include <functional>
#include <iosfwd>
#include <map>
#include <string>

#include "compensation/online/compensator.h"

namespace thermotwin::compensation {

/// Longest line of a stream, with room for thousands of columns.
inline constexpr std::size_t longest_line = 1U << 18U;

struct StreamSummary {
  long rows = 0;        ///< written
  long unreadable = 0;  ///< rows with a cell that could not be read or cannot be, or as a whole
  /// Rows with each status but ok, as it is written: "sensor_failed T1=kelvin". Beyond most_statuses: "others".
  std::map<std::string, long, std::less<>> not_ok;
  static constexpr std::size_t most_statuses = 20;
  bool names_machine = false;  ///< the stream said which machine it is of
};

/// Streams CSV rows from in to out, row by row, constant memory. Columns: time_s, any channel, any
/// <sensor>_C, and probe_dx_um, probe_dy_um, probe_dz_um: the TCP error as probed at the row's pose, blank
/// in most rows, in effect from the next row on. An unknown column is an InputError with the nearest
/// known name. A line "# machine NAME HASH" before the header is compared with the model's machine. A cell
/// that cannot be read, or that the machine cannot have (input_limits.h), counts as missing, is named in the
/// row's status and on stderr; a row without a readable time or of another number of cells gets the answer of
/// the row before once more.
/// @throws InputError for columns, times that do not rise, another machine's rows, lines beyond longest_line
StreamSummary compensate_stream(Compensator& compensator, const mesh::Machine& machine, std::istream& in,
                                const std::string& in_name, std::ostream& out, const StreamOptions& options = {});

}  // namespace thermotwin::compensation
