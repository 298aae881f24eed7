// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What `serve` hands over to the front, as one argument of JSON.

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace thermotwin::tools {

struct FrontOptions {
  std::filesystem::path model, state;
  std::filesystem::path socket;  ///< empty: standard input and output
  bool json_lines = false, quiet = false;
  std::vector<std::string> model_command;  ///< the program first; "--state" and its file are added
  std::vector<std::string> page_command;   ///< empty: no page
};

void to_json(nlohmann::json& json, const FrontOptions& options);
void from_json(const nlohmann::json& json, FrontOptions& options);

}  // namespace thermotwin::tools
