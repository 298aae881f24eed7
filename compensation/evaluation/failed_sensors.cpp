// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/evaluation/failed_sensors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <set>
#include <sstream>

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

constexpr double row_s = 60.0;                  ///< of a control
constexpr double earliest = 0.2, latest = 0.6;  ///< share of the record at which a sensor fails
constexpr Index smooth = 2;                     ///< rows to both sides that tell where a reading truly is
constexpr double soon_min = 15.0;
const char* const faults[] = {"stuck", "offset", "noise", "absent"};

void spoil(Eigen::Ref<Eigen::VectorXd> readings, Index from, std::string_view fault, double deviation,
           std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const double held = readings[from];
  for (Index i = from; i < readings.size(); ++i) {
    if (fault == "stuck")
      readings[i] = held;
    else if (fault == "offset")
      readings[i] += 2.0;
    else if (fault == "noise")
      readings[i] += std::sqrt(99.0) * deviation * normal(random);
    else
      readings[i] = solver::not_given;
  }
}

/// First row at which the reading, smoothed, has moved by so much since a row; the rows' number: never.
Index moved(const Eigen::VectorXd& readings, Index from, double by) {
  const auto near = [&](Index i) { return readings.segment(i - smooth, 2 * smooth + 1).mean(); };
  for (Index i = from; i + smooth < readings.size(); ++i)
    if (std::abs(near(i) - readings[from]) > by) return i;
  return readings.size();
}

std::set<std::string> names(const std::string& failed) {
  std::set<std::string> all;
  std::istringstream items(failed);
  for (std::string item; items >> item;) all.insert(item.substr(0, item.find('=')));
  return all;
}

struct Judged {
  const Measurement& measurement;
  std::vector<mesh::Pose> poses;
  std::vector<Eigen::Matrix3Xd> measured;  ///< the part that linear axes move

  Judged(const Measurement& m, const mesh::Machine& machine) : measurement(m) {
    measured = detail::measured_translations(m, machine, poses);
    for (std::size_t p = 0; p < poses.size(); ++p) {
      const AxisReach reach(machine, poses[p]);
      for (auto truth : measured[p].colwise()) truth -= reach.unmoved(truth);
    }
  }
  /// Share of the RMS over the check points that the offsets remove from a row on, percent.
  double removed(const std::vector<std::vector<solver::TcpError>>& errors, Index from) const {
    double before = 0.0, left = 0.0;
    for (std::size_t p = 0; p < poses.size(); ++p) {
      for (Index i = from; i < measurement.data.rows(); ++i) {
        const Eigen::Vector3d truth = measured[p].col(i);
        if (!truth.allFinite()) continue;
        before += truth.squaredNorm();
        left += (truth - errors[p][i].error.head<3>() / core::units::um).squaredNorm();
      }
    }
    return 100.0 * (1.0 - std::sqrt(left / before));
  }
};

}  // namespace

std::vector<MeasuredLoad> failed_sensor_loads(const solver::Case& machine_case, const ValidationOptions& options) {
  std::vector<MeasuredLoad> loads = validation_loads(machine_case, options);
  for (MeasuredLoad& load : loads) {
    std::vector<double> times;
    for (double t = 0.0; t < load.program.duration() - 1e-6; t += row_s) times.push_back(t);
    times.push_back(load.program.duration());
    load.program.choose_outputs(times, load.program.name());
    load.text += fmt::format("# rows every {} s", row_s);
  }
  return loads;
}

