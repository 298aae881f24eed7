// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/models/fitted_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "compensation/models/parameter_store.h"
#include "core/config.h"
#include "core/error.h"
#include "core/text.h"

namespace thermotwin::compensation {

using core::InputError;
using Eigen::Index;

std::string toml_of(const FittedParts& model) {
  std::string text = fmt::format("[[model]]\nname = {}\nlevel_input = {}\nlevels = [",
                                 core::toml_text(model.spec->name), core::toml_text(model.level_input));
  for (std::size_t i = 0; i < model.levels.size(); ++i)
    text += fmt::format("{}{:.17e}", i == 0 ? "" : ", ", model.levels[i]);
  text += "]\n";
  for (const FittedMember& member : model.members) {
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
  for (const FittedOutput& output : model.outputs) {
    text += fmt::format("[[model.output]]\nchannel = {}\nfactor = {:.17e}\nweights = {}\nparts = [",
                        core::toml_text(output.channel), output.factor, parameter_text(output.weights));
    for (std::size_t i = 0; i < output.members.size(); ++i)
      text += fmt::format("{}{}.0", i == 0 ? "" : ", ", output.members[i]);
    text += "]\n";
  }
  return text;
}

std::vector<FittedParts> read_fitted_parts(const std::filesystem::path& file) {
  const core::Config config = core::Config::load(file);
  const core::Node root = config.root();
  root.schema(1);
  std::vector<FittedParts> models;
  for (const core::Node& node : root.tables("model")) {
    FittedParts model;
    model.spec = &model_spec(node.text("name"));
    model.level_input = node.text("level_input");
    model.levels = node.numbers("levels");
    for (const core::Node& member_node : node.tables("part")) {
      FittedMember member{member_node.text("channel"),
                          member_node.text("unit"),
                          {},
                          model.spec->make(),
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
      model.members.push_back(std::move(member));
    }
    for (const core::Node& output_node : node.tables("output")) {
      FittedOutput output{
          output_node.text("channel"), {}, read_parameter(output_node, "weights"), output_node.number("factor")};
      for (const double index : output_node.numbers("parts")) {
        if (!(index >= 0.0 && index < model.members.size())) {
          throw InputError(output_node.place("parts"), fmt::format("{}", index),
                           fmt::format("0 to {}", model.members.size() - 1.0));
        }
        output.members.push_back(static_cast<std::size_t>(index));
      }
      const auto rows = std::max<Index>(std::ssize(model.levels), 1);
      if (output.weights.cols() != std::ssize(output.members) ||
          (output.weights.rows() != 1 && output.weights.rows() != rows)) {
        throw InputError(output_node.place("weights"),
                         fmt::format("{} x {}", output.weights.rows(), output.weights.cols()),
                         fmt::format("1 or {} x {}", rows, output.members.size()));
      }
      output_node.finish();
      model.outputs.push_back(std::move(output));
    }
    node.finish();
    models.push_back(std::move(model));
  }
  root.finish();
  if (models.empty()) throw InputError(file.string(), "no [[model]]", "a file that evaluate has written");
  return models;
}

}  // namespace thermotwin::compensation
