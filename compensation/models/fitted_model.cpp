// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/fitted_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "compensation/models/load_levels.h"
#include "compensation/models/rotary_unit.h"
#include "compensation/models/training_rows.h"
#include "compensation/models/workspace_weights.h"
#include "core/error.h"
#include "core/missing.h"
#include "core/units.h"

namespace thermotwin::compensation {

using core::missing;
namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

std::string group_of(const MeasuredChannel& channel) {
  return channel.quantity.empty() ? channel.direction : channel.quantity;
}

/// A displacement of one side only.
bool is_side(const MeasuredChannel& channel) { return channel.direction == "tool" || channel.direction == "table"; }

}  // namespace

bool FittedModel::add_member(const Dataset& data, const std::vector<bool>& training, Index target) {
  const MeasuredChannel& channel = data.targets[target];
  const std::vector<Index> used = usable_inputs(data, training, parts_.spec->inputs);
  try {
    if (used.empty()) {
      throw InputError(name() + " " + channel.id,
                       parts_.spec->inputs == InputChoice::temperatures
                           ? "no temperature that varies in the training rows"
                       : parts_.spec->inputs == InputChoice::activity
                           ? "no speed, power, flow or state that varies in the training rows"
                           : "no input that varies in the training rows",
                       "at least one");
    }
    const TrainingData own = training_data(data, training, target, used, name());
    std::unique_ptr<ChannelModel> model = parts_.spec->make();
    model->fit(own);
    std::string caution = model->caution();
    parts_.members.push_back({channel.id, channel.unit, own.info, std::move(model), std::move(caution)});
    return true;
  } catch (const InputError& error) {
    left_out_.emplace_back(error.what());
    return false;
  }
}

void FittedModel::add_together(const Dataset& data, const std::vector<bool>& training,
                               const std::vector<bool>& checked) {
  try {
    std::vector<Index> used = usable_inputs(data, training, parts_.spec->inputs);
    std::vector<InputInfo> info;
    for (const Index k : used) info.push_back(data.inputs[k]);
    const std::vector<Index> own = rotary_unit_inputs(info, name());
    std::vector<Index> chosen;
    for (const Index k : own) chosen.push_back(used[k]);
    std::vector<UnitChannel> channels;
    std::vector<std::size_t> targets;
    for (std::size_t t = 0; t < data.targets.size(); ++t) {
      if (checked[t]) continue;
      channels.push_back({training_data(data, training, t, chosen, name()), data.targets[t].quantity});
      targets.push_back(t);
    }
    std::vector<std::unique_ptr<ChannelModel>> models = fit_rotary_unit(channels, left_out_);
    for (std::size_t i = 0; i < models.size(); ++i) {
      if (!models[i]) continue;
      const MeasuredChannel& channel = data.targets[targets[i]];
      parts_.outputs.push_back({channel.id, {parts_.members.size()}, MatrixXd::Ones(1, 1)});
      std::string caution = models[i]->caution();
      parts_.members.push_back(
          {channel.id, channel.unit, channels[i].data.info, std::move(models[i]), std::move(caution)});
    }
  } catch (const InputError& error) {
    left_out_.emplace_back(error.what());
  }
}

void FittedModel::fit(const Dataset& data, const std::vector<bool>& training, const std::vector<std::string>& check) {
  parts_.members.clear();
  parts_.outputs.clear();
  left_out_.clear();
  refused_.clear();
  parts_.levels.clear();
  if (std::find(training.begin(), training.end(), true) == training.end()) {
    throw InputError(data.source, "no training row", "at least some hours of training data");
  }
  std::vector<bool> checked;
  for (const MeasuredChannel& channel : data.targets)
    checked.push_back(std::find(check.begin(), check.end(), channel.id) != check.end());
  if (parts_.spec->spatial == Spatial::one_point) return add_one_point(data, training, checked);
  if (parts_.spec->spatial == Spatial::grid) return add_grid(data, training, checked);
  if (parts_.spec->spatial == Spatial::together) return add_together(data, training, checked);
  for (std::size_t t = 0; t < data.targets.size(); ++t) {
    if (checked[t] || !add_member(data, training, t)) continue;
    parts_.outputs.push_back({data.targets[t].id, {parts_.members.size() - 1}, MatrixXd::Ones(1, 1)});
  }
}

