// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// From the model's line for a row to the answer for its client, within the limits of the guard. The guard outlives the
// model process: without the model the offsets are held for 60 s and then return to zero.

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compensation/online/offset_guard.h"
#include "tools/serve/front/model_process.h"

namespace thermotwin::tools {

class Answers {
public:
  explicit Answers(bool json_lines) : json_lines_(json_lines) {}

  /// Axes and limits. Another model's limits replace them at the next row; the offsets go on from those in effect.
  /// @return false: the axes are others than before
  bool begin(const nlohmann::json& announcement);
  /// Offsets that the machine was given before the first row. @param offset_um  (axes)
  void go_on_from(Eigen::VectorXd offset_um) { start_um_ = std::move(offset_um); }
  const std::vector<std::string>& axes() const { return axes_; }
  const Eigen::VectorXd& applied_um() const { return applied_um_; }
  /// Whether a row can be answered without the model: offsets in effect are known.
  bool has_any() const { return guard_.has_value(); }
  std::string header() const;

  /// The model's answer. @param line  an object of `compensate --json-lines`
  const nlohmann::json& of_model(const ServedRow& row, nlohmann::json line);
  /// The guard alone. @param why  for the status
  const nlohmann::json& without_model(const ServedRow& row, const std::string& why);
  /// The last one as its client gets it.
  std::string text() const;

private:
  const nlohmann::json& give(const ServedRow& row, nlohmann::json answer);
  void step_guard(const ServedRow& row, const Eigen::VectorXd& wanted_um, double motion_um);
  void start_guard(double guard_s, const Eigen::VectorXd& applied_um);
  void widen(nlohmann::json& answer, const Eigen::VectorXd& wanted_um, const Eigen::VectorXd& model_um) const;

  bool json_lines_;
  std::vector<std::string> axes_;
  compensation::GuardOptions limits_;
  std::optional<compensation::OffsetGuard> guard_;
  bool has_new_limits_ = false;
  double time_ = -std::numeric_limits<double>::infinity();
  double stated_s_ = std::numeric_limits<double>::quiet_NaN();  ///< time of the last row that has one, as it states it
  double guard_s_ = 0;                                          ///< time of the guard
  std::optional<Eigen::VectorXd> start_um_;
  Eigen::VectorXd applied_um_;
  nlohmann::json last_;
};

}  // namespace thermotwin::tools
