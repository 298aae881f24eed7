// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The leaderboard of an evaluation. Every model is judged on the same rows: the displacements that no fit saw, or all
// of them if nothing was held out. With b_c^2 and a_c^2, the mean squares of channel c before and after compensation,
//   removed = 1 - sqrt(sum_c (l_c a_c)^2 / sum_c (l_c b_c)^2),
// l_c = 1 for a displacement in um and 0.3 m for a rotation in um/m. A row or channel that a model does not predict
// counts as not compensated.

#include <map>
#include <string>
#include <vector>

#include "compensation/evaluation/result.h"
#include "compensation/models/fitted_model.h"

namespace thermotwin::compensation {

/// Sums of squares of a channel over the judged rows, in its unit.
struct JudgedChannel {
  std::string unit;
  double rows = 0, predicted = 0;  ///< number of measured rows; of those that the model predicts
  double before = 0, after = 0;

  /// Adds the rows of a segment. @param row  nullptr: the model predicts none of them
  void add(const EvaluationRow& measured, const EvaluationRow* row);
};

/// @param channels  by id  @return removed of the formula above, percent; NaN if nothing moves
double removed_percent(const std::map<std::string, JudgedChannel>& channels);

/// @return the leaderboard, models with a caution last
std::vector<Standing> standings(const std::vector<EvaluationRow>& rows, const std::vector<FittedModel>& models);

/// @return a sentence for each reduced model that predicts worse with sensors than without
std::vector<std::string> worsened_by_sensors(const std::vector<Standing>& leaderboard);

}  // namespace thermotwin::compensation
