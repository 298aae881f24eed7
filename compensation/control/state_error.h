// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Why a saved state is refused, for programs that act on the reason.

#include <string>

#include "core/error.h"

namespace thermotwin::compensation {

enum class StateFault {
  damaged,        ///< no state, cut off, or its sum is wrong
  other_version,  ///< saved by another version of thermotwin
  other_model,    ///< of another model, or of the same model with other options
  in_use          ///< another process goes on from it
};

class StateError : public core::InputError {
public:
  /// @param path, value, allowed  as of InputError
  StateError(StateFault fault, const std::string& path, const std::string& value, const std::string& allowed)
      : InputError(path, value, allowed),
        fault_(fault) {}
  StateFault fault() const noexcept { return fault_; }

private:
  StateFault fault_;
};

}  // namespace thermotwin::compensation