void FittedModel::add_one_point(const Dataset& data, const std::vector<bool>& training,
                                const std::vector<bool>& checked) {
  std::map<std::string, std::vector<std::size_t>> groups;
  for (std::size_t t = 0; t < data.targets.size(); ++t) {
    if (!group_of(data.targets[t]).empty()) groups[group_of(data.targets[t])].push_back(t);
  }
  const Levels levels = load_levels(data, training);
  parts_.level_input = levels.input;
  parts_.levels = levels.values;
  const VectorXd level = levels_of_rows(data, parts_.level_input, parts_.levels);
  const Index level_count = std::max<Index>(std::ssize(parts_.levels), 1);
  for (const auto& [group, members] : groups) {
    std::vector<std::size_t> known;
    std::vector<std::string> poses;
    for (const std::size_t t : members) {
      if (checked[t]) continue;
      known.push_back(t);
      poses.push_back(data.targets[t].pose_text);
    }
    if (members.size() < 2 || known.empty()) {
      left_out_.push_back(name() + " " + group + ": measured at one pose only");
      continue;
    }
    // The calibration point is the pose nearest to the middle of the known ones.
    std::map<std::string, double> centre;
    for (const std::string& text : poses) {
      for (const auto& [axis, value] : pose_of_text(text)) centre[axis] += value / poses.size();
    }
    std::size_t calibration = known.front();
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < known.size(); ++i) {
      double distance = 0.0;
      std::map<std::string, double> pose = pose_of_text(poses[i]);
      for (const auto& [axis, value] : centre) distance += std::pow(pose[axis] - value, 2);
      if (distance < nearest) {
        nearest = distance;
        calibration = known[i];
      }
    }
    if (!add_member(data, training, calibration)) continue;
    const std::size_t member = parts_.members.size() - 1;
    const VectorXd reference = data.target_values.col(calibration);
    double largest = 0.0;
    for (Index i = 0; i < data.rows(); ++i) {
      if (training[i] && std::isfinite(reference[i])) largest = std::max(largest, std::abs(reference[i]));
    }
    // b_j: mean over time of the ratio, where the reference is large enough to divide by.
    MatrixXd ratios = MatrixXd::Zero(level_count, std::ssize(known));
    for (std::size_t j = 0; j < known.size(); ++j) {
      VectorXd sum = VectorXd::Zero(level_count), count = sum;
      for (Index i = 0; i < data.rows(); ++i) {
        const double z = data.target_values(i, known[j]);
        constexpr double least_share = 0.25;
        if (!training[i] || !std::isfinite(z) || !(std::abs(reference[i]) > least_share * largest)) continue;
        const VectorXd share = level_shares(parts_.levels, level[i]);
        sum += share * (z / reference[i]);
        count += share;
      }
      const double all = count.sum() > 0.0 ? sum.sum() / count.sum() : 1.0;
      for (Index l = 0; l < level_count; ++l) ratios(l, j) = count[l] > 0.5 ? sum[l] / count[l] : all;
    }
    for (const std::size_t t : members) {
      const auto at = std::find(known.begin(), known.end(), t);
      const MatrixXd weights = at != known.end()
                                   ? MatrixXd(ratios.col(at - known.begin()))
                                   : MatrixXd(ratios * workspace_weights(poses, data.targets[t].pose_text));
      parts_.outputs.push_back({data.targets[t].id, {member}, weights});
    }
  }
}

