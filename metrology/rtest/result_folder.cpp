// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/result_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <regex>

#include "core/error.h"
#include "core/progress.h"
#include "core/units.h"

namespace thermotwin::metrology {

using compensation::Measurement;
using compensation::MeasuredChannel;
using core::Table;
using Eigen::Index;

namespace {

constexpr double same_time = 1e-3;  ///< s

/// The rows of both tables in the order of time; a time that both have is one row.
Table merged(const Table& a, const Table& b) {
  std::map<double, std::pair<Index, Index>> rows;
  for (Index i = 0; i < a.rows(); ++i) rows[a.values(i, 0)] = {i, -1};
  for (Index i = 0; i < b.rows(); ++i) {
    const auto near = rows.lower_bound(b.values(i, 0) - same_time);
    const bool found = near != rows.end() && near->first <= b.values(i, 0) + same_time && near->second.second < 0;
    if (found) {
      near->second.second = i;
    } else {
      rows.try_emplace(b.values(i, 0), -1, i);
    }
  }
  Table table;
  table.source = a.source;
  table.columns = a.columns;
  table.columns.insert(table.columns.end(), b.columns.begin() + 1, b.columns.end());
  table.values.setConstant(std::ssize(rows), std::ssize(table.columns), std::numeric_limits<double>::quiet_NaN());
  Index row = 0;
  for (const auto& [time, at] : rows) {
    table.values(row, 0) = time;
    if (at.first >= 0)
      table.values.block(row, 1, 1, a.values.cols() - 1) = a.values.row(at.first).tail(a.values.cols() - 1);
    if (at.second >= 0)
      table.values.row(row).tail(b.values.cols() - 1) = b.values.row(at.second).tail(b.values.cols() - 1);
    ++row;
  }
  return table;
}

/// One clock: the times of the test lie among those of the record of loads.
void require_one_clock(const Table& test, const Table& beside) {
  const double first = beside.values(0, 0), last = beside.values(beside.rows() - 1, 0);
  Index outside = 0;
  for (const double time : test.values.col(0)) outside += time < first - same_time || time > last + same_time;
  if (outside == 0) return;
  const double begin = test.values(0, 0), end = test.values(test.rows() - 1, 0);
  const std::string of_record = fmt::format("time_s {:.10g} to {:.10g}", first, last),
                    of_test = fmt::format("{:.10g} to {:.10g} s", begin, end);
  if (outside == test.rows())
    throw core::InputError(beside.source, of_record,
                           "times among those of the test, " + of_test + ": one clock for both");
  core::warn(fmt::format("{}: {} lies beside {} of {} rows of the test ({}); both need one clock", beside.source,
                         of_record, outside, test.rows(), of_test));
}

/// A measurement beside the loads and temperatures of another.
Measurement with_record(const Measurement& measurement, const std::optional<Measurement>& beside) {
  if (!beside) return measurement;
  for (const MeasuredChannel& channel : beside->channels) {
    if (measurement.data.find(channel.id)) {
      throw core::InputError((beside->folder / "channels.toml").string(), "channel '" + channel.id + "'",
                             "ids that are no location errors of the test");
    }
  }
  require_one_clock(measurement.data, beside->data);
  Measurement both = *beside;
  both.channels.insert(both.channels.end(), measurement.channels.begin(), measurement.channels.end());
  both.data = merged(beside->data, measurement.data);
  for (MeasuredChannel& channel : both.channels) channel.column = *both.data.find(channel.id);
  return both;
}

}  // namespace

void require_pose_text(const std::string& text, const std::string& place) {
  static const std::regex pose(R"([A-Z][0-9]?=[-+]?[0-9]+(\.[0-9]*)?(,[A-Z][0-9]?=[-+]?[0-9]+(\.[0-9]*)?)*)");
  if (text.empty() || (text.size() < 200 && std::regex_match(text, pose))) return;
  throw core::InputError(place, "'" + text.substr(0, 200) + "'", "positions of axes in mm and deg, such as X=0,B=90");
}

bool is_quantity(const std::string& name) {
  if (name.size() == 2) return std::string("dr").find(name[0]) != std::string::npos;
  return name == "R0T" ||
         (name.size() == 3 && name[1] == '0' && std::string("ABCT").find(name[2]) != std::string::npos);
}

Table error_table(const Estimates& estimates) {
  Table table;
  table.source = "location_errors.csv";
  table.columns = {"time_s"};
  const std::vector<std::size_t> errors = estimates.observed();
  for (const char* prefix : {"", "std_"}) {
    for (const std::size_t e : errors) {
      std::string unit = estimates.units[e];
      if (const std::size_t slash = unit.find('/'); slash != std::string::npos) unit.replace(slash, 1, "_per_");
      table.columns.push_back(prefix + estimates.errors[e] + "_" + unit);
    }
  }
  table.values.resize(std::ssize(estimates.cycles), std::ssize(table.columns));
  for (Index i = 0; i < table.rows(); ++i) {
    const CycleResult& cycle = estimates.cycles[i];
    table.values(i, 0) = cycle.time;
    Index column = 1;
    for (const std::size_t e : errors) table.values(i, column++) = cycle.value[e] / core::units::um;
    for (const std::size_t e : errors) table.values(i, column++) = cycle.std[e] / core::units::um;
  }
  return table;
}

Measurement measurement_of(const Estimates& estimates, const std::string& pose, bool against_first,
                           const std::optional<Measurement>& beside) {
  const std::vector<std::size_t> errors = estimates.observed();
  const Table all = error_table(estimates);
  Measurement measurement;
  measurement.data.source = all.source;
  measurement.data.columns = {"time_s"};
  measurement.data.values = all.values.leftCols(1);
  for (std::size_t k = 0; k < errors.size(); ++k) {
    const std::size_t e = errors[k];
    if (!is_quantity(estimates.errors[e])) continue;
    MeasuredChannel channel;
    channel.id = channel.quantity = estimates.errors[e];
    channel.kind = compensation::ChannelKind::displacement;
    channel.unit = estimates.units[e];
    for (const CycleResult& cycle : estimates.cycles)
      channel.uncertainty = std::max(channel.uncertainty, cycle.std[e] / core::units::um);
    channel.pose_text = pose;
    channel.zero = against_first ? compensation::Zero::first : compensation::Zero::absolute;
    channel.column = std::ssize(measurement.data.columns);
    measurement.data.columns.push_back(channel.id);
    measurement.data.values.conservativeResize(Eigen::NoChange, channel.column + 1);
    measurement.data.values.col(channel.column) = all.values.col(1 + k);
    measurement.channels.push_back(channel);
  }
  return with_record(measurement, beside);
}

Measurement measurement_of(const RTestRecord& record, const RTestAnalysis& analysis, const TestPoints& points,
                           const std::optional<Measurement>& beside) {
  const std::string pose = place_text(record, record.cycles.front().points.front());
  Measurement measurement = measurement_of(analysis, pose, record.against_first, std::nullopt);
  if (points.empty()) return with_record(measurement, beside);
  std::string id = "rtest";
  const auto taken = [&] {
    return beside && std::any_of(beside->channels.begin(), beside->channels.end(),
                                 [&](const MeasuredChannel& channel) { return channel.arrangement == id; });
  };
  for (int k = 2; taken(); ++k) id = fmt::format("rtest{}", k);
  for (MeasuredChannel& channel : measurement.channels) {
    const Index e =
        std::find(analysis.errors.begin(), analysis.errors.end(), channel.quantity) - analysis.errors.begin();
    channel.pose_text.clear();
    channel.arrangement = id;
    for (std::size_t i = 0; i < points.poses.size(); ++i)
      channel.points.push_back({points.poses[i], points.weights.row(e).segment<3>(3 * i).transpose()});
    channel.uncertainty = 0.0;  // of the cycles that are not blank
    for (Index c = 0; c < measurement.data.rows(); ++c) {
      if (points.of_cycles[c])
        channel.uncertainty = std::max(channel.uncertainty, analysis.cycles[c].std[e] / core::units::um);
      if (!points.of_cycles[c]) measurement.data.values(c, channel.column) = std::numeric_limits<double>::quiet_NaN();
    }
  }
  return with_record(measurement, beside);
}

Measurement measurement_of(const RTestRecord& record, const RTestAnalysis& analysis,
                           const std::optional<Measurement>& beside) {
  return measurement_of(record, analysis, common_points(record, analysis), beside);
}

Measurement points_measurement_of(const RTestRecord& record, const std::optional<Measurement>& beside) {
  std::map<std::string, std::size_t> places;  // by pose, numbered as they come
  const auto key_of = [&](RTestPoint point) {
    constexpr double turn = 2.0 * std::numbers::pi;
    for (auto& [axis, position] : point.positions)
      if (record.chain.find(axis)->rotary) position -= turn * std::floor(position / turn + 1e-9);
    return place_text(record, point);
  };
  Measurement measurement;
  measurement.data.source = record.source;
  measurement.data.columns = {"time_s"};
  struct Row {
    double time;
    std::size_t place;
    Eigen::Vector3d deviation;
  };
  std::vector<Row> rows;
  for (const RTestCycle& cycle : record.cycles) {
    if (cycle.points.size() > most_places) {
      throw core::InputError(
          cycle.place, fmt::format("{} points", cycle.points.size()),
          fmt::format("at most {} points a cycle for channels of points; --channels errors has no limit", most_places));
    }
    std::vector<std::size_t> seen;
    for (const RTestPoint& point : cycle.points) {
      const std::size_t place = places.emplace(key_of(point), places.size()).first->second;
      if (std::find(seen.begin(), seen.end(), place) != seen.end()) continue;
      seen.push_back(place);
      rows.push_back({point.time, place, point.deviation});
      if (3 * place + 1 < measurement.data.columns.size()) continue;
      for (const char* quantity : {"dx", "dy", "dz"}) {
        MeasuredChannel channel;
        channel.id = fmt::format("{}@{}", quantity, place + 1);
        channel.quantity = quantity;
        channel.kind = compensation::ChannelKind::displacement;
        channel.unit = "um";
        channel.uncertainty = record.std / core::units::um;
        channel.pose_text = place_text(record, point);
        channel.zero = record.against_first ? compensation::Zero::first : compensation::Zero::absolute;
        channel.column = std::ssize(measurement.data.columns);
        measurement.data.columns.push_back(channel.id);
        measurement.channels.push_back(channel);
      }
    }
  }
  measurement.data.values.setConstant(std::ssize(rows), std::ssize(measurement.data.columns),
                                      std::numeric_limits<double>::quiet_NaN());
  for (Index i = 0; i < std::ssize(rows); ++i) {
    measurement.data.values(i, 0) = rows[i].time;
    measurement.data.values.row(i).segment<3>(1 + 3 * (rows[i].place)) =
        (rows[i].deviation / core::units::um).transpose();
  }
  return with_record(measurement, beside);
}

}  // namespace thermotwin::metrology
