// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/operation/time_options.h"

#include <algorithm>

#include "core/error.h"

namespace thermotwin::solver {

using core::InputError;
using core::Node;

namespace {

constexpr core::Range tolerances_K{1e-8, 10.0}, shortest_steps{1e-6, 1e6};

core::Range longest_steps(const TimeOptions& time) { return {time.shortest_step, 1e7}; }

}  // namespace

void TimeOptions::validate() const {
  if (scheme != TimeScheme::adaptive) return;
  const std::string of = "time options: ";
  core::require_within(of + "tolerance_K", tolerance_K, tolerances_K);
  core::require_within(of + "shortest_step", shortest_step, shortest_steps);
  core::require_within(of + "longest_step", longest_step, longest_steps(*this));
}

TimeOptions read_time(const Node& node) {
  TimeOptions time;
  const std::string scheme = node.choice("scheme");
  if (scheme == "adaptive") {
    time.scheme = TimeScheme::adaptive;
    time.tolerance_K = node.number("tolerance_K");
    time.shortest_step = node.number("shortest_step_s");
    time.longest_step =
        node.number_or("longest_step_s", std::max(time.longest_step, time.shortest_step), longest_steps(time));
  } else {
    if (scheme == "backward_euler") time.scheme = TimeScheme::backward_euler;
    for (const char* key : {"tolerance_K", "shortest_step_s", "longest_step_s"}) {
      if (node.has(key)) {
        throw InputError(node.place(key), "a key of the adaptive scheme",
                         "scheme = \"adaptive\", or time_step_s of the load");
      }
    }
  }
  node.finish();
  return time;
}

std::string word(TimeScheme scheme) {
  switch (scheme) {
    case TimeScheme::backward_euler: return "backward_euler";
    case TimeScheme::adaptive: return "adaptive";
    default: return "fixed";
  }
}

}  // namespace thermotwin::solver
