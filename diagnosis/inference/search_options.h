// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Prior weights of a search for causes, and how many of them are fitted.

namespace thermotwin::diagnosis {

struct SearchOptions {
  double prior_none = 0.5, prior_single = 0.35, prior_pair = 0.1, prior_unknown = 0.05, prior_law = 0.03;
  double prior_leftover = 0.1;  ///< that a cause leaves something unknown beside it
  /// What evidence counts of its nominal weight. Channels err together (the same mesh bends all
  /// poses alike), while the covariance takes them for independent; on clean virtual measurements
  /// the best of sixty causes otherwise collects up to eight nats from errors of the model alone.
  double evidence_share = 0.8;
  int refined_singles = 8, iterations = 3;
  /// Pairs are fitted in groups, until none that is left comes within `pair_margin` of the best fitted one.
  int pair_group = 4, most_refined_pairs = 16;
  double pair_margin = 4.0;  ///< nats

  void validate() const;  ///< @throws InputError
};

}  // namespace thermotwin::diagnosis
