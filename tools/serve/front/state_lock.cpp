// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/serve/front/state_lock.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fcntl.h>
#include <string>
#include <sys/file.h>
#include <system_error>
#include <unistd.h>

#include "core/error.h"

namespace thermotwin::tools {

namespace fs = std::filesystem;

StateLock::StateLock(const fs::path& state) {
  if (const fs::path folder = state.parent_path(); !folder.empty()) {
    std::error_code ignored;
    fs::create_directories(folder, ignored);
  }
  const std::string name = state.string() + ".serve.lock";
  file_ = ::open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (file_ < 0) throw core::InputError(name, std::strerror(errno), "a state in a folder that may be written");
  if (::flock(file_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  ::close(file_);
  throw core::InputError(state.string(), "another `serve` goes on from this state",
                         "one instance per state; end it, or name another file with --state");
}

StateLock::~StateLock() { ::close(file_); }

double age_s(const fs::path& file) {
  std::error_code none;
  const auto written = fs::last_write_time(file, none);
  if (none) return 0.0;
  return std::max(0.0, std::chrono::duration<double>(fs::file_time_type::clock::now() - written).count());
}

}  // namespace thermotwin::tools
