// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Pictures of an evaluation as SVG files that stand alone.

#include <string>
#include <vector>

#include "compensation/evaluation/evaluate.h"
#include "compensation/evaluation/result.h"
#include "compensation/models/fitted_model.h"

namespace thermotwin::compensation {

/// Bars: RMS of the thermal error removed on held-out data, %, best model first; on training data if none is held out.
std::string leaderboard_svg(const Evaluation& evaluation);

/// Measured displacement of a channel over time, with the predictions of the three best models and of the static
/// regression; below them the residual of each. Training data are shaded.
std::string channel_svg(const Evaluation& evaluation, const std::string& channel);

/// Step responses of a model of linear filters, a panel for each channel and input; empty for any other model.
std::string step_responses_svg(const FittedModel& model);
/// A line for each panel of step_responses_svg(): "output_error dx@1, step of T2: stable, ...".
std::vector<std::string> stability_lines(const FittedModel& model);

/// Channels with rows in the evaluation, in the order in which they first appear.
std::vector<std::string> scored_channels(const Evaluation& evaluation);

struct Quartiles {
  double low = 0, median = 0, high = 0;
  double whisker_low = 0, whisker_high = 0;  ///< extreme values within 1.5 interquartile ranges of the box
  std::vector<double> outliers;
};
/// Quartiles of the finite values; all NaN if there is none.
Quartiles quartiles(const Eigen::VectorXd& values);

/// Box plots of the RMS residual over the length of the fitted section: in the sections, and in the rows outside them.
std::string length_study_svg(const LengthStudy& study);

}  // namespace thermotwin::compensation
