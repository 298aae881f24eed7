// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/training_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/missing.h"

namespace thermotwin::compensation {
namespace {

using core::missing;
using Eigen::Index;

/// Inputs before the first row of a stretch: what is measured there, but the machine has rested.
void let_rest(const std::vector<InputInfo>& info, Eigen::Ref<Eigen::RowVectorXd> inputs) {
  for (std::size_t k = 0; k < info.size(); ++k)
    if (info[k].activity && std::isfinite(inputs[k])) inputs[k] = 0.0;
}

}  // namespace

std::vector<Index> usable_inputs(const Dataset& data, const std::vector<bool>& training, InputChoice choice) {
  std::vector<Index> usable;
  for (Index k = 0; k < data.input_values.cols(); ++k) {
    const InputInfo& info = data.inputs[k];
    if (choice == InputChoice::temperatures && !info.temperature) continue;
    if (choice == InputChoice::activity && info.temperature && !info.ambient) continue;
    double low = std::numeric_limits<double>::infinity(), high = -low, known = 0.0, rows = 0.0;
    for (Index i = 0; i < data.rows(); ++i) {
      if (!training[i]) continue;
      rows += 1.0;
      const double value = data.input_values(i, k);
      if (!std::isfinite(value)) continue;
      known += 1.0;
      low = std::min(low, value);
      high = std::max(high, value);
    }
    if (known >= 0.5 * rows && high > low) usable.push_back(k);
  }
  return usable;
}

TrainingData training_data(const Dataset& data, const std::vector<bool>& training, Index target,
                           const std::vector<Index>& used, const std::string& model) {
  const Index rows = std::find(training.rbegin(), training.rend(), true).base() - training.begin();
  std::vector<Index> order;  // row of the data, of each row here
  std::vector<Index> rests;  // rows here that were added
  for (Index i = 0; i < rows; ++i) {
    if (i > 0 && std::binary_search(data.starts.begin(), data.starts.end(), i)) {
      rests.push_back(std::ssize(order));
      order.push_back(i);
    }
    order.push_back(i);
  }
  TrainingData part;
  for (const Index k : used) part.info.push_back(data.inputs[k]);
  part.label = model + " " + data.targets[target].id;
  part.time = data.time(order);
  part.inputs = data.input_values(order, used);
  part.target = data.target_values(order, target);
  for (Index i = 0; i < part.time.size(); ++i)
    if (!training[order[i]]) part.target[i] = missing;
  for (const Index row : rests) {
    part.target[row] = missing;
    part.breaks.insert(part.breaks.end(), {row, row + 1});
    Eigen::RowVectorXd inputs = part.inputs.row(row);
    let_rest(part.info, inputs);
    part.inputs.row(row) = inputs;
    const double last = part.time[row - 1], interval = row > 1 ? last - part.time[row - 2] : 1.0;
    part.time[row] = last + std::min(interval, 0.5 * (part.time[row] - last));
  }
  double longest = 0.0;
  for (std::size_t s = 0; s <= rests.size(); ++s) {
    const Index from = s == 0 ? 0 : rests[s - 1] + 1, to = s < rests.size() ? rests[s] : part.time.size() - 1;
    longest = std::max(longest, part.time[to] - part.time[from]);
  }
  for (const Index row : rests) {
    if (const double more = part.time[row + 1] - part.time[row] - 2.0 * longest; more > 0.0)
      part.time.tail(part.time.size() - row - 1).array() -= more;
  }
  return part;
}

}  // namespace thermotwin::compensation
