// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/nc/offset_excess.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/error.h"

namespace thermotwin::tools {

using Kind = nc::BeyondLimits::Kind;

std::string beyond_text(const nc::BeyondLimits& beyond) {
  std::string text;
  const nc::BeyondLimits::Total &size = beyond.total(Kind::size), &rate = beyond.total(Kind::rate);
  if (size.moves > 0)
    text += fmt::format("\n{} moves have an offset above the limit of {:.4g} um: up to {:.4g} um, first in line {}",
                        size.moves, beyond.limits().largest_um, size.largest, size.first_line);
  if (rate.moves > 0)
    text += fmt::format(
        "\n{} moves have an offset that changes faster than the limit of {:.3g} um/s: up to {:.3g} um/s, first in "
        "line {}",
        rate.moves, beyond.limits().rate_um_s, rate.largest, rate.first_line);
  return text;
}

void to_json(const nc::BeyondLimits& beyond, nlohmann::json& json) {
  json["offset_limits"] = {{"largest_um", beyond.limits().largest_um}, {"rate_um_s", beyond.limits().rate_um_s}};
  json["moves_beyond_largest_offset"] = beyond.total(Kind::size).moves;
  json["moves_beyond_offset_rate"] = beyond.total(Kind::rate).moves;
}

void refuse_excess(const nc::BeyondLimits::Excess& excess, const nc::BeyondLimits& beyond, const std::string& place,
                   const NcOptions& options) {
  const auto origin = [](const char* option, double stated) {
    return stated > 0.0 ? std::string(option) : fmt::format("by the model; {} states another limit", option);
  };
  if (excess.kind == Kind::size)
    throw core::InputError(place, fmt::format("an offset of {:.4g} um with --rewrite", excess.value),
                           fmt::format("at most {:.4g} um ({})", beyond.limits().largest_um,
                                       origin("--largest-offset", options.largest_um)));
  throw core::InputError(
      place, fmt::format("an offset that changes by {:.3g} um/s with --rewrite", excess.value),
      fmt::format("at most {:.3g} um/s ({})", beyond.limits().rate_um_s, origin("--offset-rate", options.rate_um_s)));
}

}  // namespace thermotwin::tools
