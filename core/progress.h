// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Shows the progress of long work on stderr: a bar with the remaining time on a terminal, otherwise a plain line every
// few seconds, and nothing when quiet. Long loops call check_interrupt() between steps, which reacts to Ctrl-C.

#include <cstddef>
#include <string>

namespace thermotwin::core {

/// Switches progress and log lines off, or on again.
void set_quiet(bool quiet);
bool is_quiet();

/// One plain line on stderr ("label: text"), unless quiet.
void log_line(const std::string& text);

/// A line on stderr that begins with "warning: ", even when quiet.
void warn(const std::string& text);

class Progress {
public:
  /// @param label  name of the work, e.g. "thermal run 'warm_up'"
  /// @param total  number of steps, >= 1
  Progress(std::string label, std::size_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Thread-safe. Also calls check_interrupt().
  void advance(std::size_t steps = 1);

private:
  struct State;
  State* state_;
};

/// Makes SIGINT and SIGTERM known to check_interrupt(). A second signal ends the process at once with status 130.
/// @throws std::system_error if no thread can be started
void install_interrupt_handler();

/// @throws Interrupted if the user asked to stop
void check_interrupt();

}  // namespace thermotwin::core
