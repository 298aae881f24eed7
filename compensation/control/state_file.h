// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The file of a saved state beside a running model. It is written whole, at least once a minute of machine time and at
// the end, so that a kill or a power cut costs at most a minute. One process at a time goes on from a file.

#include <chrono>
#include <filesystem>
#include <functional>
#include <future>
#include <limits>
#include <optional>
#include <string>

namespace thermotwin::compensation {

/// Machine time between two writes, s.
inline constexpr double state_every_s = 60.0;

class StateFile {
public:
  /// in_background: a thread of its own writes, so that a disk that takes seconds holds up no row of a machine. A
  /// write that is due while another one goes on waits for its end. Recorded rows, whose time passes more than twice as
  /// fast as that of the computer, are held up, so that their state is as old as with at_once.
  enum class Writes { at_once, in_background };

  /// Takes the lock PATH.lock, which ends with the process.
  /// @throws StateError if another process has it, InputError if the folder cannot be written
  explicit StateFile(std::filesystem::path path, Writes writes = Writes::at_once);
  ~StateFile();
  StateFile(const StateFile&) = delete;
  StateFile& operator=(const StateFile&) = delete;

  /// @return the bytes; nothing where there is no file yet  @throws InputError if it cannot be read
  std::optional<std::string> read() const;

  /// After each row: writes where a minute has passed. A write that fails is a warning, once, and is tried again with
  /// the next minute; the file before it is still whole. @param time  s  @param saved  gives the bytes
  void after_row(double time, const std::function<std::string()>& saved);
  /// @throws InputError (disk full, no permission)
  void write(const std::string& saved);
  bool is_failing() const { return warned_; }  ///< the last write of after_row() failed

private:
  /// @return whether no write goes on; what the last one said is taken in
  bool is_idle();
  bool is_recorded(double time) const;
  void take_in(const std::string& error);

  std::filesystem::path path_;
  Writes writes_;
  int lock_ = -1;
  double written_at_ = -std::numeric_limits<double>::infinity();  ///< machine time
  std::chrono::steady_clock::time_point written_then_;            ///< the computer's
  bool warned_ = false;
  std::future<std::string> writing_;  ///< what went wrong; empty: nothing
};

}  // namespace thermotwin::compensation
