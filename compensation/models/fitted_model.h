// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Every model that is fitted to a measurement, behind one interface: fit on some rows of a
// measurement, predict all its displacement channels row by row, explain, save and load.
// Most models have a separate fit for each channel. Some interpolate over the workspace: `one_point` (Okenka et al.)
// has one transfer function a quantity and a factor b_j for each pose, one for each load level; `transfer_grid`,
// `static_grid`, `composite_grid` and `composite_modules_grid` have a model at each pose. They predict poses without
// a fit (EvaluateOptions::check) by interpolation between those that have one. Where channels of a quantity are of one
// side each (direction "tool" or "table"), a grid is fitted to each side and their difference is predicted.
// `rotary_unit` is fitted to all channels together: one set of bodies, several location errors.

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "compensation/models/catalogue.h"
#include "compensation/models/channel_model.h"
#include "compensation/models/fitted_parts.h"

namespace thermotwin::compensation {

class FittedModel {
public:
  explicit FittedModel(const ModelSpec& spec) { parts_.spec = &spec; }

  /// @param training  (rows) true where targets may be used  @param check  channels that may not
  void fit(const Dataset& data, const std::vector<bool>& training, const std::vector<std::string>& check);

  /// (rows x targets) predicted row by row; NaN where inputs are missing or a channel is not modelled
  Eigen::MatrixXd predict(const Dataset& data) const;

  /// One factor a channel, fitted on these rows: the same model on another machine of the type
  /// (Mares et al. 2020, 5.2). @return factors in words
  std::string correct(const Dataset& data, const std::vector<bool>& training);

  const std::string& name() const { return parts_.spec->name; }
  /// Refuses channels whose prediction runs away from what the fit saw: beyond ten times the displacements of the
  /// training rows times the range of the inputs over theirs. @param predicted  of all rows; columns of refused
  /// channels become NaN
  void refuse_diverging(const Dataset& data, const std::vector<bool>& training, Eigen::MatrixXd& predicted);

  /// Why fits are doubtful: "<channel>: <reason>" of each member that lies at a bound of its search or fell back on
  /// another model,
  /// and of each channel that was refused.
  std::vector<std::string> cautions() const;

  /// Parameters of each channel in words.
  std::vector<std::string> explain() const;
  /// Step responses of the fits that are linear filters.
  struct ChannelSteps {
    std::string channel, unit;
    std::vector<StepResponse> responses;
  };
  std::vector<ChannelSteps> step_responses() const;
  /// Channels that could not be fitted, and why.
  const std::vector<std::string>& left_out() const { return left_out_; }
  /// Channels that refuse_diverging took away, and why.
  const std::vector<std::string>& refused() const { return refused_; }
  bool empty() const { return parts_.outputs.empty(); }

  /// As TOML: [[model]] tables with every number at full precision.
  std::string to_toml() const;
  /// @throws InputError (not such a file, unknown model, parameters missing or of wrong size)
  static std::vector<FittedModel> read(const std::filesystem::path& file);

private:
  explicit FittedModel(FittedParts parts) : parts_(std::move(parts)) {}
  bool add_member(const Dataset& data, const std::vector<bool>& training, Eigen::Index target);
  void add_one_point(const Dataset& data, const std::vector<bool>& training, const std::vector<bool>& checked);
  void add_together(const Dataset& data, const std::vector<bool>& training, const std::vector<bool>& checked);
  void add_grid(const Dataset& data, const std::vector<bool>& training, const std::vector<bool>& checked);

  FittedParts parts_;
  std::vector<std::string> left_out_, refused_;
};

}  // namespace thermotwin::compensation
