// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/surroundings.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/units.h"

namespace thermotwin::diagnosis {

namespace {

using core::units::hour;

/// Surroundings may wander that fast, or slower in a long record: those that nobody measures (a tank
/// of cutting fluid warms within an hour), and what a measured one still leaves out.
constexpr double unmeasured_knot_s = 1.0 * hour, measured_knot_s = 3.0 * hour;
constexpr int most_knots = 30;
constexpr double measured_air_std_K = 0.1, unmeasured_std_K = 0.3;

/// How far a measured temperature wanders in the record.
double spread_K(const compensation::Measurement& measurement, const std::string& input) {
  const auto channel = std::find_if(measurement.channels.begin(), measurement.channels.end(),
                                    [&](const auto& c) { return c.input == input; });
  std::vector<double> values;
  for (const double value : measurement.data.values.col(channel->column))
    if (std::isfinite(value)) values.push_back(value);
  const auto all = Eigen::Map<const Eigen::ArrayXd>(values.data(), std::ssize(values));
  return values.empty() ? 0.0 : std::sqrt((all - all.mean()).square().mean());
}

/// Surroundings wander: those that nobody measures by their stated uncertainty, air by what a
/// single sensor in a hall cannot see, and in a pause of the log by half of what it does in the record.
void add_surroundings(const mesh::Machine& machine, const compensation::Measurement& measurement,
                      const Observations& obs, int record, std::vector<Disturbance>& all) {
  for (int a = 0; a < std::ssize(machine.ambients); ++a) {
    const mesh::AmbientSpec& ambient = machine.ambients[a];
    const auto add = [&](double from, double to, double knot_s, int fewest, bool with_ends, double std_K) {
      const int knots = std::clamp<long>(std::lround((to - from) / knot_s), fewest, most_knots);
      const double width = (to - from) / knots;
      for (int k = with_ends ? 0 : 1; k < knots + (with_ends ? 1 : 0); ++k) {
        const double peak = from + width * k;
        all.push_back({a, peak - width, peak, peak + width, std_K, record});
      }
    };
    const std::string input = ambient.id + ".T_C";
    const bool measured = std::any_of(measurement.channels.begin(), measurement.channels.end(),
                                      [&](const auto& channel) { return channel.input == input; });
    const double stated = std::abs(ambient.default_C.value) * ambient.default_C.std_percent / 100.0;
    add(obs.start, obs.end, measured ? measured_knot_s : unmeasured_knot_s, 2, true,
        measured ? measured_air_std_K : std::max(unmeasured_std_K, stated));
    if (!measured) continue;
    const double std_K = 0.5 * spread_K(measurement, input);
    double paused = 0.0;
    for (const Observations::OpenChange& pause : obs.pauses) paused += pause.shown - pause.from;
    const double knot_s = std::max(unmeasured_knot_s, paused / most_knots);
    for (const Observations::OpenChange& pause : obs.pauses) add(pause.from, pause.shown, knot_s, 1, false, std_K);
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
