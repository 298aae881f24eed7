// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Error of a refused state file, with the reason as a value for callers that act on it.

#include <string>

#include "core/error.h"

namespace thermotwin::compensation {

enum class StateFault {
  damaged,        ///< not a state file, truncated, or with a wrong checksum
  other_version,  ///< saved by another version of thermotwin
  other_model,    ///< saved by another model, or by the same model with other options
  in_use          ///< another process uses this state file
};

class StateError : public core::InputError {
public:
  /// @param path, value, allowed  see InputError
  StateError(StateFault fault, const std::string& path, const std::string& value, const std::string& allowed)
      : InputError(path, value, allowed),
        fault_(fault) {}
  StateFault fault() const noexcept { return fault_; }

private:
  StateFault fault_;
};

}  // namespace thermotwin::compensation
