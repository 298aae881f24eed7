// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/step_coefficients.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "solver/campaign/simulation.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double negligible_share = 1e-9;  ///< of a step

/// A machine with its factors from a time of the record on up to the k-th of them, in order of time.
mesh::Machine with_later(const MachineInTime& machine, std::size_t count) {
  mesh::Machine changed = machine;
  for (std::size_t k = 0; k < count; ++k) {
    const LaterFactor& later = machine.later[k];
    for (mesh::SourceSpec& source : changed.sources)
      if (!later.joint && source.id == later.item) source.scale.value *= later.factor;
    for (mesh::JointSpec& joint : changed.joints)
      if (later.joint && joint.id == later.item) joint.conductance.value *= later.factor;
  }
  return changed;
}

MachineInTime in_order(MachineInTime machine) {
  std::stable_sort(machine.later.begin(), machine.later.end(),
                   [](const auto& a, const auto& b) { return a.from_s < b.from_s; });
  return machine;
}

}  // namespace

StepCoefficients::StepCoefficients(const reduction::ReducedModel& reduced, const MachineInTime& machine)
    : added_(added_sources(reduced, machine)),
      model_(machine, added_.layout),
      sensor_offsets_(solver::sensor_offsets(machine, added_.layout)) {
  if (machine.later.empty()) return;
  const MachineInTime ordered = in_order(machine);
  for (std::size_t k = 0; k < ordered.later.size(); ++k)
    afterwards_.push_back({ordered.later[k].from_s, {with_later(ordered, k + 1), added_.layout}});
}

/// Of a row by the machine between two times.
void StepCoefficients::between(double begin, double end, const VectorXd& row, const VectorXd& inlets,
                               const VectorXd& readings, solver::Coefficients& out) {
  model_.coefficients(row, inlets, readings, out);
  for (const Afterwards& after : afterwards_) {
    const double share_after = std::clamp((end - after.from_s) / (end - begin), 0.0, 1.0);
    if (share_after < negligible_share) break;
    after.model.coefficients(row, inlets, readings, then_);
    out.p += share_after * (then_.p - out.p);
    out.q += share_after * (then_.q - out.q);
  }
}

/// The row with one ambient's temperature moved.
VectorXd StepCoefficients::disturbed(const VectorXd& row, int ambient, double by_K) const {
  VectorXd moved = row;
  const mesh::AmbientSpec& spec = model_.machine().ambients[ambient];
  double& channel = moved[model_.channels().index(spec.id + ".T_C")];
  // One that follows gets a temperature of its own.
  if (!std::isfinite(channel)) channel = model_.ambient_K(ambient, row) + model_.machine().reference_C;
  channel += by_K;
  return moved;
}

/// @param begin, end  of the step   @param duration  of the part of it that the row holds for
void StepCoefficients::coefficients(double begin, double end, const VectorXd& measured, const VectorXd& readings,
                                    int ambient, double by_K, double duration, solver::Coefficients& out) {
  const VectorXd row = by_K != 0.0 ? disturbed(measured, ambient, by_K) : measured, guide = model_.guide_K(row);
  if (!chiller_) {
    chiller_.emplace(model_.machine(), model_.layout(), model_.channels(),
                     solver::chiller_set_points(model_.machine(), model_.layout(), readings, guide));
  }
  between(begin, end, row, chiller_->advance(row, readings, guide, duration), readings, out);
}

void StepCoefficients::update(const Observations& obs, Index step, const VectorXd& sensors_K, int ambient, double by_K,
                              const Observations::MayHold* held) {
  const double begin = obs.points[step], end = obs.points[step + 1], duration = end - begin;
  const VectorXd readings = sensors_K + sensor_offsets_;
  const double held_share =
      held ? std::clamp((std::min(end, held->to) - std::max(begin, held->from)) / duration, 0.0, 1.0) : 0.0;
  const auto mixed = obs.mixed.find(step);
  if (mixed == obs.mixed.end() && held_share < negligible_share)
    return coefficients(begin, end, obs.rows.row(step).transpose(), readings, ambient, by_K, duration, c_);
  c_.p.setZero(std::ssize(model_.layout().terms));
  c_.q.setZero(std::ssize(model_.layout().inputs));
  const auto add = [&](const VectorXd& row, double of) {
    if (of < negligible_share) return;
    coefficients(begin, end, row, readings, ambient, by_K, of * duration, part_);
    c_.p += of * part_.p;
    c_.q += of * part_.q;
  };
  if (mixed == obs.mixed.end())
    add(obs.rows.row(step).transpose(), 1.0 - held_share);
  else {
    for (const Observations::Part& part_held : mixed->second) add(part_held.row, (1.0 - held_share) * part_held.share);
  }
  if (held) add(held->in_step(obs.rows.row(step).transpose()), held_share);
}

void StepCoefficients::add_heat(VectorXd& heat, double factor) const {
  if (added_.inputs.cols() > 0) heat += factor * (added_.inputs * c_.q.tail(added_.inputs.cols()));
}

}  // namespace thermotwin::diagnosis