void FittedModel::add_grid(const Dataset& data, const std::vector<bool>& training, const std::vector<bool>& checked) {
  struct Grid {
    std::vector<std::size_t> members;
    std::vector<std::string> poses;
    RowVectorXd weights_at(const std::string& pose) const { return workspace_weights(poses, pose).transpose(); }
  };
  std::map<std::string, Grid> grids;  // by quantity, and by quantity and side
  for (std::size_t t = 0; t < data.targets.size(); ++t) {
    const MeasuredChannel& channel = data.targets[t];
    const std::string group = group_of(channel) + (is_side(channel) ? " " + channel.direction : "");
    if (checked[t] || group.empty() || !add_member(data, training, t)) continue;
    grids[group].members.push_back(parts_.members.size() - 1);
    grids[group].poses.push_back(channel.pose_text);
    parts_.outputs.push_back({channel.id, {parts_.members.size() - 1}, MatrixXd::Ones(1, 1)});
  }
  if (std::all_of(grids.begin(), grids.end(), [](const auto& grid) { return grid.second.members.size() < 2; })) {
    left_out_.push_back(name() + ": no quantity is measured at two poses");
    parts_.outputs.clear();
    parts_.members.clear();
    return;
  }
  for (std::size_t t = 0; t < data.targets.size(); ++t) {
    if (!checked[t]) continue;
    const MeasuredChannel& channel = data.targets[t];
    const std::string group = group_of(channel);
    const auto whole = grids.find(group), tool = grids.find(group + " tool"), table = grids.find(group + " table");
    if (tool != grids.end() && table != grids.end()) {
      // error = tool side - table side
      std::vector<std::size_t> members = tool->second.members;
      members.insert(members.end(), table->second.members.begin(), table->second.members.end());
      MatrixXd weights(1, std::ssize(members));
      weights << tool->second.weights_at(channel.pose_text), -table->second.weights_at(channel.pose_text);
      parts_.outputs.push_back({channel.id, std::move(members), std::move(weights)});
    } else if (whole != grids.end()) {
      parts_.outputs.push_back({channel.id, whole->second.members, whole->second.weights_at(channel.pose_text)});
    }
  }
}

MatrixXd FittedModel::predict(const Dataset& data) const {
  std::vector<VectorXd> series;
  for (const FittedMember& member : parts_.members) {
    MatrixXd inputs = MatrixXd::Constant(data.rows(), std::ssize(member.inputs), missing);
    for (std::size_t k = 0; k < member.inputs.size(); ++k) {
      if (member.inputs[k].activity) inputs.col(k).setZero();  // nothing of the kind ran
      for (std::size_t column = 0; column < data.inputs.size(); ++column) {
        if (data.inputs[column].id == member.inputs[k].id) inputs.col(k) = data.input_values.col(column);
      }
    }
    VectorXd& whole = series.emplace_back(data.rows());
    for (std::size_t s = 0; s < data.starts.size(); ++s) {
      const Index from = data.starts[s], count = data.stretch_end(s) - from;
      whole.segment(from, count) =
          member.model->predict(data.time.segment(from, count), inputs.middleRows(from, count));
    }
  }
  const VectorXd level = levels_of_rows(data, parts_.level_input, parts_.levels);
  MatrixXd result = MatrixXd::Constant(data.rows(), std::ssize(data.targets), missing);
  for (const FittedOutput& output : parts_.outputs) {
    for (std::size_t t = 0; t < data.targets.size(); ++t) {
      if (data.targets[t].id != output.channel) continue;
      for (Index i = 0; i < data.rows(); ++i) {
        const Eigen::RowVectorXd weights =
            output.weights.rows() == 1
                ? Eigen::RowVectorXd(output.weights.row(0))
                : Eigen::RowVectorXd(level_shares(parts_.levels, level[i]).transpose() * output.weights);
        double sum = 0.0;
        for (std::size_t p = 0; p < output.members.size(); ++p) sum += weights[p] * series[output.members[p]][i];
        sum *= output.factor;
        result(i, t) = std::isfinite(sum) ? sum : missing;
      }
    }
  }
  return result;
}

