// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// How the process ends, and the files that it must not leave half-written.
//
// A library may keep the process from ending: OpenBLAS' exit handler joins a thread that asks for
// memory without end, and a signal is not heeded where nobody calls check_interrupt(). So a thread of
// its own ends the process 1.2 s after the first signal or after leave(), removing unfinished files.

#include <filesystem>
#include <mutex>

namespace thermotwin::core {

/// Where a file is written before it gets its name: model.rom.part-HOST-12.h5 beside model.rom.h5, or
/// for a folder "out/" (with the slash) out/part-HOST-12. It is removed, with all that is in it, when
/// this goes out of scope or the process is ended by a signal. as_given: the target itself.
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

/// Removes what killed processes left unfinished in the folder (not below): those of this host that
/// run no more, those of other hosts after a day. Done once a folder by UnfinishedPath.
void remove_stale_parts(const std::filesystem::path& folder);

/// While it is held, the process is not ended by its own thread: for files that change together.
[[nodiscard]] std::unique_lock<std::timed_mutex> keep_from_leaving();

/// Starts the thread; once. Called by install_interrupt_handler.
void watch_for_end();

/// Async-signal-safe: the process ends with status 130 in 1.2 s, unless it leaves by itself before.
void end_soon() noexcept;

/// Where memory runs out, the process says so and ends with status 4 at once.
void install_memory_handler();

/// Flushes the outputs and ends the process; exit handlers have 1.2 s.
[[noreturn]] void leave(int status);

}  // namespace thermotwin::core
