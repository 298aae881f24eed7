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
void Answers::start_guard(double time, const Eigen::VectorXd& applied_um) {
  compensation::GuardOptions limits = limits_;
  if (applied_um.size() > 0) limits.largest_um = std::max(limits.largest_um, applied_um.cwiseAbs().maxCoeff());
  guard_.emplace(std::ssize(axes_), limits);
  guard_->step(time, applied_um);
  applied_um_ = guard_->step(time, applied_um, limits.largest_um);
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
  const bool is_timed = std::isfinite(row.time) && row.time > time_;
  if (!guard_ && is_timed) {
    // The offsets that the model's own guard has kept over a restart of this process, or zero.
    start_guard(row.time, model.allFinite() ? model : Eigen::VectorXd(Eigen::VectorXd::Zero(axes)));
    time_ = row.time;
    return give(row, std::move(line), Eigen::VectorXd(), 0.0);
  }
  if (!guard_) applied_um_ = Eigen::VectorXd::Zero(axes);
  return give(row, std::move(line), wanted, motion_um);
}

const nlohmann::json& Answers::without_model(const ServedRow& row, const std::string& why) {
  nlohmann::json answer = {{"status", "failed " + why}};
  for (const std::string& axis : axes_) answer["std_um"][axis] = limits_.largest_um;
  return give(row, std::move(answer), Eigen::VectorXd::Constant(std::ssize(axes_), core::missing), 0.0);
}

/// @param wanted_um  empty: the guard has been started by this row
const nlohmann::json& Answers::give(const ServedRow& row, nlohmann::json answer, const Eigen::VectorXd& wanted_um,
                                    double motion_um) {
  if (guard_ && wanted_um.size() > 0 && std::isfinite(row.time) && row.time > time_) {
    if (has_new_limits_ && wanted_um.allFinite()) start_guard(time_, applied_um_);
    applied_um_ = guard_->step(row.time, wanted_um, motion_um);
    time_ = row.time;
  }
  if (std::isfinite(row.stated_s)) stated_s_ = row.stated_s;
  // A row without a time repeats that of the row before, as the rows state it.
  if (std::isfinite(stated_s_))
    answer["time_s"] = stated_s_;
  else if (!answer.contains("time_s"))
    answer["time_s"] = time_;
  answer["guard"] = text_of(guard_ ? guard_->state() : compensation::GuardState::holding);
  answer["axes"] = axes_;
  for (std::size_t i = 0; i < axes_.size(); ++i)
    answer["offset_um"][axes_[i]] = applied_um_[static_cast<Eigen::Index>(i)];
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
