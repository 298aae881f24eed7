// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Records that models are tested on: inputs over irregular times, and fits on their beginning.

#include <cmath>

#include "compensation/models/channel_model.h"
#include "tests/compensation/uniform.h"

namespace thermotwin::compensation::test {

struct Record {
  Eigen::VectorXd time;
  Eigen::MatrixXd temperatures;
};

/// Irregular times and three temperatures that wander on different time scales.
inline Record wandering(Eigen::Index n, unsigned seed) {
  Uniform uniform(seed);
  Record record{Eigen::VectorXd(n), Eigen::MatrixXd(n, 3)};
  double t = 100.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    record.time[i] = t;
    record.temperatures.row(i) << 20 + std::sin(t / 4000), 21 + 2 * std::cos(t / 9000),
        22 + 0.5 * std::sin(t / 700) * uniform();
    t += 5.0 + 20.0 * uniform();
  }
  return record;
}

inline std::vector<InputInfo> temperature_inputs(Eigen::Index count) {
  std::vector<InputInfo> info;
  for (Eigen::Index i = 0; i < count; ++i) info.push_back({"T" + std::to_string(i + 1), true, false, false});
  return info;
}

inline void fit(ChannelModel& model, const Record& record, const Eigen::VectorXd& target, Eigen::Index rows) {
  model.fit({"test", temperature_inputs(record.temperatures.cols()), record.time.head(rows),
             record.temperatures.topRows(rows), target.head(rows)});
}

inline Eigen::VectorXd predict(const ChannelModel& model, const Record& record) {
  return model.predict(record.time, record.temperatures);
}

}  // namespace thermotwin::compensation::test
