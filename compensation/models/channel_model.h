// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A model of one displacement from the inputs that a control knows. It is fitted on rows that it may
// see and then predicts row by row: what comes later can never reach a prediction, since a
// RowPredictor is handed one row after the other.

#include <Eigen/Core>

#include <memory>
#include <string>
#include <vector>

#include "compensation/measurement/dataset.h"
#include "compensation/models/parameter_store.h"

namespace thermotwin::compensation {

/// A fitted model at work. Lives no longer than its model.
class RowPredictor {
public:
  virtual ~RowPredictor() = default;
  /// @param time  s, rising  @param inputs  (inputs) NaN where missing
  /// @return the displacement, NaN where an input that it needs is missing
  virtual double step(double time, const Eigen::Ref<const Eigen::RowVectorXd>& inputs) = 0;
};

/// How one input of a linear filter acts alone: the answer to a unit step at 0 s (Mares et al. 2020, Figs. 6, 8, 10).
struct StepResponse {
  std::string input;        ///< id; "T2 - ambient": a difference
  double interval_s = 0;    ///< between values
  Eigen::VectorXd values;   ///< displacement per unit of the input, over twice the settling time
  double end = 0;           ///< the value that it settles at
  double settling_s = 0;    ///< until it stays within 5 % of the end
  double largest_pole = 0;  ///< magnitude

  bool stable() const { return largest_pole < 1.0; }
};

class ChannelModel {
public:
  virtual ~ChannelModel() = default;
  /// @throws InputError where the data cannot carry the model (too few rows, no fitting input)
  virtual void fit(const TrainingData& data) = 0;
  virtual std::unique_ptr<RowPredictor> start() const = 0;
  /// Parameters in words with units. @param unit  of the target, "um"
  virtual std::string explain(const std::string& unit) const = 0;
  /// Why the fit just made is doubtful: a bound of a search that it lies at, another model that it fell back on. Empty:
  /// nothing.
  virtual std::string caution() const { return {}; }
  /// One for each input of a linear filter; empty: the model is none.
  virtual std::vector<StepResponse> step_responses() const { return {}; }
  virtual void save(ParameterStore& store) const = 0;
  /// @param info  inputs that the model was fitted with  @throws InputError
  virtual void load(const ParameterStore& store, const std::vector<InputInfo>& info) = 0;

  /// The whole record, row by row.
  Eigen::VectorXd predict(const Eigen::VectorXd& time, const Eigen::MatrixXd& inputs) const;
};

}  // namespace thermotwin::compensation
