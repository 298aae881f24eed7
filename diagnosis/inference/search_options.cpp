// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/inference/search_options.h"

#include <string>
#include <utility>

#include "core/range.h"

namespace thermotwin::diagnosis {

void SearchOptions::validate() const {
  for (const auto& [name, share] : {std::pair{"prior_none", prior_none},
                                    {"prior_single", prior_single},
                                    {"prior_pair", prior_pair},
                                    {"prior_unknown", prior_unknown},
                                    {"prior_law", prior_law},
                                    {"prior_leftover", prior_leftover},
                                    {"evidence_share", evidence_share}})
    core::require_option(share > 0 && share <= 1, std::string("search ") + name, share, "above 0, at most 1");
  for (const auto& [name, count] : {std::pair{"refined_singles", refined_singles},
                                    {"iterations", iterations},
                                    {"pair_group", pair_group},
                                    {"most_refined_pairs", most_refined_pairs}})
    core::require_option(count >= 1, std::string("search ") + name, count, "1 or more");
  core::require_option(pair_margin >= 0, "search pair_margin", pair_margin, "a number of nats, not negative");
}

}  // namespace thermotwin::diagnosis
