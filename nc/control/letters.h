// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The nine coordinates of an NC program, in the order X Y Z A B C U V W.

#include <Eigen/Core>

#include <array>
#include <string>

namespace thermotwin::nc {

/// Values of the letters: m for X Y Z U V W, rad for A B C.
using Nine = Eigen::Matrix<double, 9, 1>;

inline constexpr std::array<char, 9> letters{'X', 'Y', 'Z', 'A', 'B', 'C', 'U', 'V', 'W'};
inline constexpr bool is_angle(int letter) { return letter >= 3 && letter < 6; }

}  // namespace thermotwin::nc
