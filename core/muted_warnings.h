// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Work whose warnings are no concern of the user's: that on a second mesh, which only checks the first.

namespace thermotwin::core {

/// core::warn() is silent, in all threads, as long as one of these lives.
class MutedWarnings {
public:
  MutedWarnings();
  ~MutedWarnings();
  MutedWarnings(const MutedWarnings&) = delete;
  MutedWarnings& operator=(const MutedWarnings&) = delete;
  static bool any();  ///< whether one lives
};

}  // namespace thermotwin::core
