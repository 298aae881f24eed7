// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/steps_seen.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solver/operation/channels.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::VectorXd;

StepsSeen steps_seen(const Problem& problem, const SearchResult& found) {
  StepsSeen seen;
  constexpr double likely = 0.5;
  if (found.probability_unknown < likely) return seen;
  const bool beside = found.probability_leftover > 0.5 * found.probability_unknown;
  const ReadingSteps& steps = beside ? found.beside_steps : found.unknown_steps;
  for (const std::size_t k : steps.channels) seen.channels.push_back(problem.observations.channels[k].channel.id);
  if (!seen.channels.empty()) {
    const ObservedChannel& first = problem.observations.channels[steps.channels.front()];
    seen.unit = first.channel.unit;
    seen.record = static_cast<std::size_t>(first.record);
  }
  seen.quantity = steps.quantity;
  if (!seen.quantity.empty()) {
    for (const std::size_t k : steps.channels) {
      const compensation::MeasuredChannel& channel = problem.observations.channels[k].channel;
      if (channel.quantity == seen.quantity) seen.unit = channel.unit;
    }
  }
  seen.steps = steps.steps;
  return seen;
}

std::vector<std::string> inputs_before(const Observations& observations, const mesh::Machine& machine,
                                       const StepsSeen& seen) {
  constexpr double before_s = 1800.0, after_s = 60.0, least_share = 0.05;
  constexpr std::size_t most = 4;
  const solver::Channels channels(machine);
  std::vector<std::string> states, others;
  const Observations& record = observations.each()[seen.record];
  for (Index c = 0; c < std::min<Index>(channels.size(), record.rows.cols()); ++c) {
    const std::string& name = channels.names()[c];
    const auto ends = [&](const char* end) { return name.ends_with(end); };
    const bool is_state = ends(".on") || ends(".open");
    if (!is_state && !ends("_rpm") && !ends("_min") && !ends(".power_W")) continue;
    const VectorXd values = record.rows.col(c);
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const double value : values) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
    if (!(high > low)) continue;
    const auto near = [&](double time) {
      return std::any_of(seen.steps.begin(), seen.steps.end(), [&](const ReadingStep& step) {
        return time > step.from_s - before_s && time < step.from_s + after_s;
      });
    };
    bool found = false;
    for (Index i = 1; i < values.size() && !found; ++i)
      found = std::abs(values[i] - values[i - 1]) > least_share * (high - low) && near(record.points[i]);
    if (found) (is_state ? states : others).push_back(name);
  }
  states.insert(states.end(), others.begin(), others.end());
  if (states.size() > most) states.resize(most);
  return states;
}

}  // namespace thermotwin::diagnosis
