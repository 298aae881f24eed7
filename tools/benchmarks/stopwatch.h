// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Time inside a benchmark program, and how it tells what it found.

#include <chrono>
#include <cstdio>
#include <ctime>

namespace thermotwin::bench {

struct Stopwatch {
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); }
};

/// Time that this process had a processor for: what one thread needs, whoever else is at work.
struct ProcessorTime {
  static double now() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }
  double start = now();
  double seconds() const { return now() - start; }
};

inline void print(const char* name, double value) { std::printf("%s %.12g\n", name, value); }

}  // namespace thermotwin::bench
