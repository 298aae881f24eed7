// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The moments of the last 24 h on the disk, so that the page shows them after a power cut, too. Each is appended as a
// line; a power cut costs the lines that the system had not yet written to the disk, usually the last one at most.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace thermotwin::tools {

class DayFile {
public:
  /// @param file  empty: nothing is kept
  explicit DayFile(std::filesystem::path file) : file_(std::move(file)) {}

  /// @param time  of the first moment that comes, s; later lines of the file belong to a run that does not go on
  /// @return the lines of the 24 h before it, and writes the file anew with these
  std::vector<std::string> before(double time);
  /// @param line  JSON with the time as `run_s`. A write that fails is said once.
  void append(double time, const std::string& line);

private:
  void warn(const std::string& reason);

  std::filesystem::path file_;
  std::size_t lines_ = 0;
  bool has_failed_ = false;
};

}  // namespace thermotwin::tools
