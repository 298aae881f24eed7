// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/rewrite/read_back.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <tuple>
#include <type_traits>

#include "core/error.h"
#include "core/units.h"
#include "nc/motion/axis_motion.h"

namespace thermotwin::nc {

namespace units = core::units;

static_assert(std::is_trivially_copyable_v<ExpectedMove>);

namespace {

using MoveWords = std::array<std::uint64_t, sizeof(ExpectedMove) / sizeof(std::uint64_t)>;
static_assert(sizeof(MoveWords) == sizeof(ExpectedMove) && std::tuple_size_v<MoveWords> <= 64);

constexpr double shortest_arc = 2e-5;  // m; the turn of a shorter one depends on the last digit

/// Three halves of a coordinate's last digit: both coordinates of a plane are rounded.
double rounding(double unit) { return (unit > 0.01 ? 1.5e-5 : 1.5e-4) * unit; }
constexpr double angle_rounding = 1.5e-4 * units::deg;

const char* name_of(MoveKind kind) {
  switch (kind) {
    case MoveKind::traverse: return "a rapid move";
    case MoveKind::arc: return "an arc";
    case MoveKind::probe: return "a probing move";
    case MoveKind::tap: return "a tapping move";
    default: return "a line";
  }
}

std::string sentence(const std::string& what, const std::string& found, const std::string& wanted) {
  return fmt::format("{} {} instead of {}", what, found, wanted);
}

std::string difference(const char* what, double found, double wanted, double within = 0.0) {
  if (std::abs(found - wanted) <= within) return "";
  return sentence(what, fmt::format("{:g}", found), fmt::format("{:g}", wanted));
}

std::string switch_difference(const char* what, bool found, bool wanted) {
  return found == wanted ? "" : sentence(what, found ? "on" : "off", wanted ? "on" : "off");
}

/// Nothing differs, not even by rounding.
bool is_same_state(const ExpectedMove& found, const ExpectedMove& wanted) {
  const auto state = [](const ExpectedMove& of) {
    return std::tie(of.tool, of.operation, of.tool_offset, of.spindle_rpm, of.flood, of.mist, of.tcp, of.dwelt, of.unit,
                    of.path_mode, of.path_tolerance, of.zero);
  };
  return state(found) == state(wanted);
}

/// What differs in the states that hold at a move; empty: nothing.
/// @param slack  m by which the zero of the program may differ
std::string state_difference(const ExpectedMove& found, const ExpectedMove& wanted, double slack) {
  if (is_same_state(found, wanted)) return "";
  const double length = std::max(1e-9, rounding(wanted.unit) * 1e-3);
  for (const std::string& text :
       {difference("tool", found.tool, wanted.tool),
        difference("tool change or stop", found.operation, wanted.operation),
        difference("tool length offset in mm", found.tool_offset[2] / units::mm, wanted.tool_offset[2] / units::mm,
                   length / units::mm),
        difference("tool offset in X, mm", found.tool_offset[0] / units::mm, wanted.tool_offset[0] / units::mm,
                   length / units::mm),
        difference("tool offset in Y, mm", found.tool_offset[1] / units::mm, wanted.tool_offset[1] / units::mm,
                   length / units::mm),
        difference("spindle speed in rpm", found.spindle_rpm, wanted.spindle_rpm, 1e-6),
        switch_difference("flood", found.flood, wanted.flood), switch_difference("mist", found.mist, wanted.mist),
        switch_difference("tool centre point control", found.tcp, wanted.tcp),
        difference("dwell in s", found.dwelt, wanted.dwelt, 1e-3 + 1e-9 * wanted.dwelt),
        difference("unit in mm", found.unit / units::mm, wanted.unit / units::mm, 1e-9),
        difference("path mode", wanted.path_mode > 0 ? found.path_mode : 0, wanted.path_mode),
        difference("path tolerance in mm", wanted.path_mode > 0 ? found.path_tolerance / units::mm : 0.0,
                   wanted.path_mode > 0 ? wanted.path_tolerance / units::mm : 0.0, 1e-6)})
    if (!text.empty()) return text;
  for (int i = 0; i < 9; ++i) {
    const double unit = is_angle(i) ? units::deg : units::mm, within = is_angle(i) ? 1e-9 : length + slack;
    const std::string text =
        difference("the zero of the program in", found.zero[i] / unit, wanted.zero[i] / unit, within / unit);
    if (!text.empty()) return fmt::format("{}: {}", letters[i], text);
  }
  return "";
}

}  // namespace

ExpectedMove ExpectedMove::of(const Move& move, const Frame& frame, const Nine& to) {
  ExpectedMove expected;
  std::copy(to.begin(), to.end(), expected.to.begin());
  expected.kind = move.kind;
  expected.unit = frame.unit;
  std::copy(move.tool_offset.begin(), move.tool_offset.end(), expected.tool_offset.begin());
  expected.spindle_rpm = move.state.spindle_rpm;
  expected.dwelt = move.state.dwelt;
  expected.path_mode = move.path_mode;
  expected.path_tolerance = move.tolerance;
  expected.line = move.state.line;
  expected.file = move.state.file;
  expected.tool = move.state.tool;
  expected.operation = move.state.operation;
  expected.flood = move.state.flood;
  expected.mist = move.state.mist;
  expected.tcp = move.state.tcp;
  const Nine zero = frame.work + frame.g92;
  std::copy(zero.begin(), zero.end(), expected.zero.begin());
  return expected;
}

/// Moves as they are read against those that wait.
class ReadBack::Comparison {
public:
  Comparison(std::fstream& moves, const std::vector<Inside>& inside, const ProgramSummary& program, double slack)
      : moves_(moves),
        inside_(inside),
        program_(program),
        slack_(slack) {
    next();
  }

