// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/fitted_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "compensation/models/catalogue.h"
#include "compensation/models/load_levels.h"
#include "compensation/models/parameter_store.h"
#include "compensation/models/rotary_unit.h"
#include "compensation/models/training_rows.h"
#include "compensation/models/workspace_weights.h"
#include "core/config.h"
#include "core/error.h"
#include "core/missing.h"
#include "core/text.h"
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
  const std::vector<Index> used = usable_inputs(data, training, spec_->inputs);
  try {
    if (used.empty()) {
      throw InputError(name() + " " + channel.id,
                       spec_->inputs == InputChoice::temperatures ? "no temperature that varies in the training rows"
                       : spec_->inputs == InputChoice::activity
                           ? "no speed, power, flow or state that varies in the training rows"
                           : "no input that varies in the training rows",
                       "at least one");
    }
    const TrainingData own = training_data(data, training, target, used, name());
    std::unique_ptr<ChannelModel> model = spec_->make();
    model->fit(own);
    std::string caution = model->caution();
    members_.push_back({channel.id, channel.unit, own.info, std::move(model), std::move(caution)});
    return true;
  } catch (const InputError& error) {
    left_out_.emplace_back(error.what());
    return false;
  }
}

void FittedModel::add_together(const Dataset& data, const std::vector<bool>& training,
                               const std::vector<bool>& checked) {
  try {
    std::vector<Index> used = usable_inputs(data, training, spec_->inputs);
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
      outputs_.push_back({channel.id, {members_.size()}, MatrixXd::Ones(1, 1)});
      std::string caution = models[i]->caution();
      members_.push_back({channel.id, channel.unit, channels[i].data.info, std::move(models[i]), std::move(caution)});
    }
  } catch (const InputError& error) {
    left_out_.emplace_back(error.what());
  }
}

void FittedModel::fit(const Dataset& data, const std::vector<bool>& training, const std::vector<std::string>& check) {
  members_.clear();
  outputs_.clear();
  left_out_.clear();
  refused_.clear();
  levels_.clear();
  if (std::find(training.begin(), training.end(), true) == training.end()) {
    throw InputError(data.source, "no training row", "at least some hours of training data");
  }
  std::vector<bool> checked;
  for (const MeasuredChannel& channel : data.targets)
    checked.push_back(std::find(check.begin(), check.end(), channel.id) != check.end());
  if (spec_->spatial == Spatial::one_point) return add_one_point(data, training, checked);
  if (spec_->spatial == Spatial::grid) return add_grid(data, training, checked);
  if (spec_->spatial == Spatial::together) return add_together(data, training, checked);
  for (std::size_t t = 0; t < data.targets.size(); ++t) {
    if (checked[t] || !add_member(data, training, t)) continue;
    outputs_.push_back({data.targets[t].id, {members_.size() - 1}, MatrixXd::Ones(1, 1)});
  }
}

void FittedModel::add_one_point(const Dataset& data, const std::vector<bool>& training,
                                const std::vector<bool>& checked) {
  std::map<std::string, std::vector<std::size_t>> groups;
  for (std::size_t t = 0; t < data.targets.size(); ++t) {
    if (!group_of(data.targets[t]).empty()) groups[group_of(data.targets[t])].push_back(t);
  }
  const Levels levels = load_levels(data, training);
  level_input_ = levels.input;
  levels_ = levels.values;
  const VectorXd level = levels_of_rows(data, level_input_, levels_);
  const Index level_count = std::max<Index>(std::ssize(levels_), 1);
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
    const std::size_t member = members_.size() - 1;
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
        const VectorXd share = level_shares(levels_, level[i]);
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
      outputs_.push_back({data.targets[t].id, {member}, weights});
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
    grids[group].members.push_back(members_.size() - 1);
    grids[group].poses.push_back(channel.pose_text);
    outputs_.push_back({channel.id, {members_.size() - 1}, MatrixXd::Ones(1, 1)});
  }
  if (std::all_of(grids.begin(), grids.end(), [](const auto& grid) { return grid.second.members.size() < 2; })) {
    left_out_.push_back(name() + ": no quantity is measured at two poses");
    outputs_.clear();
    members_.clear();
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
      outputs_.push_back({channel.id, std::move(members), std::move(weights)});
    } else if (whole != grids.end()) {
      outputs_.push_back({channel.id, whole->second.members, whole->second.weights_at(channel.pose_text)});
    }
  }
}

