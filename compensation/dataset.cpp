// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/dataset.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double missing = std::numeric_limits<double>::quiet_NaN();

/// Rows for which a reading stands: up to the gap that nine of ten readings keep.
Index typical_gap(const VectorXd& values) {
  std::vector<Index> gaps;
  Index last = -1;
  for (Index i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    if (last >= 0) gaps.push_back(i - last);
    last = i;
  }
  if (gaps.empty()) return 1;
  const auto at = gaps.begin() + static_cast<std::ptrdiff_t>((gaps.size() - 1) * 9 / 10);
  std::nth_element(gaps.begin(), at, gaps.end());
  return *at;
}

VectorXd held(const VectorXd& values, Index longest) {
  VectorXd result = values;
  Index last = -1;
  for (Index i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i])) {
      last = i;
    } else {
      result[i] = last >= 0 && i - last < longest ? values[last] : missing;
    }
  }
  return result;
}

bool names_air(const MeasuredChannel& channel) {
  if (channel.input == "air.T_C") return true;
  for (std::string word : {channel.id, channel.sensor, channel.input, channel.direction}) {
    std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::tolower(c); });
    for (const char* part : {"amb", "air", "hall", "room", "environment"}) {
      if (word.find(part) != std::string::npos) return true;
    }
  }
  return false;
}

}  // namespace

std::pair<Index, Index> known_range(const VectorXd& values) {
  std::pair<Index, Index> range{-1, -1};
  for (Index i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    if (range.first < 0) range.first = i;
    range.second = i;
  }
  return range;
}

Dataset make_dataset(const Measurement& measurement) {
  Dataset data;
  data.source = measurement.folder.string();
  data.time = measurement.time();
  std::vector<VectorXd> inputs, targets;
  for (const MeasuredChannel& channel : measurement.channels) {
    VectorXd values = measurement.values(channel);
    if (channel.kind == ChannelKind::displacement) {
      const Index first = known_range(values).first;
      if (channel.zero == Zero::first && first >= 0) values.array() -= double(values[first]);
      data.targets.push_back(channel);
      targets.push_back(std::move(values));
    } else if (channel.kind != ChannelKind::position) {
      const bool temperature = channel.kind == ChannelKind::temperature;
      const bool activity = channel.kind == ChannelKind::speed || channel.kind == ChannelKind::power;
      if (activity) values = values.cwiseAbs();  // heat does not know which way an axis turns
      data.inputs.push_back({channel.id, temperature, activity, temperature && names_air(channel), channel.kind == ChannelKind::speed, channel.input});
      inputs.push_back(held(values, temperature ? typical_gap(values) : values.size()));
    }
  }
  data.input_values.resize(data.rows(), static_cast<Index>(inputs.size()));
  data.target_values.resize(data.rows(), static_cast<Index>(targets.size()));
  for (std::size_t i = 0; i < inputs.size(); ++i) data.input_values.col(static_cast<Index>(i)) = inputs[i];
  for (std::size_t i = 0; i < targets.size(); ++i) data.target_values.col(static_cast<Index>(i)) = targets[i];
  return data;
}

std::vector<Index> TrainingData::complete_rows() const {
  std::vector<Index> rows;
  for (Index i = 0; i < target.size(); ++i) {
    if (std::isfinite(target[i]) && inputs.row(i).allFinite()) rows.push_back(i);
  }
  return rows;
}

Blocks make_blocks(const TrainingData& data, Index most) {
  const Index n = data.time.size();
  if (n <= most) return {data, false};
  const double span = data.time[n - 1] - data.time[0], width = span / static_cast<double>(most);
  const double gap = std::max(3.0 * width, 10.0 * span / static_cast<double>(n));
  Blocks blocks{{data.label, data.info, VectorXd(n), MatrixXd(n, data.inputs.cols()), VectorXd(n)}, true};
  Index count = 0;
  for (Index begin = 0; begin < n;) {
    Index end = begin + 1;
    while (end < n && data.time[end] - data.time[begin] < width && data.time[end] - data.time[end - 1] < gap) ++end;
    const auto rows = static_cast<double>(end - begin);
    blocks.data.time[count] = data.time[begin] + (data.time.segment(begin, end - begin).array() - data.time[begin]).sum() / rows;
    // A block is known where any of its rows is: a missing reading among many is no gap.
    const auto mean = [&](const auto& values) {
      double sum = 0.0, known = 0.0;
      for (Index i = begin; i < end; ++i) {
        if (!std::isfinite(values[i])) continue;
        sum += values[i];
        known += 1.0;
      }
      return known > 0.0 ? sum / known : missing;
    };
    for (Index k = 0; k < data.inputs.cols(); ++k) blocks.data.inputs(count, k) = mean(data.inputs.col(k));
    blocks.data.target[count] = mean(data.target);
    ++count;
    begin = end;
  }
  blocks.data.time.conservativeResize(count);
  blocks.data.inputs.conservativeResize(count, Eigen::NoChange);
  blocks.data.target.conservativeResize(count);
  return blocks;
}

}  // namespace thermotwin::compensation
