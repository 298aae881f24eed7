// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/evaluation/restart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>

#include "compensation/control/online_twin.h"
#include "compensation/evaluation/replay.h"
#include "compensation/online/axis_reach.h"
#include "compensation/online/output_map.h"
#include "core/error.h"
#include "core/text.h"
#include "core/units.h"
#include "solver/campaign/case.h"

namespace thermotwin::compensation {
namespace {

using core::units::hour;
using Eigen::Index;
using Eigen::VectorXd;

constexpr double row_s = 60.0;                       ///< of a control
constexpr double quick_s = 1.0, quick_for_s = 60.0;  ///< rows after the return, while the offsets move from 0
constexpr const char* off_name = "off between";
constexpr double RestartRow::*values[] = {&RestartRow::before_um, &RestartRow::through_um, &RestartRow::restarted_um,
                                          &RestartRow::at_once_um};

/// When the hour begins; negative: there is none.
double off_at(const solver::LoadProgram& program) {
  double from = 0.0;
  for (const double stop : program.stops()) {
    if (program.phase_at(0.5 * (from + stop)) == off_name) return from;
    from = stop;
  }
  return -1.0;
}

/// The text with the hour before the line of a phase.
std::string off_before(const std::vector<std::string>& lines, std::size_t phase_line) {
  std::string text;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (i == phase_line)
      text += fmt::format("[[phase]]\nname = \"{}\"\nduration_h = 1\nmachine_on = false\n", off_name);
    text += lines[i] + "\n";
    if (i == phase_line) text += "machine_on = true\n";
  }
  return text;
}

/// A compensator with a guard at each check point.
class Judged {
public:
  Judged(const Measurement& measurement, const reduction::ReducedModel& model)
      : machine_(model.machine),
        map_(model),
        measured_(detail::measured_translations(measurement, model.machine, poses_)),
        time_(measurement.time()) {
    const solver::Channels channels(model.machine);
    rows_ = compensator_rows(measurement, model.machine, channels, {});
    readings_ = sensor_readings(measurement, model.machine);
    for (Index k = 0; k < channels.size(); ++k) {
      if (!std::isnan(channels.defaults()[k]) && rows_.col(k).array().isNaN().all()) absent_.push_back(k);
    }
    for (const mesh::Pose& pose : poses_) reaches_.emplace_back(machine_, pose);
  }

  const VectorXd& time() const { return time_; }

  void begin(OnlineTwin& twin) {
    twin.never_told(absent_);
    GuardOptions limits;
    limits.largest_um = twin.limits().largest_um;
    limits.rate_um_s = twin.limits().rate_um_s;
    guards_.assign(poses_.size(), OffsetGuard(std::ssize(twin.axes()), limits));
  }

  /// Sums of the squares over the check points, um2.
  struct Left {
    double guarded = 0.0, at_once = 0.0;
  };

