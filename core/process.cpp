// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/process.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <iostream>
#include <memory>
#include <new>
#include <poll.h>
#include <regex>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <vector>

#include "core/error.h"

namespace thermotwin::core {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr auto patience = 1200ms;  // with work and exit handlers
constexpr auto stale_elsewhere = 24h;
constexpr std::size_t reserve_bytes = 1 << 20;

struct Ending {
  std::timed_mutex mutex;
  std::vector<fs::path> unfinished;  // guarded by mutex
  std::set<fs::path> swept;          // guarded by mutex
  std::array<int, 2> wake{-1, -1};   // pipe: a byte in it starts the clock
  std::atomic<int> status{130};
  std::atomic<bool> leaving{false};
  std::atomic<bool> watched{false};
  std::unique_ptr<char[]> reserve;  // memory to tidy up with
};

/// Never destroyed: the watching thread outlives the destructors of statics.
Ending& ending() {
  static Ending& instance = *new Ending;
  return instance;
}

/// Not through stdio, whose locks another thread may hold.
void say(std::string_view text) {
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text.data(), text.size());
}

[[noreturn]] void end_now(int status) {
  Ending& end = ending();
  // Never unlocked: nobody begins or publishes a file any more.
  if (end.mutex.try_lock_for(200ms)) {
    for (const fs::path& path : end.unfinished) {
      std::error_code error;
      // Another thread may still add files to a folder.
      for (int attempt = 0; attempt < 5 && (fs::remove_all(path, error), error); ++attempt) {}
    }
  }
  ::_exit(status);
}

void watch() {
  Ending& end = ending();
  pollfd woken{end.wake[0], POLLIN, 0};
  while (::poll(&woken, 1, -1) != 1) {}
  std::this_thread::sleep_for(patience);
  if (!end.leaving) say(fmt::format("thermotwin: {}\n", Interrupted().what()));
  end_now(end.status);
}

void on_exhausted_memory() {
  static std::atomic<bool> begun{false};
  if (begun.exchange(true)) {
    // Another thread tidies up; this one cannot go on.
    std::this_thread::sleep_for(patience);
    ::_exit(4);
  }
  ending().reserve.reset();
  say("thermotwin: not enough memory; a coarser --size needs less\n");
  end_now(4);
}

const std::string& host() {
  static const std::string name = [] {
    std::array<char, 256> buffer{};
    return ::gethostname(buffer.data(), buffer.size() - 1) == 0 ? std::string(buffer.data()) : std::string("host");
  }();
  return name;
}

/// Whether the process of this host runs; of our own only what it has begun is its own.
bool runs(const std::string& digits) {
  pid_t number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc() || number <= 0) return false;
  return number != ::getpid() && (::kill(number, 0) == 0 || errno == EPERM);
}

/// Call with the mutex held.
void sweep(const fs::path& folder) {
  static const std::regex part(R"((?:.*\.)?part-(?:(.+)-)?(\d+)(?:\.[^.]*)?)");
  const auto& ours = ending().unfinished;
  std::error_code error;
  std::vector<fs::path> stale;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    std::smatch match;
    if (!std::regex_match(name, match, part)) continue;
    std::error_code ignored;
    const bool is_stale = match[1] == host()
                              ? !runs(match[2])
                              : fs::file_time_type::clock::now() - entry.last_write_time(ignored) > stale_elsewhere;
    if (is_stale && std::find(ours.begin(), ours.end(), entry.path()) == ours.end()) stale.push_back(entry.path());
  }
  for (const fs::path& path : stale) fs::remove_all(path, error);
}

fs::path part_of(const fs::path& target) {
  const std::string mark = fmt::format("part-{}-{}", host(), ::getpid());
  if (!target.has_filename()) return target / mark;
  fs::path name = target.stem();
  name += "." + mark;
  name += target.extension();
  return target.parent_path() / name;
}

}  // namespace

UnfinishedPath::UnfinishedPath(const fs::path& target, Name name)
    : path_(name == Name::as_given ? target : part_of(target)) {
  Ending& end = ending();
  const std::lock_guard lock(end.mutex);
  const fs::path folder = path_.has_parent_path() ? path_.parent_path() : ".";
  if (end.swept.insert(folder).second) sweep(folder);
  end.unfinished.push_back(path_);
}

UnfinishedPath::~UnfinishedPath() {
  Ending& end = ending();
  const std::lock_guard lock(end.mutex);
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  if (const auto at = std::find(end.unfinished.begin(), end.unfinished.end(), path_); at != end.unfinished.end())
    end.unfinished.erase(at);
}

void remove_stale_parts(const fs::path& folder) {
  const std::lock_guard lock(ending().mutex);
  sweep(folder);
}

std::unique_lock<std::timed_mutex> keep_from_leaving() { return std::unique_lock(ending().mutex); }

void watch_for_end() {
  static std::once_flag once;
  std::call_once(once, [] {
    if (::pipe2(ending().wake.data(), O_CLOEXEC | O_NONBLOCK) != 0)
      throw std::system_error(errno, std::generic_category(), "pipe");
    std::thread(watch).detach();
    ending().watched = true;
  });
}

void end_soon() noexcept {
  const int before = errno;
  [[maybe_unused]] const ssize_t written = ::write(ending().wake[1], "", 1);
  errno = before;
}

void install_memory_handler() {
  ending().reserve = std::make_unique<char[]>(reserve_bytes);
  std::set_new_handler(on_exhausted_memory);
}

void leave(int status) {
  // Before the clock starts: who reads the outputs may be slow.
  std::cout.flush();
  std::fflush(nullptr);
  Ending& end = ending();
  if (!end.watched) end_now(status);  // no thread could be started: nobody would end a hanging exit handler
  end.status = status;
  end.leaving = true;
  end_soon();
  std::exit(status);
}

}  // namespace thermotwin::core
