// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/serve/front/answers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "core/missing.h"
#include "tools/guard_words.h"

namespace thermotwin::tools {
namespace {

double number(const nlohmann::json& value) { return value.is_number() ? value.get<double>() : core::missing; }

/// The words of the front belong to rows whose input was not as it should be.
std::string with_notes(std::string status, const std::string& notes) {
  if (notes.empty()) return status;
  if (status == "ok" || status == "limited" || status == "no_sensors") status = "input_missing";
  return status + " " + notes;
}

}  // namespace

bool Answers::begin(const nlohmann::json& announcement) {
  const auto axes = announcement["axes"].get<std::vector<std::string>>();
  if (!axes_.empty() && axes != axes_) return false;
  axes_ = axes;
  limits_.largest_um = announcement["limits"]["largest_um"];
  limits_.rate_um_s = announcement["limits"]["rate_um_s"];
  has_new_limits_ = true;
  return true;
}

std::string Answers::header() const {
  if (json_lines_) return "";
  std::string text = "time_s";
  for (const char* kind : {"offset", "std"})
    for (const std::string& axis : axes_) text += fmt::format(",{}_{}_um", kind, axis);
  return text + ",status\n";
}

/// A guard that has these offsets in effect, also where the limit is a smaller one now.
void Answers::start_guard(double guard_s, const Eigen::VectorXd& applied_um) {
  compensation::GuardOptions limits = limits_;
  if (applied_um.size() > 0) limits.largest_um = std::max(limits.largest_um, applied_um.cwiseAbs().maxCoeff());
  guard_.emplace(std::ssize(axes_), limits);
  guard_->step(guard_s, applied_um);
  applied_um_ = guard_->step(guard_s, applied_um, limits.largest_um);
  guard_s_ = guard_s;
  has_new_limits_ = false;
}

const nlohmann::json& Answers::of_model(const ServedRow& row, nlohmann::json line) {
  const auto axes = std::ssize(axes_);
  Eigen::VectorXd wanted(axes), model(axes);
  for (Eigen::Index i = 0; i < axes; ++i) {
    wanted[i] = number(line["wanted_um"][i]);
    model[i] = number(line["offset_um"][axes_[i]]);
  }
  const double motion_um = line.value("motion_um", 0.0);
  if (!guard_ && std::isfinite(row.time) && row.time > time_) {
    // The offsets that the machine was given last, else those that the model's own guard has kept, or zero.
    start_guard(row.guard_s, start_um_           ? *start_um_
                             : model.allFinite() ? model
                                                 : Eigen::VectorXd(Eigen::VectorXd::Zero(axes)));
    time_ = row.time;
  } else if (guard_) {
    step_guard(row, wanted, motion_um);
  } else {
    applied_um_ = Eigen::VectorXd::Zero(axes);
  }
  if (guard_) widen(line, wanted, model);
  return give(row, std::move(line));
}

const nlohmann::json& Answers::without_model(const ServedRow& row, const std::string& why) {
  nlohmann::json answer = {{"status", "failed " + why}};
  for (const std::string& axis : axes_) answer["std_um"][axis] = limits_.largest_um;
  step_guard(row, Eigen::VectorXd::Constant(std::ssize(axes_), core::missing), 0.0);
  return give(row, std::move(answer));
}

/// Time of the guard may stand still where that of the rows does not.
void Answers::step_guard(const ServedRow& row, const Eigen::VectorXd& wanted_um, double motion_um) {
  if (!guard_ || !std::isfinite(row.time) || row.time <= time_) return;
  if (has_new_limits_ && wanted_um.allFinite()) start_guard(guard_s_, applied_um_);
  guard_s_ = std::max(guard_s_, row.guard_s);
  applied_um_ = guard_->step(guard_s_, wanted_um, motion_um);
  time_ = row.time;
}

/// The part that this guard holds back belongs to the deviation, in place of that of the model's own guard.
void Answers::widen(nlohmann::json& answer, const Eigen::VectorXd& wanted_um, const Eigen::VectorXd& model_um) const {
  constexpr double same_um = 0.01;
  for (Eigen::Index i = 0; i < applied_um_.size(); ++i) {
    nlohmann::json& std_um = answer["std_um"][axes_[i]];
    const double back = wanted_um[i] - applied_um_[i], model_back = wanted_um[i] - model_um[i];
    if (!std_um.is_number() || !std::isfinite(back) || std::abs(back - model_back) < same_um) continue;
    const double whole = std_um, own = std::sqrt(std::max(0.0, whole * whole - model_back * model_back));
    std_um = std::hypot(own, back);
    if (std::abs(back) > own && answer["status"] == "ok") answer["status"] = "limited";
  }
}

const nlohmann::json& Answers::give(const ServedRow& row, nlohmann::json answer) {
  if (std::isfinite(row.stated_s)) stated_s_ = row.stated_s;
  // A row without a time repeats that of the row before, as the rows state it.
  if (std::isfinite(stated_s_))
    answer["time_s"] = stated_s_;
  else if (!answer.contains("time_s"))
    answer["time_s"] = time_;
  answer["guard"] = text_of(guard_ ? guard_->state() : compensation::GuardState::holding);
  answer["axes"] = axes_;
  for (std::size_t i = 0; i < axes_.size(); ++i) answer["offset_um"][axes_[i]] = applied_um_[i];
  answer["status"] = with_notes(answer.value("status", "failed"), row.notes);
  for (const char* inner : {"wanted_um", "motion_um", "limits"}) answer.erase(inner);
  return last_ = std::move(answer);
}

std::string Answers::text() const {
  if (json_lines_) return last_.dump() + "\n";
  const double time = number(last_["time_s"]);
  std::string line = fmt::format("{}", time);
  for (const char* kind : {"offset_um", "std_um"}) {
    for (const std::string& axis : axes_) line += fmt::format(",{:.3f}", number(last_[kind][axis]));
  }
  return line + "," + last_["status"].get<std::string>() + "\n";
}

}  // namespace thermotwin::tools
