// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/measurement/dataset.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/missing.h"
#include "core/statistics.h"

namespace thermotwin::compensation {

using core::missing;
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Time, s, for which a reading stands: until the next one is due, after the gap that nine of ten readings keep. A row
/// that comes a little early may be that of the next reading. Rows of other loggers lie between.
double standing_time(const VectorXd& time, const VectorXd& values) {
  constexpr double early = 0.25, early_rows = 0.5;
  std::vector<double> gaps, steps;
  Index last = -1;
  for (Index i = 0; i < values.size(); ++i) {
    if (i > 0) steps.push_back(time[i] - time[i - 1]);
    if (!std::isfinite(values[i])) continue;
    if (last >= 0) gaps.push_back(time[i] - time[last]);
    last = i;
  }
  if (gaps.empty()) return 0.0;
  const double gap = core::nth_smallest(gaps, (std::ssize(gaps) - 1) * 9 / 10);
  return gap - std::min(early * gap, early_rows * core::median(std::move(steps)));
}

VectorXd held(const Eigen::Ref<const VectorXd>& time, const Eigen::Ref<const VectorXd>& values, double standing) {
  VectorXd result = values;
  Index last = -1;
  for (Index i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i])) {
      last = i;
    } else {
      result[i] = last >= 0 && time[i] - time[last] < standing ? values[last] : missing;
    }
  }
  return result;
}

/// Rows of programs that begin after a pause, and the first row.
std::vector<Index> find_starts(const VectorXd& time, const std::vector<Program>& programs) {
  constexpr double least_pause_s = 3600.0, least_intervals = 10.0;
  std::vector<Index> starts{0};
  if (programs.empty() || time.size() < 2) return starts;
  std::vector<double> gaps;
  for (Index i = 1; i < time.size(); ++i) gaps.push_back(time[i] - time[i - 1]);
  const double pause = std::max(least_pause_s, least_intervals * core::median(std::move(gaps)));
  for (const Program& program : programs) {
    const Index row = std::lower_bound(time.begin(), time.end(), program.from_s) - time.begin();
    if (row > starts.back() && row < time.size() && time[row] - time[row - 1] > pause) starts.push_back(row);
  }
  return starts;
}

