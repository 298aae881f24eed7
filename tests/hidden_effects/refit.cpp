// SPDX-License-Identifier: GPL-3.0-or-later
#include "refit.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/inference/evidence.h"
#include "diagnosis/inference/hypothesis_fit.h"
#include "diagnosis/inference/model_search.h"

namespace thermotwin::hidden {

std::optional<double> refitted_log_odds(const Seen& seen, const mesh::Machine& machine,
                                        const std::vector<Truth>& causes) {
  if (causes.empty()) return 0.0;
  const diagnosis::Problem& problem = seen.problem();
  const diagnosis::SearchOptions options;
  const diagnosis::White white(problem);
  const double log_none = diagnosis::LinearEvidence(white.columns, white.residual, problem.prior_std).log_evidence();
  diagnosis::Hypothesis h;
  h.value.resize(std::ssize(causes));
  for (std::size_t k = 0; k < causes.size(); ++k) {
    const auto found =
        std::find_if(problem.parameters.begin(), problem.parameters.end(),
                     [&](const diagnosis::Parameter& p) { return !p.missing && same_cause(p, causes[k].parameter); });
    if (causes[k].parameter.missing || found == problem.parameters.end()) return std::nullopt;
    h.members.push_back(static_cast<int>(found - problem.parameters.begin()));
    h.value[k] = causes[k].value;
  }
  diagnosis::refine(h, problem, seen.response(), machine, white, log_none, options.iterations, options.evidence_share);
  const double count = std::ssize(problem.parameters);
  const double prior = causes.size() == 1 ? options.prior_single / count : 2.0 * options.prior_pair / (count * count);
  return std::log(prior / options.prior_none) + h.log_evidence;
}

}  // namespace thermotwin::hidden
