// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The state that `serve` goes on from: that one instance alone uses it, and how old it is.

#include <filesystem>

namespace thermotwin::tools {

/// One `serve` a state. The lock ends with the process.
class StateLock {
public:
  /// @throws InputError  if another instance has it, or the folder cannot be written
  explicit StateLock(const std::filesystem::path& state);
  ~StateLock();
  StateLock(const StateLock&) = delete;
  StateLock& operator=(const StateLock&) = delete;

private:
  int file_ = -1;
};

/// The age of a file by the computer's clock, s; 0 where that was set back.
double age_s(const std::filesystem::path& file);

}  // namespace thermotwin::tools
