// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reads the rows of a control as lines of CSV and writes the offsets.

#include <cstddef>
#include <functional>
#include <iosfwd>
#include <map>
#include <string>

#include "compensation/online/compensator.h"

namespace thermotwin::compensation {

struct StreamSummary {
  long rows = 0;        ///< written
  long unreadable = 0;  ///< rows that were unreadable, or had an unreadable or impossible cell
  /// Number of rows of each status but ok, as written: "sensor_failed T1=kelvin". Beyond most_statuses: "others".
  std::map<std::string, long, std::less<>> not_ok;
  static constexpr std::size_t most_statuses = 20;
  bool names_machine = false;      ///< the stream named its machine
  double first_s = 0, last_s = 0;  ///< times of the first and last row that could be read
  /// Probed components of the TCP error that an axis moves, before each of them is learned from: their number, and the
  /// RMS of the error as probed and with the offset of the row. Without probed_compensated only.
  long probed = 0;
  double probed_rms_um = 0, left_rms_um = 0;
  long probed_unmoved = 0;  ///< values in directions that no axis moves; not among the others
  double unmoved_rms_um = 0;
};

/// Streams CSV rows from in to out, row by row, with constant memory. Columns are time_s, any channel, any
/// `<sensor>_C`, and probe_dx_um, probe_dy_um, probe_dz_um. The last three are the TCP error probed at the row's pose;
/// they are blank in most rows and take effect from the next row on. An unknown column is an InputError with the
/// nearest known name. A line "# machine NAME HASH" before the header is compared with the model's machine. A cell that
/// is unreadable, or that the machine cannot have (input_limits.h), counts as missing and is named in the row's status
/// and on stderr. A row without a readable time, or with another number of cells, repeats the answer of the row before.
/// @param after_row  is called after each row that could be read, with its answer; empty: nothing is
/// @throws InputError for columns, times that do not rise, another machine's rows, lines beyond longest_line
///   (row_reader.h)
StreamSummary compensate_stream(OnlineModel& model, const mesh::Machine& machine, std::istream& in,
                                const std::string& in_name, std::ostream& out, const StreamOptions& options = {},
                                const std::function<void(const Offsets&)>& after_row = {});

}  // namespace thermotwin::compensation
