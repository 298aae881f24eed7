// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/module_programs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"

namespace thermotwin::compensation {
namespace {

using core::InputError;
using Eigen::Index;

/// Whether the input of a control stands for the machine being on, not for something that it does.
bool is_standby(const InputInfo& info) {
  return info.input == "machine.on" || (info.input.starts_with("coolant.") && info.input.ends_with(".on"));
}

}  // namespace

std::vector<ModuleProgram> module_programs(const TrainingData& data) {
  std::vector<ModuleProgram> programs;
  Index from = 0;
  for (std::size_t i = 0; i <= data.breaks.size(); i += 2) {
    const Index to = i < data.breaks.size() ? data.breaks[i] : data.time.size();
    bool on = false, works = false;
    for (Index k = 0; k < std::ssize(data.info); ++k) {
      if (data.info[k].temperature) continue;
      const bool any = (data.inputs.col(k).segment(from, to - from).array() > 0.0).any();
      (is_standby(data.info[k]) ? on : works) |= any;
    }
    programs.push_back({from, to, works ? ProgramKind::internal : on ? ProgramKind::ambient : ProgramKind::baseline});
    if (i < data.breaks.size()) from = data.breaks[i + 1];
  }
  return programs;
}

std::array<Index, 2> ambient_sensors(const TrainingData& data, const std::vector<Index>& temperatures,
                                     const std::vector<ModuleProgram>& programs) {
  struct Candidate {
    double spread, moved;
    Index input;
  };
  std::vector<Candidate> candidates;
  for (const Index k : temperatures) {
    double sum = 0.0, squares = 0.0, count = 0.0;
    for (const ModuleProgram& program : programs) {
      if (program.kind != ProgramKind::internal) continue;
      const auto [low, high] = [&] {
        double least = std::numeric_limits<double>::infinity(), most = -least;
        for (const double value : data.inputs.col(k).segment(program.from, program.to - program.from)) {
          if (!std::isfinite(value)) continue;
          least = std::min(least, value);
          most = std::max(most, value);
        }
        return std::pair{least, most};
      }();
      if (!(high >= low)) continue;
      sum += high - low;
      squares += (high - low) * (high - low);
      count += 1.0;
    }
    if (count < 1.0) continue;
    candidates.push_back({squares / count - sum * sum / (count * count), sum / count, k});
  }
  if (candidates.size() < 2) {
    throw InputError(data.label,
                     fmt::format("{} temperature{} of the machine with readings at work", candidates.size(),
                                 candidates.size() == 1 ? "" : "s"),
                     "at least two");
  }
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.spread < b.spread; });
  const bool ordered = candidates[0].moved <= candidates[1].moved;
  return {candidates[ordered ? 0 : 1].input, candidates[ordered ? 1 : 0].input};
}

}  // namespace thermotwin::compensation
