// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/report/location_errors.h"

#include <fmt/format.h>

#include <iterator>

#include "core/html_page.h"
#include "core/plot.h"
#include "mesh/machine/kinematics.h"
#include "nc/report/time_text.h"

namespace thermotwin::nc {

namespace {

constexpr std::size_t most_times = 1600;

bool is_rotation(const std::string& name) { return name[0] == 'A' || name[0] == 'B' || name[0] == 'C'; }

/// A picture of those location errors of a group that are shifts, or of those that are rotations.
void draw(core::Plot& plot, const core::Frame& frame, const LocationErrors& errors, const LocationErrors::Group& group,
          bool rotations) {
  const TimeUnit unit = unit_for(errors.times().back());
  const auto count = std::ssize(errors.times());
  Eigen::VectorXd time(count), values(count);
  for (Eigen::Index i = 0; i < count; ++i) time[i] = errors.times()[i] / unit.seconds;
  core::Axis across{fmt::format("time in {}", unit.name)}, up{rotations ? "\u00b5m/m" : "\u00b5m"};
  across.include(0.0);
  across.include(time);
  across.close();
  std::vector<Eigen::VectorXd> curves;
  double at = frame.left;
  for (std::size_t k = 0; k < group.names.size(); ++k) {
    if (is_rotation(group.names[k]) != rotations) continue;
    const Eigen::Index column = group.first + k;
    for (Eigen::Index i = 0; i < count; ++i) values[i] = errors.values()[i][column];
    up.include(values);
    at = plot.key(at, frame.top - 12, group.names[k], core::series_ink(curves.size())) + 14;
    curves.push_back(values);
  }
  up.include(0.0);
  up.close(0.06);
  core::Panel panel(plot, frame, across, up);
  panel.y_axis();
  panel.x_axis();
  for (std::size_t k = 0; k < curves.size(); ++k) panel.line(time, curves[k], core::series_ink(k));
}

}  // namespace

LocationErrors::LocationErrors(const mesh::Machine& machine) {
  std::vector<std::string> ids;
  for (const mesh::Axis& axis : machine.axes)
    if (axis.kind == mesh::AxisKind::rotary) ids.push_back(axis.id);
  // Growth shows along an axis across that of the table; of two linear axes one is.
  const bool grows = machine.tcp.table_radius > 0.0 && std::ssize(machine.axes) >= std::ssize(ids) + 2;
  ids.emplace_back("T");
  for (const std::string& id : ids) {
    Group group{id, {}, std::ssize(quantities_)};
    for (const char letter : std::string(grows && id == "T" ? "XYZRABC" : "XYZABC")) {
      compensation::MeasuredChannel channel;
      channel.id = channel.quantity = std::string(1, letter) + "0" + id;
      group.names.push_back(channel.quantity);
      quantities_.emplace_back(machine, channel, mesh::home_pose(machine));
    }
    groups_.push_back(group);
  }
}

std::string LocationErrors::header() const {
  std::string text = "time_s";
  for (const Group& group : groups_)
    for (const std::string& name : group.names)
      text += fmt::format(",{}_{}", name, is_rotation(name) ? "um_per_m" : "um");
  return text + "\n";
}

std::string LocationErrors::add(const ErrorField& field, double time) {
  Eigen::VectorXd values(std::ssize(quantities_));
  std::string text = fmt::format("{}", time);
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    std::vector<solver::TcpError> at;
    for (const mesh::Pose& pose : quantities_[i].poses()) at.push_back(field.error(pose, time));
    values[i] = quantities_[i](at);
    text += fmt::format(",{:.4f}", values[i]);
  }
  if (rows_++ % stride_ == 0) {
    times_.push_back(time);
    values_.push_back(std::move(values));
  }
  if (times_.size() > most_times) {
    stride_ *= 2;
    for (std::size_t i = 0; 2 * i < times_.size(); ++i) {
      times_[i] = times_[2 * i];
      values_[i] = std::move(values_[2 * i]);
    }
    times_.resize((times_.size() + 1) / 2);
    values_.resize(times_.size());
  }
  return text + "\n";
}

std::string location_section(const LocationErrors& errors) {
  if (errors.times().empty()) return "";
  constexpr double height = 130.0, apart = 200.0;
  core::Plot plot(1080, apart * std::ssize(errors.groups()) + 8, "Location errors of the axes over time");
  double top = 30.0;
  for (const LocationErrors::Group& group : errors.groups()) {
    draw(plot, {64, top, 430, height}, errors, group, false);
    draw(plot, {610, top, 430, height}, errors, group, true);
    top += apart;
  }
  return core::html_section("Location errors",
                            "of the rotary axes and the table (T), all axes at home; names of ISO 230-1", plot.inset());
}

}  // namespace thermotwin::nc