  /// Takes a row.
  Left step(OnlineTwin& twin, Index i) {
    twin.step(time_[i], rows_.row(i).transpose(), readings_.row(i).transpose());
    Left left;
    for (std::size_t p = 0; p < poses_.size(); ++p) {
      const VectorXd wanted_um = map_.offsets(twin.tcp(poses_[p])) / core::units::um;
      const VectorXd& applied_um = guards_[p].step(time_[i], wanted_um);
      left.guarded += (measured_[p].col(i) + reaches_[p].motion(applied_um)).squaredNorm();
      left.at_once += (measured_[p].col(i) + reaches_[p].motion(wanted_um)).squaredNorm();
    }
    return left;
  }
  double before(Index i) const {
    double sum = 0.0;
    for (const Eigen::Matrix3Xd& measured : measured_) sum += measured.col(i).squaredNorm();
    return sum;
  }
  double poses() const { return poses_.size(); }

private:
  const mesh::Machine& machine_;
  OutputMap map_;
  std::vector<mesh::Pose> poses_;
  std::vector<Eigen::Matrix3Xd> measured_;
  VectorXd time_;
  Eigen::MatrixXd rows_, readings_;
  std::vector<Index> absent_;
  std::vector<AxisReach> reaches_;
  std::vector<OffsetGuard> guards_;
};

RestartRow judge(const Measurement& measurement, const reduction::ReducedModel& model,
                 const solver::LoadProgram& program, double rate_um_s) {
  Judged judged(measurement, model);
  const double begin = off_at(program), end = begin + hour;
  const auto& time = judged.time();
  ControlOptions options;
  options.compensator.start_C = start_temperature(measurement, model.machine);
  options.compensator.rate_um_s = rate_um_s;
  RestartRow row;
  row.load = program.name();
  row.off_at_h = begin / hour;
  double count = 0;
  std::string state;
  for (const bool stops : {false, true}) {
    std::optional<OnlineTwin> twin(std::in_place, model, options);
    judged.begin(*twin);
    row.rate_um_s = twin->limits().rate_um_s;
    double& sum = stops ? row.restarted_um : row.through_um;
    for (Index i = 0; i < time.size() && time[i] <= end + hour + 1e-6; ++i) {
      const bool is_off = time[i] > begin + 1e-6 && time[i] <= end + 1e-6;
      if (stops && is_off) {
        if (state.empty()) state = twin->saved();
        continue;
      }
      if (stops && !state.empty()) {
        twin.emplace(model, options);
        twin->load(state);
        judged.begin(*twin);
        state.clear();
      }
      const Judged::Left left = judged.step(*twin, i);
      if (time[i] <= end + 1e-6) continue;
      const double duration = time[i] - time[i - 1];
      sum += duration * left.guarded;
      if (stops) {
        row.at_once_um += duration * left.at_once;
        continue;
      }
      row.before_um += duration * judged.before(i);
      count += duration * judged.poses();
    }
  }
  for (double RestartRow::*value : values) row.*value = std::sqrt(row.*value / count);
  return row;
}

double rms(const std::vector<RestartRow>& rows, const std::string& load, double RestartRow::*value) {
  double sum = 0.0, count = 0.0;
  for (const RestartRow& row : rows) {
    if (row.load != load) continue;
    sum += row.*value * (row.*value);
    ++count;
  }
  return std::sqrt(sum / count);
}

std::vector<std::string> cells(const RestartRow& row) {
  std::vector<std::string> texts;
  for (const double value : {row.before_um, row.through_um, row.restarted_um, row.restarted_um / row.through_um,
                             row.at_once_um, row.at_once_um / row.through_um})
    texts.push_back(fmt::format("{:.2f}", value));
  return texts;
}

const std::vector<std::string> value_columns{"RMS um before", "never stopped",   "restarted",
                                             "ratio",         "offsets at once", "ratio at once"};

}  // namespace

std::string with_hour_off(const std::string& text, const std::string& name, const mesh::Machine& machine) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  std::string best;
  double nearest = std::numeric_limits<double>::infinity();
  bool is_first = true;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (!core::trimmed(lines[i]).starts_with("[[phase]]")) continue;
    const bool can_be = !is_first;
    is_first = false;
    if (!can_be) continue;
    std::string candidate = off_before(lines, i);
    const solver::LoadProgram program = solver::LoadProgram::parse(candidate, name + ".toml", machine);
    const double begin = off_at(program), duration = program.duration();
    const double off_middle = std::abs(begin - 0.5 * (duration - hour));
    if (begin + 2.0 * hour > duration + 1e-6 || off_middle >= nearest) continue;
    nearest = off_middle;
    best = std::move(candidate);
  }
  if (best.empty())
    throw core::InputError("load program " + name, "no phase begins an hour or more before its end",
                           "two phases or more, the later ones at least an hour long");
  return best;
}

