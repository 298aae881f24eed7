// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/muted_warnings.h"

#include <atomic>

namespace thermotwin::core {

namespace {

std::atomic<int>& count() {
  static std::atomic<int> of_living{0};
  return of_living;
}

}  // namespace

MutedWarnings::MutedWarnings() { ++count(); }
MutedWarnings::~MutedWarnings() { --count(); }
bool MutedWarnings::any() { return count() > 0; }

}  // namespace thermotwin::core
