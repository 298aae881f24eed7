// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/prediction/present_machine.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "core/error.h"
#include "core/missing.h"
#include "core/progress.h"
#include "core/range.h"

namespace thermotwin::nc {

namespace {

constexpr double longest_wait_s = 7.0 * 86400.0;

compensation::ControlOptions in_steps(compensation::ControlOptions options, double step_s) {
  options.compensator.step_s = step_s;
  return options;
}

}  // namespace

void PresentOptions::validate() const {
  saved_with.validate();
  core::require_within("nc: --after", after_s, {0.0, longest_wait_s});
}

PresentMachine::PresentMachine(const reduction::ReducedModel& model, const PresentOptions& options)
    : twin_(model, in_steps(options.saved_with, options.step_s)) {
  compensation::OnlineTwin saved(model, options.saved_with);
  saved.load_file(options.state);
  if (std::isnan(saved.time()))
    throw core::InputError(options.state.string(), "a state before its first row", "a state after some rows");
  twin_.take_over(saved);
  start_s_ = twin_.time() + options.after_s;
  core::log_line(
      fmt::format("begins {} s after the state of {} at {} s", options.after_s, options.state.string(), saved.time()));
  held_ = twin_.channels().defaults();
  for (std::size_t k = 0; k < twin_.channels().names().size(); ++k) {
    const Eigen::Index i = k;
    const std::string& name = twin_.channels().names()[k];
    if (name.ends_with("T_C") || name.ends_with("gradient_K_m")) held_[i] = core::missing;
  }
}

Eigen::VectorXd PresentMachine::filled(Eigen::VectorXd row) const {
  for (Eigen::Index i = 0; i < row.size(); ++i)
    if (std::isnan(row[i])) row[i] = held_[i];
  return row;
}

void PresentMachine::stand_until_start(const Eigen::VectorXd& row) {
  std::vector<Eigen::Index> absent;
  for (Eigen::Index i = 0; i < row.size(); ++i)
    if (std::isnan(row[i])) absent.push_back(i);
  twin_.never_told(absent);
  if (start_s_ > twin_.time()) twin_.step(start_s_, filled(row), {});
}

void PresentMachine::step(double seconds, const Eigen::VectorXd& row) {
  twin_.step(start_s_ + seconds, filled(row), {});
}

}  // namespace thermotwin::nc