FailedSensorStudy study_failed_sensors(const solver::Case& machine_case, const reduction::ReducedModel& model,
                                       const ValidationOptions& options) {
  const mesh::Machine& machine = machine_case.machine;
  FailedSensorStudy study;
  MeasuredRun how;
  how.guarded = true;
  const auto take = [&](int draw, const MeasuredLoad& load, const Measurement& whole) {
    const std::uint64_t seed = options.first_seed + draw;
    const std::string& name = load.program.name();
    const Judged judged(whole, machine);
    std::vector<std::string> named;
    const auto undisturbed = run_compensator(whole, model, judged.poses, how, nullptr, &named);
    std::set<std::string> alarms;
    for (const std::string& row : named) alarms.merge(names(row));
    study.alarms.resize(draw + 1);
    study.alarms[draw] += std::ssize(alarms);
    for (std::size_t c = 0; c < whole.channels.size(); ++c) {
      const MeasuredChannel& channel = whole.channels[c];
      if (machine.sensor_index(channel.sensor) < 0) continue;
      const Eigen::VectorXd readings = whole.values(channel);
      for (std::size_t f = 0; f < std::size(faults); ++f) {
        std::mt19937_64 random(1000 * seed + 10 * c + f);
        const double share = std::uniform_real_distribution<double>(earliest, latest)(random);
        const auto from = std::max<Index>(smooth, static_cast<Index>(share * readings.size()));
        Measurement spoilt = whole;
        spoil(spoilt.data.values.col(channel.column), from, faults[f], channel.uncertainty, random);
        named.clear();
        const auto errors = run_compensator(spoilt, model, judged.poses, how, nullptr, &named);
        FailedSensorRow row{
            name, channel.sensor, faults[f], draw, judged.removed(undisturbed, from), judged.removed(errors, from)};
        const Index clock = row.fault == "stuck" ? moved(readings, from, 5.0 * channel.uncertainty) : from;
        row.told = clock < readings.size();
        row.named_min = std::numeric_limits<double>::infinity();
        std::set<std::string> others;
        const Eigen::VectorXd time = whole.time();
        for (Index i = from; i < readings.size(); ++i) {
          std::set<std::string> now = names(named[i]);
          if (now.erase(channel.sensor) > 0 && !std::isfinite(row.named_min))
            row.named_min = std::max(0.0, time[i] - time[std::min(clock, readings.size() - 1)]) / core::units::minute;
          others.merge(now);
        }
        row.false_names = others.size();
        study.rows.push_back(row);
      }
    }
  };
  study.measured_nodes = measure_each(machine_case, failed_sensor_loads(machine_case, options), options, take);
  return study;
}

int FailedSensorStudy::false_alarms() const { return std::accumulate(alarms.begin(), alarms.end(), 0); }

FailedSensorStudy FailedSensorStudy::first(int draws) const {
  FailedSensorStudy part = *this;
  std::erase_if(part.rows, [&](const FailedSensorRow& row) { return row.draw >= draws; });
  part.alarms.resize(std::min<std::ptrdiff_t>(draws, std::ssize(alarms)));
  return part;
}

std::string FailedSensorStudy::brief() const {
  return core::format_table(summary()) +
         fmt::format(
             "cost: share of the reduction with all sensors that is lost after the failure\nnamed after: since the "
             "failure; for a stuck sensor, since the true reading has moved by 5 standard deviations\nfalse alarms (a "
             "sensor named though none had failed): {}\n",
             false_alarms());
}

Rows FailedSensorStudy::summary() const {
  Rows table{{"program", "fault", "cases", "cost %: median", "90th percentile", "largest", "at", "above 20 %",
              "named after min: median", "90th percentile", "within 15 min %", "never named", "intact sensors named"}};
  std::vector<std::pair<std::string, std::string>> groups;
  for (const FailedSensorRow& row : rows) {
    if (std::find(groups.begin(), groups.end(), std::pair{row.load, row.fault}) == groups.end())
      groups.emplace_back(row.load, row.fault);
  }
  for (const auto& [load, fault] : groups) {
    std::vector<double> costs, times;
    const FailedSensorRow* worst = nullptr;
    int cases = 0, dear = 0, soon = 0, never = 0, others = 0;
    for (const FailedSensorRow& row : rows) {
      if (row.load != load || row.fault != fault) continue;
      ++cases;
      costs.push_back(row.cost_percent());
      dear += row.cost_percent() > 20.0;
      others += row.false_names;
      if (worst == nullptr || row.cost_percent() > worst->cost_percent()) worst = &row;
      if (!row.told) continue;
      times.push_back(row.named_min);
      soon += row.named_min <= soon_min;
      never += !std::isfinite(row.named_min);
    }
    // quantile() interpolates: of a time that is infinite it is infinite.
    const auto minutes = [&](double share) {
      const double t = quantile(times, share);
      return std::isfinite(t) ? fmt::format("{:.0f}", t) : std::string("-");
    };
    table.push_back({load, fault, std::to_string(cases), fmt::format("{:.1f}", quantile(costs, 0.5)),
                     fmt::format("{:.1f}", quantile(costs, 0.9)), fmt::format("{:.1f}", worst->cost_percent()),
                     fmt::format("{}, machine {}", worst->sensor, worst->draw + 1), std::to_string(dear), minutes(0.5),
                     minutes(0.9), times.empty() ? "-" : fmt::format("{:.0f}", 100.0 * soon / times.size()),
                     std::to_string(never), std::to_string(others)});
  }
  return table;
}

}  // namespace thermotwin::compensation