void FittedModel::refuse_diverging(const Dataset& data, const std::vector<bool>& training, MatrixXd& predicted) {
  constexpr double most_times = 10.0;
  /// Peak to peak of a column in the training rows or in all.
  const auto span_of = [&](const Eigen::Ref<const VectorXd>& values, bool training_only) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (Index i = 0; i < values.size(); ++i) {
      if (!std::isfinite(values[i]) || (training_only && !training[i])) continue;
      low = std::min(low, values[i]);
      high = std::max(high, values[i]);
    }
    return std::pair{low, high};
  };
  std::erase_if(parts_.outputs, [&](const FittedOutput& output) {
    const auto target = std::find_if(data.targets.begin(), data.targets.end(),
                                     [&](const MeasuredChannel& c) { return c.id == output.channel; });
    if (target == data.targets.end()) return false;
    const Index t = target - data.targets.begin();
    const auto [low, high] = span_of(data.target_values.col(t), true);
    if (!(high > low)) return false;
    double reach = 1.0;
    for (const std::size_t p : output.members) {
      for (const InputInfo& info : parts_.members[p].inputs) {
        for (std::size_t k = 0; k < data.inputs.size(); ++k) {
          if (data.inputs[k].id != info.id) continue;
          const auto seen = span_of(data.input_values.col(k), true), all = span_of(data.input_values.col(k), false);
          if (seen.second > seen.first) reach = std::max(reach, (all.second - all.first) / (seen.second - seen.first));
        }
      }
    }
    const double middle = 0.5 * (low + high), limit = most_times * reach * (high - low);
    for (Index i = 0; i < predicted.rows(); ++i) {
      if (!(std::abs(predicted(i, t) - middle) > limit)) continue;
      refused_.push_back(fmt::format(
          "{} {}: diverges; it predicts {:.3g} {} at {:.2f} h, while the training rows have {:.3g} to {:.3g} {}",
          name(), output.channel, predicted(i, t), target->unit, data.time[i] / core::units::hour, low, high,
          target->unit));
      predicted.col(t).setConstant(missing);
      return true;
    }
    return false;
  });
  if (parts_.outputs.empty()) parts_.members.clear();
}

std::vector<std::string> FittedModel::cautions() const {
  std::vector<std::string> all;
  for (const FittedMember& member : parts_.members)
    if (!member.caution.empty()) all.push_back(member.channel + ": " + member.caution);
  all.insert(all.end(), refused_.begin(), refused_.end());
  return all;
}

std::string FittedModel::correct(const Dataset& data, const std::vector<bool>& training) {
  const MatrixXd predicted = predict(data);
  std::string text;
  for (FittedOutput& output : parts_.outputs) {
    for (std::size_t t = 0; t < data.targets.size(); ++t) {
      if (data.targets[t].id != output.channel) continue;
      double products = 0.0, squares = 0.0;
      for (Index i = 0; i < data.rows(); ++i) {
        const double p = predicted(i, t), z = data.target_values(i, t);
        if (!training[i] || !std::isfinite(p) || !std::isfinite(z)) continue;
        products += p * z;
        squares += p * p;
      }
      if (squares > 0.0) output.factor *= products / squares;
      text += fmt::format("{}{} x {:.3g}", text.empty() ? "" : ", ", output.channel, output.factor);
    }
  }
  return text;
}

std::vector<FittedModel::ChannelSteps> FittedModel::step_responses() const {
  std::vector<ChannelSteps> channels;
  for (const FittedMember& member : parts_.members) {
    std::vector<StepResponse> responses = member.model->step_responses();
    if (!responses.empty()) channels.push_back({member.channel, member.unit, std::move(responses)});
  }
  return channels;
}

std::vector<std::string> FittedModel::explain() const {
  std::vector<std::string> lines;
  for (const FittedMember& member : parts_.members) {
    lines.push_back(name() + " " + member.channel + ": " + member.model->explain(member.unit) +
                    (member.caution.empty() ? "" : "; " + member.caution));
  }
  if (parts_.spec->spatial != Spatial::one_point) return lines;
  for (const FittedOutput& output : parts_.outputs) {
    std::string text = name() + " " + output.channel + ": b =";
    for (Index l = 0; l < output.weights.rows(); ++l) {
      text += fmt::format(" {:.3f}", output.weights(l, 0));
      if (!parts_.levels.empty()) text += fmt::format(" at {} {:g}", parts_.level_input, parts_.levels[l]);
    }
    lines.push_back(text + " of " + parts_.members[output.members[0]].channel);
  }
  return lines;
}

std::string FittedModel::to_toml() const { return toml_of(parts_); }

std::vector<FittedModel> FittedModel::read(const std::filesystem::path& file) {
  std::vector<FittedModel> models;
  for (FittedParts& parts : read_fitted_parts(file)) models.push_back(FittedModel(std::move(parts)));
  return models;
}

}  // namespace thermotwin::compensation
