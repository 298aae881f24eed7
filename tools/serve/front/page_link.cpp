// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/serve/front/page_link.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/progress.h"

namespace thermotwin::tools {
namespace {

constexpr double shown_every_s = 0.25, kept_every_s = 60.0, day_s = 86400.0;
constexpr double longest_wait_s = 30.0, lives_s = 10.0;
constexpr std::size_t most_pending = std::size_t{1} << 24U;  ///< bytes

}  // namespace

PageLink::~PageLink() { end(); }

void PageLink::end() {
  if (to_ >= 0) ::close(to_);
  to_ = -1;
  if (process_ > 0) {
    ::kill(process_, SIGKILL);  // it has nothing to save
    ::waitpid(process_, nullptr, 0);
  }
  process_ = 0;
}

void PageLink::restart() {
  end();
  next_start_at_ = 0;
}

void PageLink::start(double now) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return;
  std::vector<char*> words;
  for (std::string& word : command_) words.push_back(word.data());
  words.push_back(nullptr);
  process_ = ::fork();
  if (process_ == 0) {
    ::dup2(ends[0], STDIN_FILENO);
    ::dup2(STDERR_FILENO, STDOUT_FILENO);  // answers alone go to standard output
    std::signal(SIGPIPE, SIG_DFL);
    ::execv(words[0], words.data());
    ::_exit(127);
  }
  ::close(ends[0]);
  to_ = ends[1];
  ::fcntl(to_, F_SETFL, O_NONBLOCK);
  begun_at_ = now;
  pending_.clear();
  sent_ = 0;
  if (process_ < 0) {
    process_ = 0;
    end();
    next_start_at_ = now + longest_wait_s;
    return;
  }
  for (const auto& [time, line] : day_) pending_ += line;
}

void PageLink::tend(double now) {
  int how = 0;
  if (process_ > 0 && ::waitpid(process_, &how, WNOHANG) == process_) {
    process_ = 0;
    end();
    wait_s_ = now - begun_at_ > lives_s ? 0.5 : std::min(2.0 * wait_s_, longest_wait_s);
    next_start_at_ = now + wait_s_;
    core::warn(fmt::format("serve: the process of the page has ended ({} {}); it is restarted in {:.0f} s",
                           WIFSIGNALED(how) ? "signal" : "status", WIFSIGNALED(how) ? WTERMSIG(how) : WEXITSTATUS(how),
                           wait_s_));
  }
  if (process_ == 0 && now >= next_start_at_) start(now);
  flush();
}

void PageLink::flush() {
  while (to_ >= 0 && sent_ < pending_.size()) {
    const ssize_t count = ::write(to_, pending_.data() + sent_, pending_.size() - sent_);
    if (count < 0) return;  // full, or ended: tend() sees it
    sent_ += count;
  }
  pending_.clear();
  sent_ = 0;
}

/// Moments that the page cannot take in time are left out, those of its 24 h wait.
void PageLink::send(const std::string& line, bool is_kept) {
  flush();
  if (to_ < 0 || pending_.size() > most_pending || (!is_kept && !pending_.empty())) return;
  pending_ += line;
  flush();
}

void PageLink::show(nlohmann::json moment, double time, double now) {
  const bool is_whole = moment.contains("sensors");
  const bool is_kept = is_whole && (day_.empty() || time - day_.back().first >= kept_every_s);
  if (!is_kept && now - shown_at_ < shown_every_s) return;
  moment["run_s"] = time;
  moment["unix_s"] = std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  const std::string line = moment.dump() + "\n";
  if (is_kept) {
    day_.emplace_back(time, line);
    while (day_.front().first < time - day_s) day_.pop_front();
  }
  shown_at_ = now;
  send(line, is_kept);
}

}  // namespace thermotwin::tools