std::vector<MeasuredLoad> restart_loads(const solver::Case& machine_case, const ValidationOptions& options) {
  std::vector<MeasuredLoad> loads;
  for (const MeasuredLoad& load : validation_loads(machine_case, options)) {
    const std::string& name = load.program.name();
    std::string text = with_hour_off(load.text, name, machine_case.machine);
    solver::LoadProgram program = solver::LoadProgram::parse(text, name + "_off.toml", machine_case.machine);
    if (load.program.has_time()) program.set_time(load.program.time());
    std::vector<double> times;
    const double last = std::min(off_at(program) + 2.0 * hour, program.duration());
    const double back = last - hour;
    for (double t = 0.0; t < last - 1e-6; t += row_s) {
      times.push_back(t);
      for (double s = quick_s; t >= back - 1e-6 && t < back + quick_for_s - 1e-6 && s < row_s; s += quick_s)
        times.push_back(t + s);
    }
    times.push_back(last);
    program.choose_outputs(times, program.name());
    text += fmt::format("# rows every {} s, after the return every {} s\n", row_s, quick_s);
    loads.push_back({std::move(program), std::move(text)});
  }
  return loads;
}

std::vector<std::string> RestartStudy::loads() const {
  std::vector<std::string> names;
  for (const RestartRow& row : rows)
    if (std::find(names.begin(), names.end(), row.load) == names.end()) names.push_back(row.load);
  return names;
}

double RestartStudy::ratio(const std::string& load) const {
  return rms(rows, load, &RestartRow::restarted_um) / rms(rows, load, &RestartRow::through_um);
}

double RestartStudy::ratio_at_once(const std::string& load) const {
  return rms(rows, load, &RestartRow::at_once_um) / rms(rows, load, &RestartRow::through_um);
}

Rows RestartStudy::table() const {
  Rows table{{"load", "machine", "off at h"}};
  table.front().insert(table.front().end(), value_columns.begin(), value_columns.end());
  for (const RestartRow& row : rows) {
    table.push_back({row.load, std::to_string(row.draw + 1), fmt::format("{:.2f}", row.off_at_h)});
    const std::vector<std::string> texts = cells(row);
    table.back().insert(table.back().end(), texts.begin(), texts.end());
  }
  return table;
}

Rows RestartStudy::summary() const {
  Rows table{{"load", "machines"}};
  table.front().insert(table.front().end(), value_columns.begin(), value_columns.end());
  for (const std::string& load : loads()) {
    const auto machines =
        std::count_if(rows.begin(), rows.end(), [&](const RestartRow& row) { return row.load == load; });
    table.push_back({load, std::to_string(machines)});
    RestartRow all;
    for (double RestartRow::*value : values) all.*value = rms(rows, load, value);
    const std::vector<std::string> texts = cells(all);
    table.back().insert(table.back().end(), texts.begin(), texts.end());
  }
  return table;
}

std::string RestartStudy::brief() const {
  return core::format_table(table()) + core::format_table(summary()) +
         (rows.empty()
              ? ""
              : fmt::format("offsets move from 0 at {:.3g} um/s at most; the last two columns are without this "
                            "limit\n",
                            rows.front().rate_um_s));
}

RestartStudy RestartStudy::first(int draws) const {
  RestartStudy part = *this;
  std::erase_if(part.rows, [&](const RestartRow& row) { return row.draw >= draws; });
  return part;
}

RestartStudy study_restart(const solver::Case& machine_case, const reduction::ReducedModel& model,
                           const ValidationOptions& options) {
  RestartStudy study;
  const auto take = [&](int draw, const MeasuredLoad& load, const Measurement& measurement) {
    RestartRow row = judge(measurement, model, load.program, options.rate_um_s);
    row.draw = draw;
    study.rows.push_back(std::move(row));
  };
  study.measured_nodes = measure_each(machine_case, restart_loads(machine_case, options), options, take);
  return study;
}

}  // namespace thermotwin::compensation
