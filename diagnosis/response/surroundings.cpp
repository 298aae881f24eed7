// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/surroundings.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/units.h"

namespace thermotwin::diagnosis {

namespace {

using core::units::hour;

/// Surroundings may wander that fast, or slower in a long record: those that nobody measures (a tank
/// of cutting fluid warms within an hour), and what a measured one still leaves out.
constexpr double unmeasured_knot_s = 1.0 * hour, measured_knot_s = 3.0 * hour;
constexpr int most_knots = 30;
constexpr double measured_air_std_K = 0.1, unmeasured_std_K = 0.3;

/// Surroundings wander: those that nobody measures by their stated uncertainty, air by what a
/// single sensor in a hall cannot see.
void add_surroundings(const mesh::Machine& machine, const compensation::Measurement& measurement,
                      const Observations& obs, int record, std::vector<Disturbance>& all) {
  const double duration = obs.end - obs.start;
  for (int a = 0; a < std::ssize(machine.ambients); ++a) {
    const mesh::AmbientSpec& ambient = machine.ambients[a];
    const bool measured = std::any_of(measurement.channels.begin(), measurement.channels.end(),
                                      [&](const auto& channel) { return channel.input == ambient.id + ".T_C"; });
    const double stated = std::abs(ambient.default_C.value) * ambient.default_C.std_percent / 100.0;
    const double std_K = measured ? measured_air_std_K : std::max(unmeasured_std_K, stated);
    const double knot_s = measured ? measured_knot_s : unmeasured_knot_s;
    const int knots = std::clamp<long>(std::lround(duration / knot_s), 2, most_knots);
    const double width = duration / knots;
    for (int k = 0; k <= knots; ++k) {
      const double peak = obs.start + width * k;
      all.push_back({a, peak - width, peak, peak + width, std_K, record});
    }
  }
}

}  // namespace

std::vector<Disturbance> surroundings(const mesh::Machine& machine, Records records, const Observations& obs) {
  std::vector<Disturbance> all;
  for (std::size_t k = 0; k < records.size(); ++k)
    add_surroundings(machine, records[k], obs.each()[k], static_cast<int>(k), all);
  return all;
}

}  // namespace thermotwin::diagnosis
