// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What an evaluation finds.

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
  bool training = false;  ///< the model's fit saw displacements of this segment
};

/// A model over all displacements that its fit did not see, or where there are none (all rows train), over those that
/// it saw.
struct Standing {
  std::string model;
  Eigen::Index channels = 0;
  double reduction_percent = 0;       ///< 1 - root mean square over channels of RMS after / before
  double against_static_percent = 0;  ///< mean over channels of 1 - RMS / RMS of static_regression
  bool seen_by_fit = false;           ///< nothing was held out: this is the fit
  std::string caution{};              ///< why it is ranked behind models without one; empty: nothing
};

struct Evaluation {
  std::vector<EvaluationRow> rows;
  std::vector<Standing> leaderboard;  ///< best first; models of all channels before others, those with a caution last
  core::Table predictions;            ///< time_s, <channel>_measured, <channel>_<model>
  std::vector<std::pair<std::string, core::Table>> other_predictions;  ///< by name of the folder
  std::vector<FittedModel> models;
  std::vector<std::string> notes;  ///< what was left out and why
  std::string observer;            ///< with a reduced model: which augmented states its sensors tell
  double training_hours = 0;       ///< calibration effort: displacements over this time ...
  Eigen::Index inputs = 0;         ///< ... and this many channels that a control has to know
  std::string brief() const;       ///< leaderboard and notes
  std::vector<std::vector<std::string>> table(const std::string& channel) const;  ///< cells, header first
  std::string tables() const;                                                     ///< a table a channel
};

/// Fitted on one program (without programs: one day) after the other, judged on each.
struct CrossExperiment {
  std::vector<std::string> programs;
  struct Entry {
    std::string model;
    Eigen::MatrixXd
        reduction_percent;  ///< (trained on, judged on), RMS over the channels; NaN: not possible or refused
  };
  std::vector<Entry> entries;
  std::vector<std::string> notes;  ///< fits that were refused, and why
  std::string brief() const;
};

}  // namespace thermotwin::compensation
