// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Every compensation model on the same measurement, one table: fitted on the training part, judged
// on the rest. With a reduced model of the machine: its prediction with and without sensors.

#include <filesystem>
#include <string>
#include <vector>

#include "compensation/measurement.h"
#include "compensation/measures.h"
#include "reduction/reduced_model.h"

namespace thermotwin::compensation {

struct EvaluateOptions {
  double train_until_s = 86400;   ///< models that are fitted see the data up to here only
};

struct EvaluationRow {
  std::string model, channel, part;   ///< part: "training" or "day 2" ...
  double from_s = 0, to_s = 0;
  Measures measures;
  std::string unit;
};

struct Evaluation {
  std::vector<EvaluationRow> rows;
  core::Table predictions;            ///< time_s, <channel>_measured, <channel>_<model>
  std::vector<std::string> notes;     ///< explained parameters, what was left out and why
  std::string brief() const;          ///< table for the terminal
};

/// @param model  nullptr where there is no machine
Evaluation evaluate(const Measurement& measurement, const reduction::ReducedModel* model,
                    const EvaluateOptions& options);

/// Predicted time series of a displacement channel's quantity by the compensator (um or um/m).
/// @param errors  TCP error at the channel's pose per time
Eigen::VectorXd quantity_series(const std::vector<solver::TcpError>& errors,
                                const MeasuredChannel& channel);

}  // namespace thermotwin::compensation
