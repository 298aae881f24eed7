// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/load_levels.h"

#include <algorithm>
#include <map>

namespace thermotwin::compensation {

using Eigen::Index;
using Eigen::VectorXd;

Levels load_levels(const Dataset& data, const std::vector<bool>& training) {
  Levels best;
  double longest = 0.0;
  for (std::size_t k = 0; k < data.inputs.size(); ++k) {
    if (!data.inputs[k].activity) continue;
    std::map<double, double> count;
    double on = 0.0, rows = 0.0;
    for (Index i = 0; i < data.rows(); ++i) {
      if (!training[i]) continue;
      rows += 1.0;
      const double value = data.input_values(i, k);
      if (!(value > 0.0)) continue;
      count[value] += 1.0;
      on += 1.0;
    }
    if (on <= longest) continue;
    std::vector<double> values;
    constexpr double least_share = 0.1;
    for (const auto& [value, times] : count) {
      if (times >= least_share * rows) values.push_back(value);
    }
    if (values.empty()) continue;
    longest = on;
    best = {data.inputs[k].id, values};
  }
  return best;
}

VectorXd level_shares(const std::vector<double>& levels, double at) {
  VectorXd shares = VectorXd::Zero(std::max<Index>(std::ssize(levels), 1));
  if (levels.size() < 2 || at <= levels.front()) {
    shares[0] = 1.0;
  } else if (at >= levels.back()) {
    shares[shares.size() - 1] = 1.0;
  } else {
    const auto above = std::upper_bound(levels.begin(), levels.end(), at) - levels.begin();
    const double low = levels[above - 1], high = levels[above];
    shares[above] = (at - low) / (high - low);
    shares[above - 1] = 1.0 - shares[above];
  }
  return shares;
}

VectorXd levels_of_rows(const Dataset& data, const std::string& input, const std::vector<double>& levels) {
  VectorXd level = VectorXd::Constant(data.rows(), levels.empty() ? 0.0 : levels.front());
  for (std::size_t k = 0; k < data.inputs.size(); ++k) {
    if (data.inputs[k].id != input) continue;
    double last = levels.empty() ? 0.0 : levels.front();
    for (Index i = 0; i < data.rows(); ++i) {
      const double value = data.input_values(i, k);
      if (value > 0.0) last = value;
      level[i] = last;
    }
  }
  return level;
}

}  // namespace thermotwin::compensation
