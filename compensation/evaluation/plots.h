// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Pictures of an evaluation as SVG files that stand alone.

#include <string>
#include <vector>

#include "compensation/evaluation/evaluate.h"
#include "compensation/evaluation/result.h"
#include "compensation/models/fitted_model.h"

namespace thermotwin::compensation {

/// Bars: RMS removed where no fit saw it, best model first.
std::string leaderboard_svg(const Evaluation& evaluation);

/// Displacement and the predictions of the best models and of the static regression over time, the
/// residual of each below; what a fit saw is shaded.
std::string channel_svg(const Evaluation& evaluation, const std::string& channel);

/// A panel for each channel and input of a model of linear filters; empty: it is none.
std::string step_responses_svg(const FittedModel& model);
/// "output_error dx@1, step of T2: stable, ..." for each of these panels.
std::vector<std::string> stability_lines(const FittedModel& model);

/// Channels that have rows, in order.
std::vector<std::string> scored_channels(const Evaluation& evaluation);

struct Quartiles {
  double low = 0, median = 0, high = 0;
  double whisker_low = 0, whisker_high = 0;  ///< furthest values within 1.5 boxes
  std::vector<double> outliers;
};
/// NaN is left out; all NaN where nothing is left.
Quartiles quartiles(const Eigen::VectorXd& values);

/// Box plots of the residual in the sections and outside of them over the length of the measurement.
std::string length_study_svg(const LengthStudy& study);

}  // namespace thermotwin::compensation
