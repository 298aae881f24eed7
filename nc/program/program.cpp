// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/program/program.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/units.h"
#include "nc/dialect/tcp_marker.h"

namespace thermotwin::nc {

using core::InputError;
using rs274::Kind;
using rs274::OffsetKind;
using rs274::Setting;
namespace units = core::units;

namespace {

void turn(Nine& p, double angle) {
  const double c = std::cos(angle), s = std::sin(angle), x = p[0];
  p[0] = c * x - s * p[1];
  p[1] = s * x + c * p[1];
}

double unit_of(double length, int letter) { return is_angle(letter) ? units::deg : length; }

}  // namespace

bool has_only_angles(const Nine& change) { return change.head<3>().isZero(0.0) && change.tail<3>().isZero(0.0); }

bool Move::has_only_angles() const { return kind != MoveKind::arc && nc::has_only_angles(to - from); }

double straight_length(const Nine& change) {
  if (!change.head<3>().isZero(0)) return change.head<3>().norm();
  if (!change.tail<3>().isZero(0)) return change.tail<3>().norm();
  return change.segment<3>(3).norm();
}

Nine Frame::to_axes(const Nine& programmed) const {
  Nine p = programmed;
  for (int i = 0; i < 9; ++i) p[i] = p[i] * unit_of(unit, i) + g92[i];
  if (rotation != 0.0) turn(p, rotation);
  return p + work + tool;
}

Nine Frame::to_program(const Nine& axes) const {
  Nine p = axes - work - tool;
  if (rotation != 0.0) turn(p, -rotation);
  for (int i = 0; i < 9; ++i) p[i] = (p[i] - g92[i]) / unit_of(unit, i);
  return p;
}

double Frame::feed_length(const Nine& change) const {
  const Eigen::Vector3d angles = change.segment<3>(3);
  const double straight = straight_length(change);
  return degrees_count && !has_only_angles(change) ? std::hypot(straight, angles.norm() / units::deg * unit) : straight;
}

namespace {

class Reader {
public:
  Reader(const InterpreterOptions& options, const ControlProfile& control, const ProgramSink& sink)
      : options_(options),
        control_(control),
        sink_(sink),
        position_(options.start) {
    summary_.files.push_back(options.program.string());
    frame_.degrees_count = control.dialect == Dialect::fanuc;
  }

  void take(const Record& record) {
    switch (record.kind) {
      case Kind::file:
        if (record.index == 0) name_file(std::string(record.text));
        break;
      case Kind::block:
        state_.line = record.line;
        state_.depth = static_cast<std::uint16_t>(record.index);
        ++summary_.blocks;
        if (sink_.block) sink_.block({state_, summary_.files[state_.file]}, frame_);
        break;
      case Kind::traverse: straight(MoveKind::traverse, record); break;
      case Kind::feed: straight(MoveKind::feed, record); break;
      case Kind::probe:
        if (summary_.probes++ == 0) summary_.first_probe = place();
        straight(MoveKind::probe, record);
        break;
      case Kind::tap: tap(record); break;
      case Kind::arc: arc(record); break;
      case Kind::offset: offset(record); break;
      case Kind::setting: setting(static_cast<Setting>(record.index), record.values[0], record.values[1]); break;
      case Kind::marker:
        if (record.text == tcp_on_marker || record.text == tcp_off_marker) state_.tcp = record.text == tcp_on_marker;
        break;
      default: break;
    }
  }

  ProgramSummary summary(long deletable) {
    summary_.deletable = deletable;
    summary_.end = state_;
    summary_.frame = frame_;
    return std::move(summary_);
  }

private:
  std::string place() const { return fmt::format("{}:{}", summary_.files[state_.file], state_.line); }

  void name_file(const std::string& path) {
    auto found = std::find(summary_.files.begin(), summary_.files.end(), path);
    if (found == summary_.files.end()) found = summary_.files.insert(found, path);
    state_.file = static_cast<std::uint16_t>(found - summary_.files.begin());
  }

  Move begin(MoveKind kind) {
    Move move;
    move.kind = kind;
    move.from = move.to = position_;
    move.tool_offset = frame_.tool.head<3>();
    move.path_mode = path_mode_;
    move.tolerance = tolerance_;
    move.state = state_;
    return move;
  }

  /// Speed along the path, m/s or rad/s.
  double path_speed(const Move& move, bool only_angles) const {
    if (move.kind == MoveKind::traverse) return 0.0;
    double rate = only_angles ? frame_.angular_feed : frame_.feed;
    const double turns = std::abs(state_.spindle_rpm);
    const double unit = only_angles ? units::deg : frame_.unit;
    if (synchronous_ > 0.0)
      rate = synchronous_ * turns;
    else if (frame_.feed_per_turn)
      rate *= turns;
    if (!(rate > 0.0))
      throw InputError(place(),
                       frame_.feed_per_turn || synchronous_ > 0.0 ? "a feed per revolution while the spindle stands"
                                                                  : fmt::format("a feed rate of {}", rate),
                       "a feed rate above 0");
    return rate * unit / units::minute;
  }

