// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The data of tt_reading_model from a machine and its channels.

#include <algorithm>
#include <vector>

#include "compensation/control/reading_check.h"
#include "solver/operation/channels.h"

namespace thermotwin::compensation::test {

class ReadingData {
public:
  ReadingData(const mesh::Machine& machine, const solver::Channels& channels) : defaults_(channels.defaults()) {
    for (const mesh::AmbientSpec& ambient : machine.ambients) {
      if (ambient.follows.empty()) ambients_.push_back(channels.index(ambient.id + ".T_C"));
    }
    for (std::int32_t k = 0; k < static_cast<std::int32_t>(channels.size()); ++k) {
      if (!channels.names()[k].ends_with("T_C")) continue;
      temperatures_.push_back(k);
      is_ambient_.push_back(std::find(ambients_.begin(), ambients_.end(), k) != ambients_.end() ? 1 : 0);
    }
    const auto count = [](const auto& values) { return static_cast<std::int32_t>(values.size()); };
    model_ = {machine.plausible_low_C, machine.plausible_high_C, machine.reference_C, count(defaults_),
              count(machine.sensors),  count(temperatures_),     count(ambients_),    temperatures_.data(),
              is_ambient_.data(),      ambients_.data(),         defaults_.data()};
  }
  ReadingData(const ReadingData&) = delete;
  ReadingData& operator=(const ReadingData&) = delete;
  const tt_reading_model& model() const { return model_; }

private:
  Eigen::VectorXd defaults_;
  std::vector<std::int32_t> ambients_, temperatures_, is_ambient_;
  tt_reading_model model_{};
};

}  // namespace thermotwin::compensation::test
