// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Every compensation model on the same measurement: fitted on the training segment, judged on the
// rest, row by row, so that no prediction knows what comes later. With a reduced model of the
// machine: its prediction with and without sensors, nothing of it fitted. Every figure is computed
// from the displacements before and after; what a fit saw and what it did not is said in each row.

#include <filesystem>
#include <string>
#include <vector>

#include "compensation/evaluation/result.h"
#include "compensation/measurement/measurement.h"
#include "compensation/measurement/measures.h"
#include "compensation/models/catalogue.h"
#include "compensation/models/fitted_model.h"
#include "reduction/model/reduced_model.h"

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
  void validate() const;  ///< @throws InputError
};

/// @param model   nullptr where there is no machine
/// @param others         further measurements with the same channels, none of whose rows a fit sees
/// @param training_data  further measurements of the machine, all of whose rows fits see, each beginning anew;
///   the measurement itself then trains only as far as the options say
Evaluation evaluate(const Measurement& measurement, const reduction::ReducedModel* model,
                    const EvaluateOptions& options, const std::vector<Measurement>& others = {},
                    const std::vector<Measurement>& training_data = {});

/// Models fitted before, on another machine of the type: as they are (`<model>_as_is`) and with one
/// factor a channel from the training segment (`<model>_corrected`); document 002, 5.2.
Evaluation transfer(const Measurement& measurement, std::vector<FittedModel> models, const EvaluateOptions& options);

CrossExperiment cross_experiment(const Measurement& measurement, const EvaluateOptions& options);

/// How long a measurement a model needs (000, Figs. 5.23 and 5.24): sections of equal length at
/// random places, a fit on each.
struct LengthStudy {
  std::string model, channel, unit;
  Eigen::VectorXd hours;     ///< (lengths)
  Eigen::MatrixXd fit_rms;   ///< (lengths x sections) residual in the section; NaN: could not be fitted, or refused
  Eigen::MatrixXd rest_rms;  ///< (lengths x sections) residual in the rows outside of it
};
LengthStudy length_study(const Measurement& measurement, const std::string& model, const std::string& channel,
                         int lengths, int sections);

}  // namespace thermotwin::compensation