  /// An axis that the rounding of a change of unit moves stands still, or its length would count for the feed.
  static void stay_where_nothing_moves(Move& move) {
    constexpr double least = 1e-10;  // m, rad
    for (int i = 0; i < 9; ++i)
      if (std::abs(move.to[i] - move.from[i]) < least) move.to[i] = move.from[i];
  }

  void emit(Move& move) {
    require_finite(move.to);
    if (move.kind != MoveKind::arc) stay_where_nothing_moves(move);
    const Nine change = move.to - move.from;
    if (move.kind != MoveKind::arc) move.length = frame_.feed_length(change);
    position_ = move.to;
    if (!(move.length > 0.0)) return;
    move.speed = path_speed(move, move.has_only_angles());
    if (move.speed > 0.0) require_time(move.length / move.speed, "a move");
    ++summary_.moves;
    ++(move.kind == MoveKind::traverse ? summary_.traverses
       : move.kind == MoveKind::arc    ? summary_.arcs
                                       : summary_.feeds);
    sink_.move(move, frame_);
  }

  void require_time(double seconds, const char* what) const {
    constexpr double longest = 24.0 * units::hour;
    if (seconds <= longest) return;
    throw InputError(place(), fmt::format("{} of {:.3g} h", what, seconds / units::hour),
                     fmt::format("at most {:g} h", longest / units::hour));
  }

  void require_finite(const Nine& position) const {
    constexpr double farthest = 1e6;  // m, rad
    for (int i = 0; i < 9; ++i)
      if (!(std::abs(position[i]) < farthest))
        throw InputError(place(), fmt::format("{} at {}", letters[i], position[i]), "a position on the machine");
  }

  static Nine nine(const Record& record) {
    Nine values;
    for (int i = 0; i < 9; ++i) values[i] = record.values[i];
    return values;
  }

  void straight(MoveKind kind, const Record& record) {
    state_.line = record.line > 0 ? record.line : state_.line;
    Move move = begin(kind);
    move.to = frame_.to_axes(nine(record));
    emit(move);
  }

  /// Down in step with the spindle, and back.
  void tap(const Record& record) {
    Nine to = frame_.to_program(position_);
    for (int i = 0; i < 3; ++i) to[i] = record.values[i];
    const Nine start = position_;
    Move down = begin(MoveKind::tap);
    down.path_mode = 1;
    down.to = frame_.to_axes(to);
    emit(down);
    Move up = begin(MoveKind::tap);
    up.path_mode = 1;
    up.to = start;
    emit(up);
  }

  void arc(const Record& record) {
    using namespace rs274;
    static constexpr std::array<std::array<int, 3>, 3> axes{{{0, 1, 2}, {1, 2, 0}, {2, 0, 1}}};
    if (plane_ < 1 || plane_ > 3)
      throw InputError(place(), "an arc in a plane of U, V, W", "arcs in the planes G17, G18, G19");
    const auto& v = record.values;
    const auto [i, j, k] = axes[plane_ == 3 ? 2 : plane_ - 1];
    state_.line = record.line > 0 ? record.line : state_.line;
    Move move = begin(MoveKind::arc);
    Nine to = frame_.to_program(position_), centre = to;
    const Nine from = to;
    to[i] = v[first_end];
    to[j] = v[second_end];
    to[k] = v[axis_end];
    for (int l = 3; l < 9; ++l) to[l] = v[arc_a + l - 3];
    centre[i] = v[first_centre];
    centre[j] = v[second_centre];
    centre[k] = from[k];
    move.to = frame_.to_axes(to);
    const double x0 = from[i] - centre[i], y0 = from[j] - centre[j], x1 = to[i] - centre[i], y1 = to[j] - centre[j];
    const double r0 = std::hypot(x0, y0) * frame_.unit, r1 = std::hypot(x1, y1) * frame_.unit;
    if (std::abs(r0 - r1) > control_.arc_radius_tolerance)
      throw InputError(place(),
                       fmt::format("an arc whose radii differ: {:.4f} mm at its start, {:.4f} mm at its end",
                                   r0 / units::mm, r1 / units::mm),
                       fmt::format("a difference of at most {:.4g} mm (arc_radius_tolerance_mm)",
                                   control_.arc_radius_tolerance / units::mm));
    if (!(r0 > 0.0)) throw InputError(place(), "an arc of radius 0", "a radius above 0");
    const double turns = v[rs274::turns], sense = turns > 0 ? 1.0 : -1.0;
    double angle = sense * (std::atan2(y1, x1) - std::atan2(y0, x0));
    // Equal ends are a whole turn.
    while (angle <= 1e-12) angle += 2.0 * std::numbers::pi;
    while (angle > 2.0 * std::numbers::pi + 1e-12) angle -= 2.0 * std::numbers::pi;
    angle += 2.0 * std::numbers::pi * std::max(0.0, std::abs(turns) - 1.0);
    // Directions in the axes' frame: what a small step of the program is there.
    Nine along = from, across = from;
    along[i] += x0, along[j] += y0;
    across[i] -= sense * y0, across[j] += sense * x0;
    const Nine here = frame_.to_axes(from);
    move.arc.first = (frame_.to_axes(along) - here).head<3>() / r0;
    move.arc.second = (frame_.to_axes(across) - here).head<3>() / r0;
    move.arc.centre = frame_.to_axes(centre).head<3>();
    move.arc.start_radius = r0;
    move.arc.end_radius = r1;
    move.arc.angle = angle;
    const double height = (to[k] - from[k]) * frame_.unit;
    move.length = std::hypot(angle * 0.5 * (r0 + r1), height);
    emit(move);
  }

