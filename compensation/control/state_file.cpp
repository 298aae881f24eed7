// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/state_file.h"

#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fcntl.h>
#include <sys/file.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "compensation/control/state_error.h"
#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"

namespace thermotwin::compensation {

StateFile::StateFile(std::filesystem::path path, Writes writes) : path_(std::move(path)), writes_(writes) {
  if (const auto folder = path_.parent_path(); !folder.empty()) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
  }
  std::error_code none;  // a link stands for the file that it names
  const std::filesystem::path real = std::filesystem::weakly_canonical(path_, none);
  const std::string lock = (none ? path_ : real).string() + ".lock";
  lock_ = ::open(lock.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (lock_ < 0) throw core::InputError(lock, std::strerror(errno), "a state in a folder that may be written");
  if (::flock(lock_, LOCK_EX | LOCK_NB) == 0) return;
  const int reason = errno;
  if (reason != EWOULDBLOCK) {
    core::warn(path_.string() + " is not locked against a second process: " + std::strerror(reason));
    return;
  }
  ::close(lock_);
  throw StateError(StateFault::in_use, path_.string(), "another process goes on from this state",
                   "one process per state; wait until it has ended, or name another file");
}

StateFile::~StateFile() {
  if (writing_.valid()) writing_.wait();  // before another process has the lock
  ::close(lock_);
}

std::optional<std::string> StateFile::read() const {
  if (!std::filesystem::exists(path_)) return std::nullopt;
  return core::read_file(path_);
}

bool StateFile::is_idle() {
  if (!writing_.valid()) return true;
  if (writing_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return false;
  take_in(writing_.get());
  return true;
}

/// The offsets go on where the state cannot be written.
void StateFile::take_in(const std::string& error) {
  if (!error.empty() && !warned_) core::warn(error);
  warned_ = !error.empty();
}

bool StateFile::is_recorded(double time) const {
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - written_then_;
  return std::isfinite(written_at_) && time - written_at_ > 2.0 * passed.count();
}

void StateFile::after_row(double time, const std::function<std::string()>& saved) {
  const bool idle = is_idle();
  if (time - written_at_ < state_every_s) return;
  const bool waits = writes_ == Writes::at_once || is_recorded(time);
  if (!idle && !waits) return;
  if (writing_.valid()) take_in(writing_.get());
  written_at_ = time;
  written_then_ = std::chrono::steady_clock::now();
  if (waits)
    take_in(core::write_file_or_say(path_, saved()));
  else
    writing_ = std::async(std::launch::async, core::write_file_or_say, path_, saved());
}

void StateFile::write(const std::string& saved) {
  if (writing_.valid()) take_in(writing_.get());
  core::write_file(path_, saved);
}

}  // namespace thermotwin::compensation
