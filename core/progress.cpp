// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <mutex>
#include <sys/ioctl.h>
#include <unistd.h>

#include "core/error.h"
#include "core/muted_warnings.h"
#include "core/process.h"
#include "core/signals.h"

namespace thermotwin::core {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds bar_interval{100};
constexpr std::chrono::seconds line_interval{10};

/// Stderr and the one progress that may draw on it.
struct Terminal {
  std::mutex mutex;
  std::atomic<bool> quiet{false};
  const void* owner = nullptr;  // guarded by mutex
  bool bar_shown = false;       // guarded by mutex
};

Terminal& terminal() {
  static Terminal instance;
  return instance;
}

bool is_terminal() {
  static const bool result = ::isatty(STDERR_FILENO) != 0;
  return result;
}

std::size_t terminal_width() {
  winsize size{};
  if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  return 80;
}

void put(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

/// A whole line; a bar that stands there is wiped first and drawn again by its next step.
void put_line(const std::string& text) {
  Terminal& screen = terminal();
  const std::lock_guard lock(screen.mutex);
  put(fmt::format("{}{}\n", screen.bar_shown ? "\r\x1b[K" : "", text));
  screen.bar_shown = false;
}

std::string duration_text(double seconds) {
  const long long total = std::llround(std::min(seconds, 1e9));
  if (total < 60) return fmt::format("{} s", total);
  if (total < 3600) return fmt::format("{} min {:02} s", total / 60, total % 60);
  return fmt::format("{} h {:02} min", total / 3600, total / 60 % 60);
}

// A lock-free atomic is as safe in a handler as volatile sig_atomic_t, and in threads too.
std::atomic<int> interrupt_signals{0};
static_assert(std::atomic<int>::is_always_lock_free);

extern "C" void on_interrupt(int) {
  if (interrupt_signals.fetch_add(1) > 0) ::_exit(130);
  end_soon();
}

}  // namespace

struct Progress::State {
  std::string label;
  std::size_t total = 1;
  std::atomic<std::size_t> done{0};
  Clock::time_point start = Clock::now();
  std::atomic<Clock::duration> next_output{Clock::duration::zero()};  // since start
  bool draws = false;                                                 // constant after construction
  bool line_shown = false;                                            // guarded by the terminal's mutex

  Clock::duration interval() const {
    return is_terminal() ? Clock::duration(bar_interval) : Clock::duration(line_interval);
  }

  double elapsed() const { return std::chrono::duration<double>(Clock::now() - start).count(); }

  std::string state_text() const {
    const std::size_t steps = std::min(done.load(), total);
    const double share = 1.0 * steps / total;
    std::string text = fmt::format("{}/{} ({:.0f} %)", steps, total, 100.0 * share);
    if (steps > 0 && steps < total) text += ", " + duration_text(elapsed() * (1.0 / share - 1.0)) + " left";
    return text;
  }

  /// Call with the terminal's mutex held.
  void draw_bar() const {
    const std::string text = " " + state_text();
    const std::size_t room = terminal_width() - 1;
    std::string line = label;
    if (label.size() + text.size() + 12 <= room) {
      const std::size_t width = std::min<std::size_t>(30, room - label.size() - text.size() - 3);
      const std::size_t filled = std::min(done.load(), total) * width / total;
      line += fmt::format(" [{:#<{}}{:.<{}}]", "", filled, "", width - filled);
    }
    line += text;
    put(fmt::format("\r{:.{}}\x1b[K", line, room));
  }

  void show() {
    Terminal& screen = terminal();
    const std::lock_guard lock(screen.mutex);
    if (is_terminal()) {
      draw_bar();
      screen.bar_shown = true;
    } else {
      put(label + ": " + state_text() + "\n");
    }
    line_shown = true;
  }
};

void set_quiet(bool quiet) { terminal().quiet = quiet; }
bool is_quiet() { return terminal().quiet; }

void log_line(const std::string& text) {
  if (!is_quiet()) put_line(text);
}

void warn(const std::string& text) {
  if (!MutedWarnings::any()) put_line("warning: " + text);
}

Progress::Progress(std::string label, std::size_t total) : state_(new State) {
  state_->label = std::move(label);
  state_->total = std::max<std::size_t>(total, 1);
  // A bar at once would flicker for work that ends within a blink.
  state_->next_output = state_->interval();
  Terminal& screen = terminal();
  const std::lock_guard lock(screen.mutex);
  // Within or beside another progress this one is silent: two bars would overwrite each other.
  if (!screen.quiet && screen.owner == nullptr) {
    screen.owner = state_;
    state_->draws = true;
  }
}

Progress::~Progress() {
  if (state_->draws) {
    Terminal& screen = terminal();
    const std::lock_guard lock(screen.mutex);
    screen.owner = nullptr;
    const bool complete = state_->done >= state_->total;
    const std::string seconds = duration_text(state_->elapsed());
    if (state_->line_shown && is_terminal()) {
      put(complete ? fmt::format("\r\x1b[K{}: {} steps in {}\n", state_->label, state_->total, seconds)
                   : std::string(screen.bar_shown ? "\n" : ""));
      screen.bar_shown = false;
    } else if (state_->line_shown && complete) {
      put(fmt::format("{}: {} steps in {}\n", state_->label, state_->total, seconds));
    }
  }
  delete state_;
}

void Progress::advance(std::size_t steps) {
  state_->done.fetch_add(steps);
  if (state_->draws && !is_quiet()) {
    const Clock::duration now = Clock::now() - state_->start;
    Clock::duration due = state_->next_output.load();
    // Of several threads that are due, the one that moves the date draws.
    if (now >= due && state_->next_output.compare_exchange_strong(due, now + state_->interval())) {
      state_->show();
    }
  }
  check_interrupt();
}

void install_interrupt_handler() {
  static std::once_flag once;
  std::call_once(once, [] {
    watch_for_end();
    take_ending_signals(on_interrupt);
  });
}

void check_interrupt() {
  if (interrupt_signals.load(std::memory_order_relaxed) > 0) throw Interrupted();
}

}  // namespace thermotwin::core