  void offset(const Record& record) {
    Nine given = nine(record);
    for (int i = 0; i < 9; ++i) given[i] *= unit_of(frame_.unit, i);
    switch (static_cast<OffsetKind>(record.index)) {
      case OffsetKind::work: frame_.work = given; break;
      case OffsetKind::g92: frame_.g92 = given; break;
      default: frame_.tool = given; break;
    }
  }

  void pause(Pause::Kind kind, double seconds) {
    require_time(seconds, "a pause");
    if (seconds > 0.0) sink_.pause({kind, seconds, state_});
  }

  void set_spindle(double rpm) {
    if (rpm == state_.spindle_rpm) return;
    state_.spindle_rpm = rpm;
    if (rpm != 0.0) pause(Pause::Kind::spindle, control_.spindle_start);
  }

  void setting(Setting what, double value, double second) {
    switch (what) {
      case Setting::length_unit:
        frame_.feed *= frame_.unit / (value * units::mm);  // the speed along lengths stays
        frame_.unit = value * units::mm;
        break;
      case Setting::plane: plane_ = static_cast<int>(value); break;
      case Setting::feed_rate: frame_.feed = frame_.angular_feed = value; break;
      case Setting::feed_mode: frame_.feed_per_turn = value != 0.0; break;
      case Setting::rotation: frame_.rotation = value * units::deg; break;
      case Setting::work_offset_set: frame_.work_number = static_cast<int>(value); break;
      case Setting::path_mode:
        path_mode_ = static_cast<int>(value);
        tolerance_ = second * frame_.unit;
        break;
      case Setting::spindle_speed:
        speed_rpm_ = value;
        set_spindle(direction_ * speed_rpm_);
        break;
      case Setting::spindle_turns:
        direction_ = value;
        set_spindle(direction_ * speed_rpm_);
        break;
      case Setting::surface_speed:
        if (value != 0.0) throw InputError(place(), "constant surface speed (G96)", "a spindle speed in rpm (G97)");
        break;
      case Setting::flood: state_.flood = value != 0.0; break;
      case Setting::mist: state_.mist = value != 0.0; break;
      case Setting::dwell:
        state_.dwelt += value;
        pause(Pause::Kind::dwell, value);
        break;
      case Setting::tool_change:
        state_.tool = static_cast<int>(value);
        ++state_.operation;
        ++summary_.tool_changes;
        pause(Pause::Kind::tool_change, control_.tool_change);
        break;
      case Setting::stop:
        ++state_.operation;
        ++summary_.stops;
        pause(Pause::Kind::stop, control_.program_stop);
        break;
      case Setting::synchronous: synchronous_ = value; break;
      case Setting::open_end: summary_.open_end = true; break;
      case Setting::skipped:
        if (sink_.skipped) sink_.skipped();
        break;
      default: break;
    }
  }

  const InterpreterOptions& options_;
  const ControlProfile& control_;
  const ProgramSink& sink_;
  ProgramSummary summary_;
  Nine position_;
  Frame frame_;
  MoveState state_;
  int plane_ = 1, path_mode_ = 3;
  double tolerance_ = 0, speed_rpm_ = 0, direction_ = 0, synchronous_ = 0;
};

}  // namespace

ProgramSummary read_program(const InterpreterOptions& options, const ControlProfile& control, const ProgramSink& sink) {
  Reader reader(options, control, sink);
  const long deletable = interpret(options, control, [&](const Record& record) { reader.take(record); });
  return reader.summary(deletable);
}

}  // namespace thermotwin::nc
