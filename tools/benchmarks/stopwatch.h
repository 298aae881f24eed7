// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Time inside a benchmark program, and how it tells what it found.

#include <cstdio>
#include <ctime>

namespace thermotwin::bench {

/// One thread: time that this process had a processor for, which other work on the machine hardly
/// changes. More threads, and one that is compared with them: wall time, on a machine that does nothing else.
class Watch {
public:
  explicit Watch(int threads = 1, bool wall = false)
      : clock_(threads == 1 && !wall ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC),
        start_(now()) {}
  double seconds() const { return now() - start_; }
  void restart() { start_ = now(); }

private:
  double now() const {
    timespec time{};
    clock_gettime(clock_, &time);
    return time.tv_sec + 1e-9 * time.tv_nsec;
  }
  clockid_t clock_;
  double start_;
};

inline void print(const char* name, double value) { std::printf("%s %.12g\n", name, value); }

}  // namespace thermotwin::bench