  /// "file:line" of the program that the comparison has come to.
  std::string place() const {
    return fmt::format("{}:{}", program_.files[std::min<std::size_t>(at_.file, program_.files.size() - 1)], at_.line);
  }

  void take(const Move& move, const Frame& frame) {
    const bool toggled = move.state.tcp != tcp_;
    tcp_ = move.state.tcp;
    std::string why;
    for (; wanted_; next()) {
      const std::string one = compare(move, frame, *wanted_);
      if (one.empty()) {
        last_ = wanted_->to;
        next();
        return;
      }
      if (why.empty()) why = one;
      if (!is_short(*wanted_)) break;
    }
    // A move within rounding, and the change of coordinates when tool centre point control is switched, move no axis.
    if (toggled || (move.to - move.from).head<3>().norm() <= 4.0 * (rounding(frame.unit) + slack_)) return;
    fail(why.empty() ? fmt::format("{} more", name_of(move.kind)) : why);
  }

  void finish(const ProgramSummary& again) {
    for (; wanted_; next())
      if (!is_short(*wanted_)) fail(fmt::format("{} is missing", name_of(wanted_->kind)));
    at_.line = program_.end.line;
    at_.file = program_.end.file;
    const std::string why = state_difference(end_of(again), end_of(program_), slack_);
    if (!why.empty()) fail("at its end " + why);
  }

private:
  static ExpectedMove end_of(const ProgramSummary& program) {
    Move standing;
    standing.state = program.end;
    standing.tool_offset = program.frame.tool.head<3>();
    return ExpectedMove::of(standing, program.frame, Nine::Zero());
  }

  /// Words that are those of the move before are not in the file.
  bool read(ExpectedMove& move) {
    std::uint64_t changed = 0;
    if (!moves_.read(reinterpret_cast<char*>(&changed), sizeof changed)) return false;
    MoveWords words;
    const std::streamsize bytes = std::popcount(changed) * sizeof(std::uint64_t);
    if (!moves_.read(reinterpret_cast<char*>(words.data()), bytes)) return false;
    for (std::size_t k = 0, next = 0; k < words.size(); ++k)
      if ((changed >> k & 1U) != 0) words_[k] = words[next++];
    move = std::bit_cast<ExpectedMove>(words_);
    return true;
  }

  void next() {
    ExpectedMove move;
    wanted_.reset();
    if (read(move)) {
      wanted_ = move;
      at_ = move;
      ++number_;
    }
    while (point_ < inside_.size() && inside_[point_].move < number_) ++point_;
  }

  /// Within rounding of the last one: the corrected program may leave it out.
  bool is_short(const ExpectedMove& move) const {
    if (!last_) return false;
    const double within = 4.0 * (rounding(move.unit) + slack_ + move.slack);
    for (std::size_t i = 0; i < 9; ++i)
      if (std::abs(move.to[i] - (*last_)[i]) > (i >= 3 && i < 6 ? 4.0 * angle_rounding : within)) return false;
    return true;
  }

