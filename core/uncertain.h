// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A nominal value with its uncertainty: `5.0` or `{value = 5.0, std_percent = 10}` in a case file.

namespace thermotwin::core {

struct Uncertain {
  double value = 0.0;
  double std_percent = 0.0;  ///< one standard deviation
};

}  // namespace thermotwin::core
