// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/inference/search_result.h"

#include <algorithm>
#include <utility>

#include "diagnosis/statistics/statistics.h"

namespace thermotwin::diagnosis {

void add_laws(SearchResult& found, std::vector<ChangingLaw> laws, const SearchOptions& options) {
  if (laws.empty()) return;
  double all = 1.0;
  for (ChangingLaw& law : laws) {
    law.probability =
        std::exp(std::min(std::log(options.prior_law / laws.size()) + law.log_evidence - found.log_normal, 500.0));
    all += law.probability;
  }
  for (ChangingLaw& law : laws) law.probability /= all;
  found.probability_none /= all;
  found.probability_unknown /= all;
  found.probability_leftover /= all;
  found.marginal /= all;
  for (Hypothesis& h : found.hypotheses) h.probability /= all;
  std::stable_sort(laws.begin(), laws.end(),
                   [](const ChangingLaw& a, const ChangingLaw& b) { return a.probability > b.probability; });
  found.laws = std::move(laws);
}

void share_probability(SearchResult& found, const SearchOptions& options) {
  const double unknown = 1.0 / (1.0 + std::exp(-found.log_odds_unknown));
  const double of_unknown = found.log_odds_unknown - std::log(options.prior_leftover);
  found.misfit = std::max({0.0, found.beside_channels.empty() ? of_unknown : 0.0, found.raised_misfit});
  const double weight = 1.0 / (1.0 + found.misfit);
  double laws = 0.0;
  for (const ChangingLaw& law : found.laws) laws += law.probability;
  std::vector<double> plain, coarse;
  for (const Hypothesis& h : found.hypotheses) {
    plain.push_back(h.log_prior + h.log_evidence);
    coarse.push_back(h.log_prior + weight * h.log_evidence);
  }
  const double all_plain = log_sum_exp(plain), all_coarse = log_sum_exp(coarse);
  found.probability_unknown = (1.0 - laws) * unknown;
  found.probability_leftover = 0.0;
  found.marginal.setZero();
  double most_beside = 0.0;
  for (std::size_t i = 0; i < found.hypotheses.size(); ++i) {
    Hypothesis& h = found.hypotheses[i];
    const double beside = found.probability_unknown * std::exp(coarse[i] - all_coarse);
    h.probability = (1.0 - laws) * (1.0 - unknown) * std::exp(plain[i] - all_plain);
    for (const int member : h.members) found.marginal[member] += h.probability + beside;
    if (h.members.empty()) {
      found.probability_none = h.probability;
      continue;
    }
    found.probability_leftover += beside;
    if (beside > most_beside) most_beside = beside, found.log_evidence_beside = h.log_evidence;
  }
  found.marginal = found.marginal.cwiseMin(1.0);  // sums of many small numbers round
}

void raise_misfit(SearchResult& found, double misfit, const SearchOptions& options) {
  if (!(misfit > found.misfit)) return;
  found.raised_misfit = misfit;
  found.log_odds_unknown = std::max(found.log_odds_unknown, misfit + std::log(options.prior_leftover));
  share_probability(found, options);
}

const Hypothesis* SearchResult::single(int parameter) const {
  for (const Hypothesis& h : hypotheses)
    if (h.members.size() == 1 && h.members[0] == parameter) return &h;
  return nullptr;
}

}  // namespace thermotwin::diagnosis
