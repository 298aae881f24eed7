// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/plan/plan_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/error.h"
#include "core/range.h"
#include "core/text.h"
#include "core/units.h"

namespace thermotwin::metrology {

namespace units = core::units;
using core::InputError;
using mesh::Axis;
using mesh::AxisKind;
using mesh::Machine;

const std::vector<std::string>& test_kinds() {
  static const std::vector<std::string> kinds = {"rtest",       "rtest_continuous", "rtest_grid",
                                                 "etve",        "spindle",          "linear_axis",
                                                 "rotary_axis", "random_cycle",     "volumetric_grid"};
  return kinds;
}

TestKind test_kind(const std::string& word) {
  const auto& kinds = test_kinds();
  const auto found = std::find(kinds.begin(), kinds.end(), word);
  if (found != kinds.end()) return static_cast<TestKind>(found - kinds.begin());
  throw InputError("kind of a test", "'" + word + "'",
                   core::join(kinds) + " (nearest: " + core::nearest(word, kinds) + ")");
}

void PlanOptions::validate() const {
  const std::string of = "plan options: ";
  core::require_within(of + "warm_up_h", warm_up_h, {0.0, 1000.0});
  core::require_within(of + "cool_down_h", cool_down_h, {0.0, 1000.0});
  core::require_within(of + "interval_min", interval_min, {0.1, 1440.0});
  core::require_within(of + "radius_mm", radius_mm, {0.0, 1e5});
  core::require_within(of + "clearance_mm", clearance_mm, core::non_negative);
  core::require_within(of + "speed", speed, core::non_negative);
  core::require_within(of + "feed_deg_min", feed_deg_min, {1.0, 1e6});
  core::require_within(of + "feed_mm_min", feed_mm_min, {1.0, 1e6});
  core::require_within(of + "rate_Hz", rate_Hz, {0.1, 1e4});
  core::require_within(of + "change_percent", change_percent, {0.0, 100.0});
  core::require_within(of + "cut_s", cut_s, core::non_negative);
  core::require_option(record_s > 2.0 * cut_s, of + "record_s", record_s, "more than twice cut_s");
  core::require_option(!azimuths_deg.empty() && (azimuths_deg.size() == 1 || kind != TestKind::rtest_continuous),
                       of + "azimuths_deg", azimuths_deg.size(), "one sphere or more; one for a continuous test");
  for (const auto* pair : {&range, &speeds}) {
    if (pair->empty() || (pair->size() == 2 && (*pair)[0] <= (*pair)[1])) continue;
    throw InputError(of + (pair == &range ? "range" : "speeds"), fmt::format("{}", fmt::join(*pair, ",")),
                     "two rising numbers");
  }
}

std::pair<double, double> load_range(const Machine& machine, int axis, const PlanOptions& options) {
  const Axis& of = machine.axes[axis];
  const double unit = of.kind == AxisKind::linear ? units::mm : units::deg;
  if (options.range.size() == 2) return {options.range[0] * unit, options.range[1] * unit};
  const double margin = 0.1 * (of.high - of.low);
  return {of.low + margin, of.high - margin};
}

}  // namespace thermotwin::metrology
