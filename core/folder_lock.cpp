// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/folder_lock.h"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <string>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include "core/error.h"
#include "core/folder_guard.h"
#include "core/progress.h"

namespace thermotwin::core {

namespace fs = std::filesystem;

namespace {

std::string host_name() {
  std::array<char, 256> buffer{};
  return ::gethostname(buffer.data(), buffer.size() - 1) == 0 ? buffer.data() : "an unknown host";
}

std::string holder_of(int file) {
  std::array<char, 512> text{};
  const ssize_t size = ::pread(file, text.data(), text.size() - 1, 0);
  return size > 0 ? std::string(text.data(), size) : "another process";
}

/// Whether the name still leads to the open file: its last owner may have removed it.
bool is_same(int file, const fs::path& path) {
  struct stat open {
  }, named{};
  return ::fstat(file, &open) == 0 && ::stat(path.c_str(), &named) == 0 && open.st_ino == named.st_ino &&
         open.st_dev == named.st_dev;
}

}  // namespace

FolderLock::FolderLock(const fs::path& folder) {
  require_not_lost(folder);
  std::error_code error;
  fs::create_directories(folder, error);
  const fs::path path = folder / "lock";
  while (true) {
    file_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (file_ < 0) throw InputError(folder.string(), std::strerror(errno), "a folder that may be written");
    int status = 0;
    do status = ::flock(file_, LOCK_EX | LOCK_NB);
    while (status != 0 && errno == EINTR);
    const int reason = errno;
    if (status == 0 && is_same(file_, path)) break;
    const std::string holder = status != 0 ? holder_of(file_) : std::string();
    ::close(std::exchange(file_, -1));
    if (status == 0) continue;
    if (reason == EWOULDBLOCK) {
      throw InputError(folder.string(), holder + " writes here",
                       "one process per folder; wait until it has ended, or use another --out");
    }
    warn(fmt::format("{} is not locked against a second process: {}", folder.string(), std::strerror(reason)));
    return;
  }
  path_ = std::make_unique<UnfinishedPath>(path, UnfinishedPath::Name::as_given);
  const std::string text = fmt::format("process {} on {}", ::getpid(), host_name());
  if (::ftruncate(file_, 0) == 0) {
    [[maybe_unused]] const ssize_t written = ::pwrite(file_, text.data(), text.size(), 0);
  }
}

FolderLock::FolderLock(FolderLock&& other) noexcept
    : file_(std::exchange(other.file_, -1)),
      path_(std::move(other.path_)) {}

FolderLock::~FolderLock() {
  path_.reset();  // before the lock ends: nobody else holds a file of this name
  if (file_ >= 0) ::close(file_);
}

void remove_stale_lock(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(folder / "lock", error)) return;
  try {
    const FolderLock own(folder);
  } catch (const InputError&) {  // somebody works there
  }
}

}  // namespace thermotwin::core
