// SPDX-License-Identifier: GPL-3.0-or-later
// The return from a power-off with an unknown thermal state.

#include "compensation/evaluation/power_off.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "compensation/evaluation/replay.h"
#include "compensation/evaluation/validation.h"
#include "compensation/online/axis_reach.h"
#include "core/text.h"
#include "core/units.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/case.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;

constexpr double after_s[] = {offset_settle_s, 1800.0, 7200.0};  ///< the guard starts from nought
constexpr double back_h = 3.0;

/// Hours in whole five minutes: phases then begin at a row.
double in_rows(double hours) { return std::round(12.0 * hours) / 12.0; }

class Dice {
public:
  explicit Dice(std::uint64_t seed) : engine_(7919 * seed + 17) {}
  double between(double low, double high) { return low + (high - low) * (engine_() >> 11) * 0x1p-53; }
  bool often(double share) { return between(0.0, 1.0) < share; }

private:
  std::mt19937_64 engine_;
};

std::string phase(const mesh::Machine& machine, Dice& dice, double hours, const std::string& name) {
  std::string text = fmt::format("[[phase]]\nname = \"{}\"\nduration_h = {:.10g}\nmachine_on = true\n", name, hours);
  text +=
      fmt::format("spindle_rpm = {:.0f}\n", dice.often(0.7) ? dice.between(0.1, 1.0) * machine.spindle_max_rpm : 0.0);
  for (const mesh::Axis& axis : machine.axes) {
    const bool linear = axis.kind == mesh::AxisKind::linear;
    if (!dice.often(linear ? 0.6 : 0.35)) continue;
    const double share = dice.between(0.1, 0.7);
    text += fmt::format("[[phase.axis]]\nid = \"{}\"\n", axis.id);
    if (axis.endless) {
      text += fmt::format("speed_rpm = {:.1f}\n", share * axis.rapid / core::units::rpm);
    } else {
      const double unit = linear ? 1e3 : 180.0 / std::numbers::pi, reach = dice.between(0.2, 0.9),
                   range = axis.high - axis.low;
      const double low = axis.low + dice.between(0.0, 1.0 - reach) * range;
      text += fmt::format("low_{0} = {1:.1f}\nhigh_{0} = {2:.1f}\nfeed_{0}_min = {3:.0f}\n", linear ? "mm" : "deg",
                          unit * low, unit * (low + reach * range), unit * core::units::minute * share * axis.rapid);
      text += fmt::format("duty_percent = {:.0f}\n", dice.between(20.0, 100.0));
    }
  }
  return text;
}

}  // namespace

std::string random_power_off(const mesh::Machine& machine, std::uint64_t seed) {
  Dice dice(seed);
  const double hall = machine.reference_C + dice.between(-2.0, 12.0), off_h = in_rows(dice.between(0.5, 10.0));
  std::string text = fmt::format(
      "schema = 1\ntitle = \"work, power-off, work\"\ninitial_C = {:.2f}\ntime_step_s = 60\noutput_s = 300\n", hall);
  std::string first = phase(machine, dice, in_rows(dice.between(1.0, 3.0)), "work 1");
  std::string surroundings = fmt::format("air_C = {:.2f}\n", hall);
  for (const mesh::AmbientSpec& ambient : machine.ambients) {
    if (ambient.id == "foundation") surroundings += fmt::format("foundation_C = {:.2f}\n", hall);
  }
  text += first.insert(first.find("machine_on"), surroundings);
  text += phase(machine, dice, in_rows(dice.between(1.0, 3.0)), "work 2");
  text += fmt::format(
      "[[phase]]\nname = \"off\"\nduration_h = {:.10g}\nspindle_rpm = 0\nmachine_on = false\nair_C = [{:.2f}, "
      "{:.2f}]\n",
      off_h, hall, hall + dice.between(-1.5, 0.5));
  return text + phase(machine, dice, back_h, "back");
}

MeasuredLoad power_off_load(const mesh::Machine& machine, std::uint64_t seed) {
  std::string text = random_power_off(machine, seed);
  solver::LoadProgram program = solver::LoadProgram::parse(text, fmt::format("power_off_{}.toml", seed), machine);
  return {std::move(program), std::move(text)};
}

std::vector<double> PowerOffStudy::left_percent(int moment) const {
  std::vector<double> values;
  for (const PowerOffRow& row : rows) values.push_back(100.0 * row.left_um[moment] / row.before_um[moment]);
  return values;
}

Rows PowerOffStudy::summary() const {
  Rows table{{"machines", "residual % after 5 min: median", "90th percentile", "after 30 min: median",
              "90th percentile", "after 2 h: median", "90th percentile"},
             {std::to_string(rows.size())}};
  for (int k = 0; k < 3; ++k) {
    for (const double share : {0.5, 0.9})
      table.back().push_back(fmt::format("{:.1f}", quantile(left_percent(k), share)));
  }
  return table;
}

