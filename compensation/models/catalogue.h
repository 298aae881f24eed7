// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The models that can be fitted to a measurement, by name. Most have a separate fit for each channel.

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "compensation/models/channel_model.h"

namespace thermotwin::compensation {

enum class InputChoice { temperatures, activity, all };
enum class Spatial { each_channel, one_point, grid, together };

struct ModelSpec {
  std::string name, about;
  InputChoice inputs = InputChoice::temperatures;
  Spatial spatial = Spatial::each_channel;
  std::function<std::unique_ptr<ChannelModel>()> make;
};
const std::vector<ModelSpec>& model_specs();
/// Also "composite_modules_grid:together", ":no_delays", ":air" and ":no_baseline", see ThreeModulesOptions.
/// @throws InputError with the nearest known name
const ModelSpec& model_spec(const std::string& name);

}  // namespace thermotwin::compensation
