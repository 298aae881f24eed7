// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Every compensation model on the same measurement: fitted on the training part, judged on the
// rest, row by row, so that no prediction knows what comes later. With a reduced model of the
// machine: its prediction with and without sensors, nothing of it fitted. Every figure is computed
// from the displacements before and after; what a fit saw and what it did not is said in each row.

#include <filesystem>
#include <string>
#include <vector>

#include "compensation/measurement.h"
#include "compensation/measures.h"
#include "compensation/model_zoo.h"
#include "reduction/reduced_model.h"

namespace thermotwin::compensation {

struct EvaluateOptions {
  /// Models that are fitted see so much from the first row on, s; 0: 24 h, of a record below 30 h half;
  /// negative: nothing.
  double train_until_s = 0;
  std::vector<std::string> train_programs;  ///< instead: these programs of the measurement
  std::vector<std::string> models;          ///< by name; empty: all
  std::vector<std::string> check;           ///< displacement channels that no fit may use
  /// That of the machine as a diagnosis extended it, beside the nominal one: extended_model, extended_model_sensors.
  const reduction::ReducedModel* extended = nullptr;
};

struct EvaluationRow {
  std::string model, channel, part;   ///< part: "training", "day 2", a program or another folder
  double from_s = 0, to_s = 0;
  Measures measures;
  std::string unit;
  bool training = false;              ///< the model's fit saw displacements of this part
};

/// A model over all displacements that its fit did not see, or where there are none (all rows train), over those that it saw.
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
  std::vector<std::string> notes;     ///< what was left out and why
  std::string observer;               ///< with a reduced model: which augmented states its sensors tell
  double training_hours = 0;          ///< calibration effort: displacements over this time ...
  Eigen::Index inputs = 0;            ///< ... and this many channels that a control has to know
  std::string brief() const;          ///< leaderboard, and a table a channel
};

/// @param model   nullptr where there is no machine
/// @param others         further measurements with the same channels, none of whose rows a fit sees
/// @param training_data  further measurements of the machine, all of whose rows fits see, each beginning anew;
///   the measurement itself then trains only as far as the options say
Evaluation evaluate(const Measurement& measurement, const reduction::ReducedModel* model,
                    const EvaluateOptions& options, const std::vector<Measurement>& others = {},
                    const std::vector<Measurement>& training_data = {});

/// Models fitted before, on another machine of the type: as they are (`<model>_as_is`) and with one
/// factor a channel from the training part (`<model>_corrected`); document 002, 5.2.
Evaluation transfer(const Measurement& measurement, std::vector<FittedModel> models, const EvaluateOptions& options);

/// Fitted on one program (without programs: one day) after the other, judged on each.
struct CrossExperiment {
  std::vector<std::string> programs;
  struct Entry {
    std::string model;
    Eigen::MatrixXd reduction_percent;  ///< (trained on, judged on), RMS over the channels; NaN: not possible or refused
  };
  std::vector<Entry> entries;
  std::vector<std::string> notes;       ///< fits that were refused, and why
  std::string brief() const;
};
CrossExperiment cross_experiment(const Measurement& measurement, const EvaluateOptions& options);

/// How long a measurement a model needs (000, Figs. 5.23 and 5.24): sections of equal length at
/// random places, a fit on each.
struct LengthStudy {
  std::string model, channel, unit;
  Eigen::VectorXd hours;              ///< (lengths)
  Eigen::MatrixXd fit_rms;            ///< (lengths x sections) residual in the section; NaN: could not be fitted, or refused
  Eigen::MatrixXd rest_rms;           ///< (lengths x sections) residual in the rows outside of it
};
LengthStudy length_study(const Measurement& measurement, const std::string& model, const std::string& channel,
                         int lengths, int sections);

/// Predicted time series of a displacement channel's quantity by the compensator (um or um/m).
/// @param errors  TCP error at the channel's pose per time
Eigen::VectorXd quantity_series(const std::vector<solver::TcpError>& errors,
                                const MeasuredChannel& channel);

}  // namespace thermotwin::compensation
