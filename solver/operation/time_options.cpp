// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/operation/time_options.h"

#include <algorithm>

#include "core/error.h"

namespace thermotwin::solver {

using core::InputError;
using core::Node;

TimeOptions read_time(const Node& node) {
  TimeOptions time;
  const std::string scheme = node.choice_or("scheme", "adaptive", {"fixed", "backward_euler", "adaptive"});
  if (scheme == "adaptive") {
    time.scheme = TimeScheme::adaptive;
    time.tolerance_K = node.number_or("tolerance_K", time.tolerance_K, {1e-8, 10.0});
    time.shortest_step = node.number_or("shortest_step_s", time.shortest_step, {1e-6, 1e6});
    time.longest_step =
        node.number_or("longest_step_s", std::max(time.longest_step, time.shortest_step), {time.shortest_step, 1e7});
  } else {
    if (scheme == "backward_euler") time.scheme = TimeScheme::backward_euler;
    for (const char* key : {"tolerance_K", "shortest_step_s", "longest_step_s"})
      if (node.has(key))
        throw InputError(node.place(key), "a key of the adaptive scheme",
                         "scheme = \"adaptive\", or time_step_s of the load");
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
