// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What a search for causes has found: hypotheses with their probabilities, something unknown, laws that change in the
// course of the record. Probabilities are shared anew when more is known.

#include <Eigen/Core>

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "diagnosis/inference/hypothesis_fit.h"
#include "diagnosis/inference/reading_steps.h"
#include "diagnosis/inference/search_options.h"

namespace thermotwin::diagnosis {

/// A source or joint whose size is another one in each of some intervals of the record: `other_law`.
struct ChangingLaw {
  int parameter = -1;  ///< its power or conductance
  double log_evidence = 0, probability = 0;
};

/// How far the machine as stated has to be stretched to fit: its other parameters without a cause, in stated standard
/// deviations.
struct Stretch {
  int which = -1;         ///< the parameter furthest off; -1: there is none
  double deviations = 0;  ///< of it, with its sign
  /// Sum of the squares of all parameters, and its mean and standard deviation where they are as stated.
  double squares = 0, squares_mean = 0, squares_std = 0;

  bool too_far() const { return beyond() || squares > squares_mean + most_squares * squares_std; }
  /// Whether a single parameter is.
  bool beyond() const { return std::abs(deviations) > most_deviations; }

  /// Parameters at 2.5 stated deviations were estimated at 3.1 at most.
  static constexpr double most_deviations = 3.5, most_squares = 5.0;
};

struct SearchResult {
  std::vector<Hypothesis> hypotheses;  ///< most probable first; without unknown
  Eigen::VectorXd marginal;            ///< (parameters) probability to be in the model
  double probability_none = 0, probability_unknown = 0, log_evidence_unknown = 0;
  double probability_leftover = 0;  ///< of a cause with something unknown beside it; part of unknown's
  double log_evidence_beside = 0;   ///< of the most probable of these causes or pairs, without the unknown
  /// ln odds of something unknown, alone or beside causes, against all listed hypotheses without it.
  double log_odds_unknown = -std::numeric_limits<double>::infinity();
  /// Where the best cause or pair leaves one channel alone to something unknown, or steps of one quantity, these
  /// channels; empty: others, or none.
  std::vector<std::size_t> beside_channels;
  ReadingSteps beside_steps;  ///< that describe it best there; else without steps
  double raised_misfit = 0;   ///< found after the search
  /// ln Bayes factor of something unknown in several channels against these hypotheses; 0: they are as good.
  double misfit = 0;
  std::vector<ChangingLaw> laws;  ///< most probable first
  double log_normal = 0;          ///< of the sum of prior times evidence of all but the laws
  /// What something unknown without a cause is best seen in, if it is one channel or steps of one quantity; else empty.
  std::vector<std::size_t> unknown_channels;
  ReadingSteps unknown_steps;  ///< that describe it best; else without steps
  std::vector<int> invisible;  ///< parameters that this measurement cannot show
  double chi_square_none = 0;  ///< of the fitted part, no cause
  Eigen::Index fitted = 0;     ///< its degrees of freedom
  Stretch stretch;             ///< of the machine as stated

  /// The hypothesis of this single cause; nullptr if it is invisible.
  const Hypothesis* single(int parameter) const;
};

/// Laws compete with what was found: all probabilities are less by theirs.
void add_laws(SearchResult& found, std::vector<ChangingLaw> laws, const SearchOptions& options = {});

/// Shares the probability between all hypotheses, none and something unknown by `log_odds_unknown`. Where something
/// unknown acts in several channels, the listed hypotheses are wrong by `misfit`, and what they gain counts
/// 1 / (1 + misfit): the coarsened posterior of Miller and Dunson, doi:10.1080/01621459.2018.1469995. A channel that is
/// off alone leaves what the others say.
void share_probability(SearchResult& found, const SearchOptions& options = {});

/// The same where the best hypothesis turned out to be wrong by so many nats, if that is more than was known.
void raise_misfit(SearchResult& found, double misfit, const SearchOptions& options = {});

}  // namespace thermotwin::diagnosis