MatrixXd FittedModel::predict(const Dataset& data) const {
  std::vector<VectorXd> series;
  for (const Member& member : members_) {
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
  const VectorXd level = levels_of_rows(data, level_input_, levels_);
  MatrixXd result = MatrixXd::Constant(data.rows(), std::ssize(data.targets), missing);
  for (const Output& output : outputs_) {
    for (std::size_t t = 0; t < data.targets.size(); ++t) {
      if (data.targets[t].id != output.channel) continue;
      for (Index i = 0; i < data.rows(); ++i) {
        const Eigen::RowVectorXd weights =
            output.weights.rows() == 1
                ? Eigen::RowVectorXd(output.weights.row(0))
                : Eigen::RowVectorXd(level_shares(levels_, level[i]).transpose() * output.weights);
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
  std::erase_if(outputs_, [&](const Output& output) {
    const auto target = std::find_if(data.targets.begin(), data.targets.end(),
                                     [&](const MeasuredChannel& c) { return c.id == output.channel; });
    if (target == data.targets.end()) return false;
    const Index t = target - data.targets.begin();
    const auto [low, high] = span_of(data.target_values.col(t), true);
    if (!(high > low)) return false;
    double reach = 1.0;
    for (const std::size_t p : output.members) {
      for (const InputInfo& info : members_[p].inputs) {
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
  if (outputs_.empty()) members_.clear();
}

std::vector<std::string> FittedModel::cautions() const {
  std::vector<std::string> all;
  for (const Member& member : members_)
    if (!member.caution.empty()) all.push_back(member.channel + ": " + member.caution);
  all.insert(all.end(), refused_.begin(), refused_.end());
  return all;
}

std::string FittedModel::correct(const Dataset& data, const std::vector<bool>& training) {
  const MatrixXd predicted = predict(data);
  std::string text;
  for (Output& output : outputs_) {
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
  for (const Member& member : members_) {
    std::vector<StepResponse> responses = member.model->step_responses();
    if (!responses.empty()) channels.push_back({member.channel, member.unit, std::move(responses)});
  }
  return channels;
}

std::vector<std::string> FittedModel::explain() const {
  std::vector<std::string> lines;
  for (const Member& member : members_) {
    lines.push_back(name() + " " + member.channel + ": " + member.model->explain(member.unit) +
                    (member.caution.empty() ? "" : "; " + member.caution));
  }
  if (spec_->spatial != Spatial::one_point) return lines;
  for (const Output& output : outputs_) {
    std::string text = name() + " " + output.channel + ": b =";
    for (Index l = 0; l < output.weights.rows(); ++l) {
      text += fmt::format(" {:.3f}", output.weights(l, 0));
      if (!levels_.empty()) text += fmt::format(" at {} {:g}", level_input_, levels_[l]);
    }
    lines.push_back(text + " of " + members_[output.members[0]].channel);
  }
  return lines;
}

std::string FittedModel::to_toml() const {
  std::string text = fmt::format("[[model]]\nname = {}\nlevel_input = {}\nlevels = [", core::toml_text(name()),
                                 core::toml_text(level_input_));
  for (std::size_t i = 0; i < levels_.size(); ++i) text += fmt::format("{}{:.17e}", i == 0 ? "" : ", ", levels_[i]);
  text += "]\n";
  for (const Member& member : members_) {
    text += fmt::format("[[model.part]]\nchannel = {}\nunit = {}\n", core::toml_text(member.channel),
                        core::toml_text(member.unit));
    std::string ids, kinds;
    for (const InputInfo& info : member.inputs) {
      const std::string comma = ids.empty() ? "" : ", ";
      ids += comma + core::toml_text(info.id);
      kinds += comma + (info.ambient       ? "\"ambient\""
                        : info.temperature ? "\"temperature\""
                        : info.motion      ? "\"motion\""
                        : info.activity    ? "\"activity\""
                                           : "\"state\"");
    }
    text += fmt::format("inputs = [{}]\nkinds = [{}]\n", ids, kinds);
    if (!member.caution.empty()) text += "caution = " + core::toml_text(member.caution) + "\n";
    text += "[model.part.values]\n";
    ParameterStore store;
    member.model->save(store);
    for (const auto& [key, values] : store.values()) text += key + " = " + parameter_text(values) + "\n";
  }
  for (const Output& output : outputs_) {
    text += fmt::format("[[model.output]]\nchannel = {}\nfactor = {:.17e}\nweights = {}\nparts = [",
                        core::toml_text(output.channel), output.factor, parameter_text(output.weights));
    for (std::size_t i = 0; i < output.members.size(); ++i)
      text += fmt::format("{}{}.0", i == 0 ? "" : ", ", output.members[i]);
    text += "]\n";
  }
  return text;
}

std::vector<FittedModel> FittedModel::read(const std::filesystem::path& file) {
  const core::Config config = core::Config::load(file);
  const core::Node root = config.root();
  root.schema(1);
  std::vector<FittedModel> models;
  for (const core::Node& node : root.tables("model")) {
    FittedModel model(model_spec(node.text("name")));
    model.level_input_ = node.text("level_input");
    model.levels_ = node.numbers("levels");
    for (const core::Node& member_node : node.tables("part")) {
      Member member{member_node.text("channel"),
                    member_node.text("unit"),
                    {},
                    model.spec_->make(),
                    member_node.text_or("caution", "")};
      const std::vector<std::string> ids = member_node.texts_or_empty("inputs"),
                                     kinds = member_node.texts_or_empty("kinds");
      if (ids.empty() || ids.size() != kinds.size()) {
        throw InputError(member_node.place("inputs"), fmt::format("{} inputs, {} kinds", ids.size(), kinds.size()),
                         "at least one input, a kind each");
      }
      for (std::size_t i = 0; i < ids.size(); ++i) {
        const bool ambient = kinds[i] == "ambient";
        const bool motion = kinds[i] == "motion";
        member.inputs.push_back(
            {ids[i], ambient || kinds[i] == "temperature", motion || kinds[i] == "activity", ambient, motion});
      }
      const core::Node values = member_node.table("values");
      ParameterStore store(values.place());
      for (const std::string& key : values.keys()) store.put(key, read_parameter(values, key));
      member.model->load(store, member.inputs);
      values.finish();
      member_node.finish();
      model.members_.push_back(std::move(member));
    }
    for (const core::Node& output_node : node.tables("output")) {
      Output output{
          output_node.text("channel"), {}, read_parameter(output_node, "weights"), output_node.number("factor")};
      for (const double index : output_node.numbers("parts")) {
        if (!(index >= 0.0 && index < model.members_.size())) {
          throw InputError(output_node.place("parts"), fmt::format("{}", index),
                           fmt::format("0 to {}", model.members_.size() - 1.0));
        }
        output.members.push_back(static_cast<std::size_t>(index));
      }
      const auto rows = std::max<Index>(std::ssize(model.levels_), 1);
      if (output.weights.cols() != std::ssize(output.members) ||
          (output.weights.rows() != 1 && output.weights.rows() != rows)) {
        throw InputError(output_node.place("weights"),
                         fmt::format("{} x {}", output.weights.rows(), output.weights.cols()),
                         fmt::format("1 or {} x {}", rows, output.members.size()));
      }
      output_node.finish();
      model.outputs_.push_back(std::move(output));
    }
    node.finish();
    models.push_back(std::move(model));
  }
  root.finish();
  if (models.empty()) throw InputError(file.string(), "no [[model]]", "a file that evaluate has written");
  return models;
}

}  // namespace thermotwin::compensation
