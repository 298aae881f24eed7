// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A model of one displacement from the inputs that a control knows. It is fitted on rows that it may
// see and then predicts row by row: what comes later can never reach a prediction, since a
// RowPredictor is handed one row after the other.

#include <Eigen/Core>

#include <memory>
#include <string>

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
  virtual void save(Archive& archive) const = 0;
  /// @param info  inputs that the model was fitted with  @throws InputError
  virtual void load(const Archive& archive, const std::vector<InputInfo>& info) = 0;

  /// The whole record, row by row.
  Eigen::VectorXd predict(const Eigen::VectorXd& time, const Eigen::MatrixXd& inputs) const;
};

}  // namespace thermotwin::compensation
