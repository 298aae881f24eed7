// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/serve/model_line.h"

#include <nlohmann/json.hpp>

#include "compensation/control/state_error.h"
#include "core/text.h"

namespace thermotwin::tools {
namespace {

const char* text_of(compensation::StateFault fault) {
  switch (fault) {
    case compensation::StateFault::damaged: return "damaged";
    case compensation::StateFault::other_version: return "other_version";
    case compensation::StateFault::other_model: return "other_model";
    case compensation::StateFault::in_use: return "in_use";
  }
  return "";
}

}  // namespace

std::string announcement(const compensation::OnlineTwin& twin) {
  nlohmann::json json = {{"limits", {{"largest_um", twin.limits().largest_um}, {"rate_um_s", twin.limits().rate_um_s}}},
                         {"state_s", twin.time()}};  // NaN becomes null
  for (const std::string& axis : twin.axes()) json["axes"].push_back(core::lower(axis));
  return json.dump();
}

std::string refusal(const core::InputError& error) {
  const auto* state = dynamic_cast<const compensation::StateError*>(&error);
  const nlohmann::json json = {{"refused", state != nullptr ? text_of(state->fault()) : "input"},
                               {"what", error.what()}};
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace thermotwin::tools
