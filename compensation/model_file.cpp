// SPDX-License-Identifier: GPL-3.0-or-later
// Fitted models as TOML and back. README.md documents the file.
#include <fmt/format.h>

#include <cmath>

#include "compensation/model_zoo.h"
#include "core/config.h"
#include "core/error.h"

namespace thermotwin::compensation {
namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;

std::string matrix_text(const MatrixXd& matrix) {
  std::string text = fmt::format("[{}.0, {}.0", matrix.rows(), matrix.cols());
  for (Index i = 0; i < matrix.rows(); ++i) {
    for (Index j = 0; j < matrix.cols(); ++j) text += fmt::format(", {:.17e}", matrix(i, j));
  }
  return text + "]";
}

MatrixXd matrix_of(const core::Node& node, const std::string& key) {
  const std::vector<double> numbers = node.numbers(key);
  const auto refuse = [&](const std::string& found) { throw InputError(node.place(key), found, "rows, columns, then as many numbers, row by row"); };
  constexpr double largest = 1e6;
  if (numbers.size() < 2 || !(numbers[0] >= 0 && numbers[0] <= largest) || !(numbers[1] >= 0 && numbers[1] <= largest)) refuse("no shape");
  const auto rows = static_cast<Index>(numbers[0]), cols = static_cast<Index>(numbers[1]);
  if (static_cast<Index>(numbers.size()) != rows * cols + 2) refuse(fmt::format("{} numbers for {} x {}", numbers.size() - 2, rows, cols));
  MatrixXd matrix(rows, cols);
  for (Index i = 0; i < rows; ++i) {
    for (Index j = 0; j < cols; ++j) matrix(i, j) = numbers[static_cast<std::size_t>(2 + i * cols + j)];
  }
  return matrix;
}

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + "\"";
}

}  // namespace

std::string FittedModel::to_toml() const {
  std::string text = fmt::format("[[model]]\nname = {}\nlevel_input = {}\nlevels = [", quoted(name()), quoted(level_input_));
  for (std::size_t i = 0; i < levels_.size(); ++i) text += fmt::format("{}{:.17e}", i == 0 ? "" : ", ", levels_[i]);
  text += "]\n";
  for (const Part& part : parts_) {
    text += fmt::format("[[model.part]]\nchannel = {}\nunit = {}\n", quoted(part.channel), quoted(part.unit));
    std::string ids, kinds;
    for (const InputInfo& info : part.inputs) {
      const std::string comma = ids.empty() ? "" : ", ";
      ids += comma + quoted(info.id);
      kinds += comma + (info.ambient ? "\"ambient\"" : info.temperature ? "\"temperature\"" : info.motion ? "\"motion\"" : info.activity ? "\"activity\"" : "\"state\"");
    }
    text += fmt::format("inputs = [{}]\nkinds = [{}]\n", ids, kinds);
    if (!part.caution.empty()) text += "caution = " + quoted(part.caution) + "\n";
    text += "[model.part.values]\n";
    Archive archive;
    part.model->save(archive);
    for (const auto& [key, values] : archive.values()) text += key + " = " + matrix_text(values) + "\n";
  }
  for (const Output& output : outputs_) {
    text += fmt::format("[[model.output]]\nchannel = {}\nfactor = {:.17e}\nweights = {}\nparts = [", quoted(output.channel), output.factor, matrix_text(output.weights));
    for (std::size_t i = 0; i < output.parts.size(); ++i) text += fmt::format("{}{}.0", i == 0 ? "" : ", ", output.parts[i]);
    text += "]\n";
  }
  return text;
}

std::vector<FittedModel> FittedModel::read(const std::filesystem::path& file) {
  const core::Config config = core::Config::load(file);
  const core::Node root = config.root();
  root.integer("schema", 1, 1);
  std::vector<FittedModel> models;
  for (const core::Node& node : root.tables("model")) {
    FittedModel model(model_spec(node.text("name")));
    model.level_input_ = node.text("level_input");
    model.levels_ = node.numbers("levels");
    for (const core::Node& part_node : node.tables("part")) {
      Part part{part_node.text("channel"), part_node.text("unit"), {}, model.spec_->make(), part_node.text_or("caution", "")};
      const std::vector<std::string> ids = part_node.texts_or_empty("inputs"), kinds = part_node.texts_or_empty("kinds");
      if (ids.empty() || ids.size() != kinds.size()) {
        throw InputError(part_node.place("inputs"), fmt::format("{} inputs, {} kinds", ids.size(), kinds.size()), "at least one input, a kind each");
      }
      for (std::size_t i = 0; i < ids.size(); ++i) {
        const bool ambient = kinds[i] == "ambient";
        const bool motion = kinds[i] == "motion";
        part.inputs.push_back({ids[i], ambient || kinds[i] == "temperature", motion || kinds[i] == "activity", ambient, motion});
      }
      const core::Node values = part_node.table("values");
      Archive archive(values.place());
      for (const std::string& key : values.keys()) archive.put(key, matrix_of(values, key));
      part.model->load(archive, part.inputs);
      values.finish();
      part_node.finish();
      model.parts_.push_back(std::move(part));
    }
    for (const core::Node& output_node : node.tables("output")) {
      Output output{output_node.text("channel"), {}, matrix_of(output_node, "weights"), output_node.number("factor")};
      for (const double index : output_node.numbers("parts")) {
        if (!(index >= 0.0 && index < static_cast<double>(model.parts_.size()))) {
          throw InputError(output_node.place("parts"), fmt::format("{}", index), fmt::format("0 to {}", static_cast<double>(model.parts_.size()) - 1.0));
        }
        output.parts.push_back(static_cast<std::size_t>(index));
      }
      const auto rows = std::max<Index>(static_cast<Index>(model.levels_.size()), 1);
      if (output.weights.cols() != static_cast<Index>(output.parts.size()) || (output.weights.rows() != 1 && output.weights.rows() != rows)) {
        throw InputError(output_node.place("weights"), fmt::format("{} x {}", output.weights.rows(), output.weights.cols()),
                         fmt::format("1 or {} x {}", rows, output.parts.size()));
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