bool names_air(const MeasuredChannel& channel) {
  if (channel.input == "air.T_C") return true;
  for (std::string word : {channel.id, channel.sensor, channel.input, channel.direction}) {
    std::transform(word.begin(), word.end(), word.begin(), [](unsigned char c) { return std::tolower(c); });
    for (const char* piece : {"amb", "air", "hall", "room", "environment"}) {
      if (word.find(piece) != std::string::npos) return true;
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
  data.starts = find_starts(data.time, measurement.programs);
  std::vector<VectorXd> inputs, targets;
  for (const MeasuredChannel& channel : measurement.channels) {
    VectorXd values = measurement.values(channel);
    if (channel.kind == ChannelKind::displacement) {
      for (std::size_t s = 0; channel.zero == Zero::first && s < data.starts.size(); ++s) {
        auto stretch = values.segment(data.starts[s], data.stretch_end(s) - data.starts[s]);
        const Index first = known_range(stretch).first;
        if (first < 0) continue;
        const double zero = stretch[first];
        stretch.array() -= zero;
      }
      data.targets.push_back(channel);
      targets.push_back(std::move(values));
    } else if (channel.kind != ChannelKind::position) {
      const bool temperature = channel.kind == ChannelKind::temperature;
      const bool activity = channel.kind == ChannelKind::speed || channel.kind == ChannelKind::power;
      if (activity) values = values.cwiseAbs();  // heat does not know which way an axis turns
      data.inputs.push_back({channel.id, temperature, activity, temperature && names_air(channel),
                             channel.kind == ChannelKind::speed, channel.input});
      // Nothing is held over a pause.
      const double standing = temperature ? standing_time(data.time, values) : std::numeric_limits<double>::infinity();
      for (std::size_t s = 0; s < data.starts.size(); ++s) {
        const Index first = data.starts[s], count = data.stretch_end(s) - first;
        auto stretch = values.segment(first, count);
        stretch = held(data.time.segment(first, count), stretch, standing);
      }
      inputs.push_back(std::move(values));
    }
  }
  data.input_values.resize(data.rows(), std::ssize(inputs));
  data.target_values.resize(data.rows(), std::ssize(targets));
  for (std::size_t i = 0; i < inputs.size(); ++i) data.input_values.col(i) = inputs[i];
  for (std::size_t i = 0; i < targets.size(); ++i) data.target_values.col(i) = targets[i];
  return data;
}

namespace {

template <class Item>
void add_new(std::vector<Item>& items, const std::vector<Item>& more) {
  for (const Item& item : more) {
    if (std::none_of(items.begin(), items.end(), [&](const Item& known) { return known.id == item.id; }))
      items.push_back(item);
  }
}

}  // namespace

Dataset join_datasets(const std::vector<const Dataset*>& pieces) {
  constexpr double pause_s = 2 * 86400.0;
  Dataset all;
  all.starts.clear();
  Index rows = 0;
  for (const Dataset* piece : pieces) {
    all.source += (all.source.empty() ? "" : ", ") + piece->source;
    add_new(all.inputs, piece->inputs);
    add_new(all.targets, piece->targets);
    rows += piece->rows();
  }
  all.time.resize(rows);
  all.input_values.resize(rows, std::ssize(all.inputs));
  for (std::size_t k = 0; k < all.inputs.size(); ++k)
    all.input_values.col(k).setConstant(all.inputs[k].activity ? 0.0 : missing);
  all.target_values = MatrixXd::Constant(rows, std::ssize(all.targets), missing);
  Index row = 0;
  for (const Dataset* piece : pieces) {
    const Index n = piece->rows();
    const double shift = row == 0 ? 0.0 : all.time[row - 1] + pause_s - piece->time[0];
    all.time.segment(row, n) = piece->time.array() + shift;
    for (const Index start : piece->starts) all.starts.push_back(row + start);
    const auto put = [&](auto& values, const auto& items, const auto& own, const MatrixXd& own_values) {
      for (std::size_t k = 0; k < own.size(); ++k) {
        const auto at =
            std::find_if(items.begin(), items.end(), [&](const auto& item) { return item.id == own[k].id; }) -
            items.begin();
        values.col(at).segment(row, n) = own_values.col(k);
      }
    };
    put(all.input_values, all.inputs, piece->inputs, piece->input_values);
    put(all.target_values, all.targets, piece->targets, piece->target_values);
    row += n;
  }
  return all;
}

double TrainingData::measured_time() const {
  if (time.size() == 0) return 0.0;
  double sum = time[time.size() - 1] - time[0];
  for (std::size_t i = 0; i + 1 < breaks.size(); i += 2) sum -= time[breaks[i + 1]] - time[breaks[i]];
  return sum;
}

Index ambient_input(const std::vector<InputInfo>& info) {
  const auto at = std::find_if(info.begin(), info.end(), [](const InputInfo& i) { return i.ambient; });
  return at == info.end() ? -1 : at - info.begin();
}

Blocks make_blocks(const TrainingData& data, Index most) {
  const Index n = data.time.size();
  if (n <= most) return {data, false};
  const double span = data.measured_time(), width = span / most;
  const double gap = std::max(3.0 * width, 10.0 * span / n);
  Blocks blocks{{data.label, data.info, VectorXd(n), MatrixXd(n, data.inputs.cols()), VectorXd(n)}, true};
  Index count = 0;
  const auto breaks = [&](Index row) { return std::binary_search(data.breaks.begin(), data.breaks.end(), row); };
  for (Index begin = 0; begin < n;) {
    Index end = begin + 1;
    while (end < n && !breaks(end) && data.time[end] - data.time[begin] < width &&
           data.time[end] - data.time[end - 1] < gap)
      ++end;
    const double rows = end - begin;
    blocks.data.time[count] =
        data.time[begin] + (data.time.segment(begin, end - begin).array() - data.time[begin]).sum() / rows;
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
