// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What may explain that a displacement leaves the lag model of the record's first part. All hypotheses are
// linear and Gaussian beside the lag model and compete on the first and second part by their evidence; the
// last part is never fitted.

#include <string>
#include <vector>

#include "diagnosis/causes/kinds.h"
#include "diagnosis/data/lag_model.h"

namespace thermotwin::diagnosis {

/// Days of a record of 54 h or more (all after the second is the last part), else thirds.
struct RecordSegments {
  std::vector<Eigen::Index> first, middle, last;  ///< rows
  double first_end = 0, last_start = 0;           ///< s
};
RecordSegments divide(const DataRecord& record);
std::vector<Eigen::Index> joined(const std::vector<Eigen::Index>& a, const std::vector<Eigen::Index>& b);
/// Those of the rows in which something was measured.
std::vector<Eigen::Index> finite_rows(const Eigen::VectorXd& values, const std::vector<Eigen::Index>& rows);

/// A way to extend the lag model, averaged over its variants (when a drift begins, how slow an element is).
struct Extension {
  Kind kind = Kind::none;
  std::string name, unit;
  double probability = 0, log_evidence = 0;  ///< the second against none
  double value = 0, std = 0;                 ///< of the parameter
  double begins = 0;                         ///< s after the record's start; of a drift
  Eigen::VectorXd predicted;                 ///< (n) the target
};

struct WeighedChannel {
  LagModel model;
  Eigen::VectorXd before, expected_std;  ///< (n) residuals, and what the first part makes one expect
  double expected = 0, seen = 0;         ///< RMS after the first part: of expected_std, of the residual
  double p_value = 1;                    ///< of the residual after the first part, see weigh_channel
  double none = 1, unknown = 0;          ///< probabilities
  double unknown_log_evidence = 0;       ///< against none
  std::vector<Extension> extensions;
};

inline constexpr double prior_none = 0.5, prior_cause = 0.45,
                        prior_unknown = 0.05;  ///< the second is shared by all extensions

/// p value: of two F tests under the posterior of the first part, all values after it and their mean and slope
/// (one slow direction hardly moves the sum over all), twice the smaller. The variance is that of the stated
/// uncertainty or, where larger, of the first part's fit.
WeighedChannel weigh_channel(const DataRecord& record, Eigen::Index target, const RecordSegments& segments);

}  // namespace thermotwin::diagnosis
