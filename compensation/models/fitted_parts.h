// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What a fitted model consists of, in memory and as a file: members, each fitted to one series, and channels as
// weighted sums of them. The file is TOML: [[model]] tables with every number at full precision.

#include <Eigen/Core>

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "compensation/models/catalogue.h"
#include "compensation/models/channel_model.h"

namespace thermotwin::compensation {

struct FittedMember {
  std::string channel, unit;
  std::vector<InputInfo> inputs;
  std::unique_ptr<ChannelModel> model;
  std::string caution{};  ///< of its fit
};

/// A channel as a weighted sum of members; the weights may depend on the load level.
struct FittedOutput {
  std::string channel;
  std::vector<std::size_t> members;
  Eigen::MatrixXd weights;  ///< (levels x members)
  double factor = 1.0;
};

struct FittedParts {
  const ModelSpec* spec = nullptr;
  std::vector<FittedMember> members;
  std::vector<FittedOutput> outputs;
  std::string level_input;  ///< activity whose last value above 0 is the load level
  std::vector<double> levels;
};

std::string toml_of(const FittedParts& model);
/// @throws InputError (not such a file, unknown model, parameters missing or of wrong size)
std::vector<FittedParts> read_fitted_parts(const std::filesystem::path& file);

}  // namespace thermotwin::compensation
