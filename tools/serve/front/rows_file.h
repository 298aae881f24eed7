// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The rows of the last 24 h, kept on disk so that a new model can use them after a restart of `serve`. Each is appended
// as a line with a number and a checksum, so that a line that was cut off is recognised.

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace thermotwin::tools {

struct KeptRow {
  static constexpr char begin = 'b', plain = 'r', after_pause = 'p';
  char kind = plain;  ///< begin: the model began cold with it
  double time = 0;    ///< s, on the scale of RowClock
  std::string text;   ///< with its end
};

class RowsFile {
public:
  explicit RowsFile(std::filesystem::path file) : file_(std::move(file)) {}

  struct Content {
    std::string header;
    std::vector<KeptRow> rows;
  };
  /// @return the header and the undamaged rows after the last gap in the line numbers; damaged lines give a warning
  Content read();
  /// Writes the file anew.
  void write(const Content& content);
  void append(const KeptRow& row);
  /// Lines in the file, the header among them.
  std::size_t lines() const { return lines_; }

private:
  void warn(const std::string& reason);
  std::string line_of(char kind, double time, const std::string& text);

  std::filesystem::path file_;
  std::size_t lines_ = 0;  ///< the number of the next one
  bool has_failed_ = false;
};

}  // namespace thermotwin::tools
