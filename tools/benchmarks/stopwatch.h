// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Time inside a benchmark program, and how it tells what it found.

#include <chrono>
#include <cstdio>

namespace thermotwin::bench {

struct Stopwatch {
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); }
};

inline void print(const char* name, double value) { std::printf("%s %.12g\n", name, value); }

}  // namespace thermotwin::bench
