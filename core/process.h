// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Ends the process and removes the files that it must not leave half-written.
//
// A library may keep the process from ending: the exit handler of OpenBLAS joins a thread that may wait for memory
// without end, and a signal has no effect while nothing calls check_interrupt(). A separate thread therefore ends the
// process 1.2 s after the first signal or after leave(), and removes unfinished files.

#include <filesystem>
#include <mutex>

namespace thermotwin::core {

/// The temporary path of a file before it gets its name: model.rom.part-HOST-12.h5 beside model.rom.h5, or, for a
/// folder "out/" (with the slash), out/part-HOST-12. It is removed with its content when this object goes out of
/// scope or a signal ends the process. as_given: the target itself.
class UnfinishedPath {
public:
  enum class Name { of_this_process, as_given };
  explicit UnfinishedPath(const std::filesystem::path& target, Name name = Name::of_this_process);
  ~UnfinishedPath();
  UnfinishedPath(const UnfinishedPath&) = delete;
  UnfinishedPath& operator=(const UnfinishedPath&) = delete;

  const std::filesystem::path& path() const { return path_; }

private:
  std::filesystem::path path_;
};

/// Removes unfinished files of killed processes from the folder, not from folders below: those of this host whose
/// process has ended, and those of other hosts after a day. UnfinishedPath calls it once per folder.
void remove_stale_parts(const std::filesystem::path& folder);

/// While an object lives, the thread does not end the process, so that files can change together.
[[nodiscard]] std::unique_lock<std::timed_mutex> keep_from_leaving();

/// Starts the thread; once. Called by install_interrupt_handler.
void watch_for_end();

/// Async-signal-safe: the process ends with status 130 in 1.2 s, unless it leaves by itself before.
void end_soon() noexcept;

/// Makes the process report a lack of memory and end with status 4 at once.
void install_memory_handler();

/// Flushes the outputs and ends the process; exit handlers have 1.2 s.
[[noreturn]] void leave(int status);

}  // namespace thermotwin::core
