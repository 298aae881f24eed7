// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/record/several_records.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace thermotwin::diagnosis {

using compensation::Measurement;
using Eigen::Index;

std::vector<std::string> record_names(Records records) {
  if (records.size() == 1) return {""};
  std::vector<std::string> names;
  for (const Measurement& record : records) {
    const std::filesystem::path folder = std::filesystem::absolute(record.folder).lexically_normal();
    const std::string own =
        folder.has_filename() ? folder.filename().string() : folder.parent_path().filename().string();
    std::string name = own;
    for (int number = 2; std::find(names.begin(), names.end(), name) != names.end(); ++number)
      name = own + "_" + std::to_string(number);
    names.push_back(std::move(name));
  }
  return names;
}

std::vector<Measurement> with_record_names(std::vector<Measurement> records) {
  if (records.size() < 2) return records;
  const std::vector<std::string> names = record_names(records);
  for (std::size_t k = 0; k < records.size(); ++k)
    for (compensation::MeasuredChannel& channel : records[k].channels) channel.id = names[k] + "/" + channel.id;
  return records;
}

double common_interval_s(Records records, double interval_s) {
  for (const Measurement& record : records) {
    if (record.data.rows() > 1)
      interval_s = std::max(
          interval_s, (record.time()[record.data.rows() - 1] - record.time()[0]) / ObserveOptions().most_intervals);
  }
  return interval_s;
}

namespace {

/// A channel on the axis that all records share.
ObservedChannel moved(ObservedChannel channel, const Observations& record, int number) {
  channel.record = number;
  channel.record_name = record.name;
  channel.time.array() += record.offset.time;
  for (Index& interval : channel.interval) interval += record.offset.interval;
  for (ObservedChannel::Weight& weight : channel.weights) weight.point += record.offset.step;
  return channel;
}

void append(const Observations& record, int number, Observations& all) {
  for (const ObservedChannel& channel : record.channels) all.channels.push_back(moved(channel, record, number));
  const Index steps = all.rows.rows();
  all.rows.conservativeResize(steps + record.rows.rows(), record.rows.cols());
  all.rows.bottomRows(record.rows.rows()) = record.rows;
  all.points.conservativeResize(all.rows.rows() + 1);
  all.points.tail(record.points.size()) = record.points.array() + record.offset.time;
  for (const auto& [step, parts] : record.mixed) all.mixed[step + steps] = parts;
  for (Observations::MayHold may : record.may_hold) {
    for (double* time : {&may.from, &may.to, &may.shown}) *time += record.offset.time;
    all.may_hold.push_back(std::move(may));
  }
  for (const Observations::OpenChange& change : record.open_changes)
    all.open_changes.push_back({change.from + record.offset.time, change.shown + record.offset.time});
  for (const Observations::OpenChange& pause : record.pauses)
    all.pauses.push_back({pause.from + record.offset.time, pause.shown + record.offset.time});
  all.left_out.insert(all.left_out.end(), record.left_out.begin(), record.left_out.end());
  all.intervals += record.intervals;
  all.end = record.end + record.offset.time;
}

}  // namespace

Observations joined(std::vector<Observations> each, const std::vector<std::string>& names) {
  Observations all;
  all.interval = each.front().interval;
  all.start = all.end = each.front().start;
  all.split = each.front().split;
  all.start_C = each.front().start_C;
  for (int k = 0; k < std::ssize(each); ++k) {
    Observations& record = each[k];
    record.name = names[k];
    record.offset = {all.end - record.start, all.intervals, all.rows.rows()};
    for (ObservedChannel& channel : record.channels) channel.record_name = names[k];
    append(record, k, all);
    all.start_spread_K = std::max(all.start_spread_K, record.start_spread_K);
    all.told_row_s = std::max(all.told_row_s, record.told_row_s);
  }
  all.records = std::move(each);
  return all;
}

}  // namespace thermotwin::diagnosis
