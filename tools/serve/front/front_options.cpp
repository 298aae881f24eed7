// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/serve/front/front_options.h"

#include <nlohmann/json.hpp>

namespace thermotwin::tools {

void to_json(nlohmann::json& json, const FrontOptions& options) {
  json = {{"model", options.model.string()},
          {"state", options.state.string()},
          {"socket", options.socket.string()},
          {"json_lines", options.json_lines},
          {"quiet", options.quiet},
          {"model_command", options.model_command},
          {"page_command", options.page_command}};
}

void from_json(const nlohmann::json& json, FrontOptions& options) {
  options.model = json.at("model").get<std::string>();
  options.state = json.at("state").get<std::string>();
  options.socket = json.at("socket").get<std::string>();
  options.json_lines = json.at("json_lines");
  options.quiet = json.at("quiet");
  options.model_command = json.at("model_command").get<std::vector<std::string>>();
  options.page_command = json.at("page_command").get<std::vector<std::string>>();
}

}  // namespace thermotwin::tools
