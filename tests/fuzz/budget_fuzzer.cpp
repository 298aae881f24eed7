// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes are an uncertainty budget or an InputError. A budget propagates to finite numbers, or is an InputError
// where a formula is not defined beside the estimates.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/error.h"
#include "metrology/budget/budget.h"
#include "metrology/budget/gum.h"
#include "metrology/budget/monte_carlo.h"
#include "tests/fuzz/require.h"

using namespace thermotwin;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    metrology::Budget budget =
        metrology::Budget::parse(std::string(reinterpret_cast<const char*>(data), size), "fuzz.toml");
    require(!budget.inputs.empty() && !budget.quantities.empty(), "a budget has inputs and measurands");
    const metrology::GumResult linear = metrology::gum(budget);
    require(linear.value.array().isFinite().all(), "estimates are finite");
    require((linear.std.array() >= 0.0 || linear.std.array().isNaN()).all(), "no negative uncertainty");
    budget.draws = 100;
    const metrology::MonteCarloResult drawn = metrology::monte_carlo(budget);
    for (const metrology::CoverageInterval& at : drawn.symmetric)
      require(at.low <= at.high, "an interval has its order");
  } catch (const core::InputError&) {}
  return 0;
}
