// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
// Words that Fanuc controls mean otherwise than LinuxCNC: dwells in ms (P) and with X or U, G10 by other L words,
// system variables. Text that keeps its meaning stays; a line whose meaning LinuxCNC's interpreter would change is
// refused.

#include <set>
#include <string>

namespace thermotwin::nc::rs274 {

class FanucText {
public:
  /// Variables that any line of a file sets count as set in all files.
  void see(const std::string& line);
  /// @throws std::string  for a line that is refused: the reason, a tab, what is allowed
  std::string line(const std::string& line);

private:
  void require_variables(const std::string& code) const;

  std::set<long> set_;
  bool set_by_number_ = false;  ///< #[...] = sets any variable; a call sets those of its arguments
  bool incremental_ = false, cycle_ = false;
};

}  // namespace thermotwin::nc::rs274
