// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Compares compensation models on one measurement. Each model is fitted on the training segment and judged on the rest.
// It predicts row by row, from this and earlier rows only. A reduced model of the machine predicts with and without
// sensors, without a fit. Figures are computed from the displacements before and after compensation. Each row of the
// result states whether the fit saw its segment.

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
  /// Training time from the first row, s; 0: 24 h, or half of a record below 30 h; negative: none.
  double train_until_s = 0;
  std::vector<std::string> train_programs;  ///< instead: these programs of the measurement
  std::vector<std::string> models;          ///< by name; empty: all
  std::vector<std::string> check;           ///< displacement channels that no fit may use
  /// Model extended by a diagnosis, judged beside the nominal one as extended_model and extended_model_sensors.
  const reduction::ReducedModel* extended = nullptr;
  void validate() const;  ///< @throws InputError
};

/// @param model          nullptr without a machine
/// @param others         further measurements with the same channels, for judging only
/// @param training_data  further measurements of the machine, for training only, each started anew; the measurement
///   itself then trains only if the options state a training time or programs
Evaluation evaluate(const Measurement& measurement, const reduction::ReducedModel* model,
                    const EvaluateOptions& options, const std::vector<Measurement>& others = {},
                    const std::vector<Measurement>& training_data = {});

/// Judges models that were fitted on another machine of the type: unchanged (`<model>_as_is`), and with one factor for
/// each channel from the training segment (`<model>_corrected`); Mares et al. (2020), section 5.2.
Evaluation transfer(const Measurement& measurement, std::vector<FittedModel> models, const EvaluateOptions& options);

CrossExperiment cross_experiment(const Measurement& measurement, const EvaluateOptions& options);

/// Residual over the length of the training record (Gebhardt 2014, Figs. 5.23 and 5.24): for each length, fits on
/// sections at random places.
struct LengthStudy {
  std::string model, channel, unit;
  Eigen::VectorXd hours;     ///< (lengths)
  Eigen::MatrixXd fit_rms;   ///< (lengths x sections) residual in the section; NaN: could not be fitted, or refused
  Eigen::MatrixXd rest_rms;  ///< (lengths x sections) residual in the rows outside of it
};
LengthStudy length_study(const Measurement& measurement, const std::string& model, const std::string& channel,
                         int lengths, int sections);

}  // namespace thermotwin::compensation
