// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The process of the page, as the front sees it: fed with lines of JSON, never waited for, started again when it has
// ended. A new one first gets the last 24 h.

#include <nlohmann/json_fwd.hpp>

#include <deque>
#include <limits>
#include <string>
#include <sys/types.h>
#include <utility>
#include <vector>

namespace thermotwin::tools {

class PageLink {
public:
  /// @param command  the program first
  explicit PageLink(std::vector<std::string> command) : command_(std::move(command)) {}
  ~PageLink();
  PageLink(const PageLink&) = delete;
  PageLink& operator=(const PageLink&) = delete;

  /// @param now  boot_s()
  void tend(double now);
  /// @param moment  a row's answer  @param time  s, on the scale of RowClock
  void show(nlohmann::json moment, double time, double now);
  /// Another model: the page is made anew.
  void restart();

private:
  void start(double now);
  void end();
  void send(const std::string& line, bool is_kept);
  void flush();

  std::vector<std::string> command_;
  pid_t process_ = 0;
  int to_ = -1;
  double begun_at_ = 0, next_start_at_ = 0, wait_s_ = 0.5;
  std::string pending_;  ///< of lines, from sent_ on
  std::size_t sent_ = 0;
  double shown_at_ = -std::numeric_limits<double>::infinity();
  std::deque<std::pair<double, std::string>> day_;  ///< time and line, one a minute
};

}  // namespace thermotwin::tools
