// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What must hold whatever the bytes were: said, then the fuzzer keeps the input that broke it.

#include <cstdio>
#include <cstdlib>

inline void require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}
