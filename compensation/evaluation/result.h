// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Results of an evaluation: figures of each model, channel and segment, the leaderboard, and predictions.

#include <Eigen/Core>

#include <string>
#include <utility>
#include <vector>

#include "compensation/measurement/measures.h"
#include "compensation/models/catalogue.h"
#include "compensation/models/fitted_model.h"
#include "core/table.h"

namespace thermotwin::compensation {

struct EvaluationRow {
  std::string model, channel, segment;  ///< segment: "training", "day 2", a program or another folder
  double from_s = 0, to_s = 0;
  Measures measures;
  std::string unit;
  bool training = false;           ///< the model's fit saw displacements of this segment
  Eigen::Index measured_rows = 0;  ///< displacements of the segment, predicted or not
  double measured_rms = 0;         ///< their RMS
};

/// A model's place in the leaderboard. All models are judged on the same displacements: those that no fit saw. If
/// nothing was held out, on those of the fit. See standings.h.
struct Standing {
  std::string model;
  Eigen::Index channels = 0;          ///< that it predicts
  double reduction_percent = 0;       ///< RMS of the thermal error removed; what the leaderboard ranks by
  double against_static_percent = 0;  ///< mean over channels of 1 - RMS / RMS of static_regression
  bool seen_by_fit = false;           ///< nothing was held out: figures are those of the fit
  std::string caution{};              ///< reason to rank it behind models without a caution; empty: none
  double channel_mean_percent = 0;    ///< 1 - root mean square over channels of RMS after / before
  double predicted_percent = 0;       ///< share of the judged displacements that it predicts
};

struct Evaluation {
  std::vector<EvaluationRow> rows;
  std::vector<Standing> leaderboard;  ///< best first, those with a caution last
  core::Table predictions;            ///< time_s, `<channel>_measured`, `<channel>_<model>`
  std::vector<std::pair<std::string, core::Table>> other_predictions;  ///< by name of the folder
  std::vector<FittedModel> models;
  std::vector<std::string> notes;  ///< omissions with their reasons
  std::string observer;            ///< with a reduced model: observability of the augmented states
  double training_hours = 0;       ///< calibration effort: duration of measured displacements, h
  Eigen::Index inputs = 0;         ///< calibration effort: number of input channels
  std::string brief() const;       ///< leaderboard and notes
  std::vector<std::vector<std::string>> table(const std::string& channel) const;  ///< cells, header first
  std::string tables() const;                                                     ///< one table for each channel
};

/// Models fitted on each program (without programs: each day) in turn, and judged on every one.
struct CrossExperiment {
  std::vector<std::string> programs;
  struct Entry {
    std::string model;
    Eigen::MatrixXd reduction_percent;  ///< (trained on, judged on), as in Standing; NaN: not possible or refused
  };
  std::vector<Entry> entries;
  std::vector<std::string> notes;  ///< fits that were refused, and why
  std::string brief() const;
};

}  // namespace thermotwin::compensation
