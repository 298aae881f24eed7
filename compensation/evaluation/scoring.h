// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Divides a measurement into segments, and scores predictions on each.

#include "compensation/evaluation/evaluate.h"
#include "compensation/evaluation/result.h"
#include "compensation/models/fitted_model.h"

namespace thermotwin::compensation {

struct EvaluationSegment {
  std::string name;
  double from = 0, to = 0;  ///< [from, to)
  bool training = false;
};

class Scorer {
public:
  Scorer(const Measurement& measurement, std::vector<EvaluationSegment> segments);

  const Dataset& data() const { return data_; }
  const std::vector<EvaluationSegment>& segments() const { return segments_; }
  /// (rows) whether a fit may use it
  std::vector<bool> training() const;

  /// Scores a prediction (rows) of a target. @param fitted  false: no segment was seen by a fit
  void add(const std::string& model, std::size_t target, const Eigen::VectorXd& predicted, bool fitted);
  /// All channels of a fitted model that it predicts.
  void add(const std::string& model, const Eigen::MatrixXd& predicted, bool fitted);
  void note(std::string text) { notes.push_back(std::move(text)); }

  std::vector<EvaluationRow> rows;
  std::vector<std::string> notes;
  std::string observer;  ///< observability of the reduced model's augmented states
  core::Table predictions() const;

private:
  Dataset data_;
  std::vector<EvaluationSegment> segments_;
  std::vector<std::string> names_;
  std::vector<Eigen::VectorXd> columns_;
};

/// Training segment and days, or programs. @throws InputError for an unknown program
std::vector<EvaluationSegment> segments_of(const Measurement& measurement, const EvaluateOptions& options);

/// Models of the options; all without any. @throws InputError for an unknown name
std::vector<const ModelSpec*> chosen_models(const EvaluateOptions& options);

/// Rows for a fit, from the judged measurement or from several.
struct TrainingRows {
  Dataset data;
  std::vector<bool> used;  ///< (rows)
};
/// @param further  measurements that train beside the judged one; they come first in time
TrainingRows training_rows(const Scorer& scorer, const std::vector<Scorer>& further = {});

/// Fits a model and scores it, also on the further measurements that trained it. Failures are noted in the first
/// scorer. @return whether any channel was fitted
bool fit_and_score(FittedModel& model, const std::vector<std::string>& check, const TrainingRows& rows, Scorer& scorer,
                   std::vector<Scorer>& further);

}  // namespace thermotwin::compensation