PowerOffStudy PowerOffStudy::first(int draws) const {
  PowerOffStudy part = *this;
  std::erase_if(part.rows, [&](const PowerOffRow& row) { return row.draw >= draws; });
  return part;
}

Rows PowerOffStudy::table() const {
  Rows table{{"machine", "hall degC", "worked h", "off h", "RMS um after 5 min", "residual %", "after 30 min um",
              "residual %", "after 2 h um", "residual %"}};
  for (const PowerOffRow& row : rows) {
    table.push_back({std::to_string(row.draw + 1), fmt::format("{:.1f}", row.hall_C),
                     fmt::format("{:.1f}", row.worked_h), fmt::format("{:.1f}", row.off_h)});
    for (int k = 0; k < 3; ++k) {
      table.back().push_back(fmt::format("{:.2f}", row.before_um[k]));
      table.back().push_back(fmt::format("{:.1f}", 100.0 * row.left_um[k] / row.before_um[k]));
    }
  }
  for (const auto& [name, share] : {std::pair{"median", 0.5}, {"90th percentile", 0.9}}) {
    table.push_back({name, "", "", ""});
    for (int k = 0; k < 3; ++k) {
      table.back().push_back("");
      table.back().push_back(fmt::format("{:.1f}", quantile(left_percent(k), share)));
    }
  }
  return table;
}

std::string PowerOffStudy::unmoved_sentence() const {
  if (unmoved_directions.empty()) return "";
  std::vector<double> shares;
  for (const PowerOffRow& row : rows) shares.push_back(100.0 * row.unmoved_um[2] / row.before_um[2]);
  return fmt::format("No axis moves the tool along {}: {:.1f} % of the RMS after 2 h (median) stay there.",
                     unmoved_directions, quantile(shares, 0.5));
}

std::string PowerOffStudy::brief() const {
  const std::string stays = unmoved_sentence();
  return core::format_table(table()) + stays + (stays.empty() ? "" : "\n");
}

PowerOffStudy study_power_off(const solver::Case& machine_case, const reduction::ReducedModel& model,
                              const ValidationOptions& options) {
  options.validate();
  require_check_points(machine_case);
  MeasuredMachines machines(machine_case, options.machine, options.keep, options.reference);
  PowerOffStudy study;
  for (int draw = 0; draw < options.draws; ++draw) {
    const std::uint64_t seed = options.first_seed + draw;
    const MeasuredLoad measured_load = power_off_load(machine_case.machine, seed);
    const solver::LoadProgram& load = measured_load.program;
    const Measurement measurement = machines.measure(seed, measured_load);
    std::vector<mesh::Pose> poses;
    const std::vector<Eigen::Matrix3Xd> measured =
        detail::measured_translations(measurement, machine_case.machine, poses);
    std::vector<AxisReach> reaches;
    for (const mesh::Pose& pose : poses) reaches.emplace_back(machine_case.machine, pose);
    const Eigen::VectorXd time = measurement.time();
    const double returned = load.duration() - core::units::hour * back_h;
    Index from = 0;
    while (from + 1 < time.size() && time[from] < returned - 1.0) ++from;
    PowerOffRow row;
    row.draw = draw;
    row.hall_C = load.initial_C();
    for (const double corner : load.stops()) {
      if (row.worked_h == 0.0 && load.phase_at(corner + 1.0) == "off") row.worked_h = corner / core::units::hour;
    }
    row.off_h = returned / core::units::hour - row.worked_h;
    const auto errors = run_compensator(measurement, model, poses, {true, false, from, true});
    for (int k = 0; k < 3; ++k) {
      Index at = from;
      while (at + 1 < time.size() && time[at] < time[from] + after_s[k] - 1.0) ++at;
      for (std::size_t p = 0; p < poses.size(); ++p) {
        const Eigen::Vector3d truth = measured[p].col(at);
        const Eigen::Vector3d cancelled = errors[p][at - from].error.head<3>() / core::units::um;
        row.before_um[k] += truth.squaredNorm();
        row.left_um[k] += (truth - cancelled).squaredNorm();
        row.unmoved_um[k] += reaches[p].unmoved(truth).squaredNorm();
      }
      const double count = poses.size();
      row.unmoved_um[k] = std::sqrt(row.unmoved_um[k] / count);
      row.before_um[k] = std::sqrt(row.before_um[k] / count);
      row.left_um[k] = std::sqrt(row.left_um[k] / count);
    }
    study.rows.push_back(row);
  }
  study.measured_nodes = machines.nodes();
  study.unmoved_directions = AxisReach(machine_case.machine, machine_case.check_points.front()).unmoved_directions();
  return study;
}

}  // namespace thermotwin::compensation
