// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/data/sentences.h"

#include <fmt/format.h>

#include "core/text.h"

namespace thermotwin::diagnosis {

std::string doubt(const std::vector<std::string>& channels, double fitted_hours, const std::string& how_well,
                  const std::vector<std::string>& rivals) {
  const bool one = channels.size() == 1;
  return fmt::format("{} {} the lag model of the first {:.0f} h {}, but {} may have changed {}.", core::join(channels),
                     one ? "follows" : "follow", fitted_hours, how_well,
                     rivals.empty() ? "an unknown cause" : core::join(rivals, " or "), one ? "it" : "them");
}

std::string within_uncertainty(std::size_t channels) {
  return channels == 1 ? "within its uncertainty" : "within their uncertainty";
}

std::string explain_the_rest(const std::vector<std::string>& causes) {
  if (causes.empty()) return "";
  return fmt::format(" {} {} the rest.", core::join(causes), causes.size() == 1 ? "explains" : "explain");
}

std::string hold_in_the_last_part(const std::vector<std::string>& causes) {
  if (causes.empty()) return "no proposed cause holds in the last part";
  return fmt::format("only {} {} in the last part", core::join(causes), causes.size() == 1 ? "holds" : "hold");
}

}  // namespace thermotwin::diagnosis