  /// What differs; empty: nothing.
  std::string compare(const Move& move, const Frame& frame, const ExpectedMove& wanted) const {
    if (move.kind != wanted.kind) return sentence("it has", name_of(move.kind), name_of(wanted.kind));
    // An axis that was not named since an update of the zero stands where it was: only rapid moves may end so.
    const bool is_rapid = wanted.kind == MoveKind::traverse;
    const double within = rounding(wanted.unit) + 1e-9 + (is_rapid ? slack_ : 0.0) + wanted.slack;
    const Nine zero = frame.work + frame.g92;
    for (Eigen::Index i = 0; i < 9; ++i) {
      const bool angle = i >= 3 && i < 6;
      const double to = wanted.to[i] + (is_rapid || angle ? 0.0 : zero[i] - wanted.zero[i]);
      if (std::abs(move.to[i] - to) <= (angle ? angle_rounding : within)) continue;
      const double unit = angle ? units::deg : units::mm;
      return sentence(fmt::format("{} ends at", letters[i]), fmt::format("{:.4f}", move.to[i] / unit),
                      fmt::format("{:.4f}", to / unit));
    }
    if (const std::string why = state_difference(ExpectedMove::of(move, frame, move.to), wanted, slack_); !why.empty())
      return why;
    if (const double seconds = move.speed > 0.0 ? move.length / move.speed : 0.0;
        wanted.seconds > 0.0 && std::abs(seconds - wanted.seconds) > 0.02 * wanted.seconds + 1e-4)
      return sentence("seconds of a feed move", fmt::format("{:.4g}", seconds), fmt::format("{:.4g}", wanted.seconds));
    if (wanted.speed > 0.0 && std::abs(move.speed - wanted.speed) > 0.01 * wanted.speed + 2e-4 * frame.unit / 60.0)
      return sentence("feed in mm/min", fmt::format("{:g}", move.speed / units::mm * units::minute),
                      fmt::format("{:g}", wanted.speed / units::mm * units::minute));
    if (wanted.angle > 0.0 && move.length > shortest_arc && std::abs(move.arc.angle - wanted.angle) > 0.5)
      return sentence("an arc of", fmt::format("{:.1f} deg", move.arc.angle / units::deg),
                      fmt::format("{:.1f} deg", wanted.angle / units::deg));
    if (wanted.middle_within > 0.0) {
      const Eigen::Vector3d middle = AxisMotion::values_at(move, 0.5).head<3>();
      const double off = (middle - Eigen::Vector3d(wanted.middle.data())).norm();
      if (off > wanted.middle_within + slack_)
        return fmt::format("the middle of an arc is {:.2f} um off", off / units::um);
    }
    return inside_difference(move);
  }

  std::string inside_difference(const Move& move) const {
    for (std::size_t i = point_; i < inside_.size() && inside_[i].move == number_; ++i) {
      const ExpectedPoint& point = inside_[i].point;
      const Eigen::Vector3d found = AxisMotion::values_at(move, point.share).head<3>();
      const double off = (found - Eigen::Vector3d(point.at.data())).norm();
      if (off > point.within + slack_)
        return fmt::format("{} is {:.2f} um off at {:.0f} % of it", name_of(move.kind), off / units::um,
                           100.0 * point.share);
    }
    return "";
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw core::InputError(place(), "the corrected program does not do the same here: " + what,
                           slack_ > 0.0 ? "X, Y and Z in G90 between an update of the zero and the next feed move; no "
                                          "program was written"
                                        : "programs whose corrected text the interpreter reads as meant; no program "
                                          "was written");
  }

  std::fstream& moves_;
  const std::vector<Inside>& inside_;
  std::size_t point_ = 0;  ///< first one of the move that is wanted, or of a later one
  long number_ = -1;       ///< of the move that is wanted
  const ProgramSummary& program_;
  double slack_;
  std::optional<ExpectedMove> wanted_;
  std::optional<std::array<double, 9>> last_;
  ExpectedMove at_;
  MoveWords words_{};
  bool tcp_ = false;
};

ReadBack::ReadBack(std::filesystem::path file) : file_(std::move(file)) {
  moves_.open(file_, std::ios::in | std::ios::out | std::ios::binary | std::ios::trunc);
}

ReadBack::~ReadBack() {
  moves_.close();
  std::error_code ignored;
  std::filesystem::remove(file_, ignored);
}

void ReadBack::expect(const ExpectedMove& move, const std::vector<ExpectedPoint>& inside) {
  const auto words = std::bit_cast<MoveWords>(move);
  // A mask of the words that differ from those of the move before, and these.
  std::array<std::uint64_t, std::tuple_size_v<MoveWords> + 1> out;
  std::size_t count = 1;
  std::uint64_t changed = 0;
  for (std::size_t k = 0; k < words.size(); ++k) {
    if (words[k] == last_words_[k]) continue;
    changed |= std::uint64_t{1} << k;
    last_words_[k] = words[k];
    out[count++] = words[k];
  }
  out[0] = changed;
  moves_.write(reinterpret_cast<const char*>(out.data()), count * sizeof(std::uint64_t));
  for (const ExpectedPoint& point : inside) inside_.push_back({expected_, point});
  ++expected_;
}

void ReadBack::check(const InterpreterOptions& options, const ControlProfile& control, const ProgramSummary& program,
                     double slack) {
  moves_.flush();
  if (!moves_) throw core::InputError(file_.string(), "cannot be written", "a place with room and permission");
  moves_.seekg(0);
  Comparison comparison(moves_, inside_, program, slack);
  ProgramSink sink;
  sink.move = [&](const Move& move, const Frame& frame) { comparison.take(move, frame); };
  sink.pause = [](const Pause&) {};
  ProgramSummary again;
  InterpreterOptions reading = options;
  reading.open_end = program.open_end;
  try {
    again = read_program(reading, control, sink);
  } catch (const core::InputError& error) {
    // Differences name the program's own line.
    const std::string what = error.what();
    if (what.find(options.program.filename().string()) == std::string::npos) throw;
    throw core::InputError(comparison.place(), "the interpreter refuses the corrected program (" + what + ")",
                           "programs whose corrected text the interpreter reads as meant; no program was written");
  }
  comparison.finish(again);
}

}  // namespace thermotwin::nc
