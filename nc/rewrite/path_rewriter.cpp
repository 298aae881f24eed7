// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/rewrite/path_rewriter.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/text.h"
#include "core/units.h"

namespace thermotwin::nc {

namespace units = core::units;

namespace {

int decimals_of(const Frame& frame) { return frame.unit > 0.01 ? 5 : 4; }
double half_step(const Frame& frame) { return 0.5 * std::pow(10.0, -decimals_of(frame)); }

/// Letters of the plane of an arc, and those of its centre.
struct Plane {
  std::array<int, 2> axes;
  std::array<char, 2> centre;
};
Plane plane_of(const Arc& arc, const Frame& frame) {
  // The normal is an axis of the program; a rotation turns X and Y only.
  const Eigen::Vector3d normal = arc.first.cross(arc.second).cwiseAbs();
  if (normal.z() > 0.5) return {{0, 1}, {'I', 'J'}};
  const double turned = std::abs(std::cos(frame.rotation));
  const bool across_y = (normal.y() > normal.x()) == (turned > std::numbers::sqrt2 / 2.0);
  if (across_y) return {{0, 2}, {'I', 'K'}};
  return {{1, 2}, {'J', 'K'}};
}

bool whole_turns(const Arc& arc) {
  const double turns = arc.angle / (2.0 * std::numbers::pi);
  return std::abs(turns - std::round(turns)) < 1e-9;
}

bool is_percent(const ProgramText& lines, std::size_t index) {
  const std::string line = lines.raw(index);
  return core::trimmed(line) == "%";
}

/// The last line that is not blank; 0: there is none behind the first.
std::size_t last_line(const ProgramText& lines) {
  std::size_t last = lines.size() - 1;
  for (std::string line; last > 0; --last) {
    line = lines.raw(last);
    if (!core::trimmed(line).empty()) break;
  }
  return last;
}

/// The centre nearest to a wanted one from which both ends are equally far.
Eigen::Vector3d centre_of(const Eigen::Vector3d& start, const Eigen::Vector3d& end, const Eigen::Vector3d& wanted,
                          const Eigen::Vector3d& normal) {
  const auto flat = [&](const Eigen::Vector3d& v) -> Eigen::Vector3d { return v - v.dot(normal) * normal; };
  const Eigen::Vector3d chord = flat(end - start);
  Eigen::Vector3d centre = wanted;
  if (chord.norm() > 1e-9) {
    const Eigen::Vector3d along = chord.normalized(), middle = start + 0.5 * chord;
    centre -= along.dot(wanted - middle) * along;
  }
  return centre;
}

}  // namespace

PathRewriter::PathRewriter(ProgramText lines, std::string name, const AxisMotion& motion, const RewriteOptions& options,
                           std::function<void(const std::string&)> out)
    : lines_(std::move(lines)),
      name_(std::move(name)),
      motion_(motion),
      options_(options),
      out_(std::move(out)) {
  for (std::size_t i = 0; i < lines_.size() && flat_; ++i) {
    const ProgramLine line = lines_.line(i);
    flat_ = !(line.control || line.assigns || line.has('M', 98) || line.has('M', 99));
  }
  summary_.lines_before = lines_.size();
}

void PathRewriter::refuse(const Entry& entry, const std::string& value, const std::string& allowed) const {
  throw core::InputError(entry.place, value + " with --rewrite path", allowed);
}

ProgramLine PathRewriter::line_of(const std::string& file, std::size_t number) const {
  const ProgramText* lines = &lines_;
  if (file != name_) {
    auto found = others_.find(file);
    if (found == others_.end()) found = others_.emplace(file, ProgramText::of_file(file)).first;
    lines = &found->second;
  }
  return number >= 1 && number <= lines->size() ? lines->line(number - 1) : ProgramLine{};
}

void PathRewriter::scan(Entry& entry, const ProgramLine& line) {
  for (const Word& word : line.words) {
    const auto rule = std::find_if(options_.words.begin(), options_.words.end(), [&](const WordRule& one) {
      return one.letter == word.letter && !word.expression && std::abs(one.number - word.value) < 1e-6;
    });
    if (rule != options_.words.end() && &line == &entry.line) {
      scan(entry, ProgramLine::parse(rule->by, ""));
      continue;
    }
    if (word.letter != 'G') continue;
    if (word.expression) refuse(entry, "a G word with an expression", "G and a number");
    const int code = static_cast<int>(std::lround(10.0 * word.value));
    switch (code) {
      case 900: absolute_ = true; break;
      case 910: absolute_ = false; break;
      case 901: arc_absolute_ = true; break;
      case 911: arc_absolute_ = false; break;
      case 930: inverse_time_ = true; break;
      case 940:
      case 950: inverse_time_ = false; break;
      case 0:
      case 10:
      case 20:
      case 30:
      case 800: cycle_ = false; break;
      case 730:
      case 810:
      case 820:
      case 830:
      case 850:
      case 890: cycle_ = true; break;
      case 280:
      case 300:
      case 530: entry.machine = true; break;
      case 410:
      case 411:
      case 420:
      case 421: refuse(entry, "cutter radius compensation", "G40"); break;
      case 920: refuse(entry, "G92", "work offsets G54 to G59.3"); break;
      case 330:
      case 331:
      case 50:
      case 51:
      case 52:
      case 700:
      case 710:
      case 720:
      case 740:
      case 760:
      case 840:
      case 860:
      case 870:
      case 880:
        refuse(entry, fmt::format("G{}", word.value), "lines, arcs and the cycles G73, G81, G82, G83, G85, G89");
        break;
      case 100:
        if (entry.line.has('L', 20) || entry.line.has('L', 10) || entry.line.has('L', 11))
          refuse(entry, "G10 that measures by the present position", "G10 L1 or L2");
        break;
      default: break;
    }
  }
  entry.absolute = absolute_;
  entry.arc_absolute = arc_absolute_;
  entry.inverse_time = inverse_time_;
  entry.cycle = cycle_;
}

/// Modes change by lines that run; whether one ran is known behind it.
void PathRewriter::settle(Entry& entry) {
  if (entry.settled || entry.skipped) return;
  entry.settled = true;
  scan(entry, entry.line);
}

void PathRewriter::block(const MoveState& state, const std::string& file, const Frame& frame) {
  if (!entries_.empty()) {
    settle(entries_.back());
    entries_.back().frame = frame;
  }
  Entry entry;
  entry.place = fmt::format("{}:{}", file, state.line);
  entry.number = state.line;
  entry.line = line_of(file, state.line);
  entry.text = entry.line.text;
  flush();
  entries_.push_back(std::move(entry));
}

void PathRewriter::move() {
  if (entries_.empty()) return;
  Entry& entry = entries_.back();
  settle(entry);
  ++entry.expected;
  if (entry.expected > 1 && !entry.cycle && !entry.machine)
    refuse(entry, "a line of several moves", "one line or arc in a line, and the cycles G73, G81, G82, G83, G85, G89");
}

void PathRewriter::skipped() {
  if (!entries_.empty()) entries_.back().skipped = true;
}

Eigen::Vector3d PathRewriter::displacement(const Move& move, const PredictedMove& predicted, double u) const {
  const Nine nominal = AxisMotion::values_at(move, u);
  Positions positions = motion_.positions(nominal, move);
  const Eigen::VectorXd offsets = predicted.field->offsets(positions, predicted.share);
  const std::vector<std::string>& axes = predicted.field->axes();
  const mesh::Machine& machine = motion_.machine();
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const int axis = machine.axis_index(axes[i]);
    const double offset = offsets[i];
    if (std::abs(offset) > options_.largest_offset)
      throw core::InputError(place_, fmt::format("an offset of {:.1f} um of axis {}", offset / units::um, axes[i]),
                             fmt::format("at most {:.1f} um", options_.largest_offset / units::um));
    positions[axis] += offset;
    const mesh::Axis& limits = machine.axes[axis];
    if (positions[axis] < limits.low - 1e-9 || positions[axis] > limits.high + 1e-9)
      throw core::InputError(
          place_, fmt::format("axis {} at {:.4f} mm with its offset", axes[i], positions[axis] / units::mm),
          fmt::format("its travel, {:.4f} to {:.4f}", limits.low / units::mm, limits.high / units::mm));
  }
  return (motion_.values(positions, move, nominal) - nominal).head<3>();
}

void PathRewriter::find_pieces(const Move& move, const PredictedMove& predicted, double u0, double u1,
                               const Eigen::Vector3d& d0, const Eigen::Vector3d& d1, int depth,
                               std::vector<double>& ends) const {
  const auto point = [&](double u) -> Eigen::Vector3d { return AxisMotion::values_at(move, u).head<3>(); };
  constexpr int deepest = 10;
  bool bends = false;
  const bool arc = move.kind == MoveKind::arc;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ(), centre = Eigen::Vector3d::Zero(), start = centre, end = centre;
  double sweep = 0;
  if (arc) {
    normal = move.arc.first.cross(move.arc.second);
    start = point(u0) + d0;
    end = point(u1) + d1;
    sweep = move.arc.angle * (u1 - u0);
    centre = whole_turns(move.arc) && u1 - u0 == 1.0 ? Eigen::Vector3d(move.arc.centre + d0)
                                                     : centre_of(start, end, move.arc.centre + 0.5 * (d0 + d1), normal);
    const auto flat = [&](const Eigen::Vector3d& v) -> Eigen::Vector3d { return v - v.dot(normal) * normal; };
    // The turn between the displaced ends is near that of the arc itself.
    const Eigen::Vector3d a = flat(start - centre), b = flat(end - centre);
    double turn = std::atan2(normal.dot(a.cross(b)), a.dot(b));
    turn += 2.0 * std::numbers::pi * std::round((sweep - turn) / (2.0 * std::numbers::pi));
    if (!(whole_turns(move.arc) && u1 - u0 == 1.0)) sweep = turn;
  }
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const double share : {0.5, 0.25, 0.75}) {
    const double u = u0 + share * (u1 - u0);
    const Eigen::Vector3d wanted = displacement(move, predicted, u);
    if (share == 0.5) middle = wanted;
    Eigen::Vector3d found = d0 + share * (d1 - d0);
    if (arc) {
      const Eigen::Vector3d radius = (start - centre) - normal.dot(start - centre) * normal;
      const double rise = normal.dot(start - centre) + share * normal.dot(end - start);
      found = centre + Eigen::AngleAxisd(sweep * share, normal) * radius + rise * normal - point(u);
    }
    const double off = (found - wanted).norm();
    bends = bends || off > options_.tolerance;
    // Far within the tolerance in the middle: the quarters are as well.
    if (share == 0.5 && off < options_.tolerance / 8.0) break;
  }
  if (bends && depth < deepest) {
    const double u = 0.5 * (u0 + u1);
    find_pieces(move, predicted, u0, u, d0, middle, depth + 1, ends);
    find_pieces(move, predicted, u, u1, middle, d1, depth + 1, ends);
    return;
  }
  ends.push_back(u1);
}

/// Writes the coordinates that bring the control to the target. @param whole  every coordinate of the target is
/// written that differs from where the control is. @return where the control then is
Nine PathRewriter::set_end(ProgramLine& line, const Entry& entry, const Source& source, Nine target, bool whole) const {
  const Frame& frame = source.frame;
  const double half = half_step(frame);
  const Nine now = frame.to_program(at_), wanted = frame.to_program(target);
  Nine reached = wanted;
  for (int i = 0; i < 9; ++i) {
    const char letter = letters[i];
    const Word* word = line.find(letter);
    const double goal = entry.absolute ? wanted[i] : wanted[i] - now[i], base = entry.absolute ? 0.0 : now[i];
    if (word != nullptr && !word->expression && std::abs(word->value - goal) <= half) {
      reached[i] = base + word->value;
      continue;
    }
    if (word == nullptr && std::abs(wanted[i] - now[i]) <= half) {
      reached[i] = now[i];
      continue;
    }
    if (i >= 3 && word == nullptr && !whole) continue;
    const std::string number = nc_number(goal, decimals_of(frame));
    reached[i] = base + std::stod(number);
    line.set(letter, number, "XYZABCUVWG");
  }
  return frame.to_axes(reached);
}

void PathRewriter::set_centre(ProgramLine& line, const Entry& entry, const Source& source, const Eigen::Vector3d& start,
                              const Eigen::Vector3d& centre) const {
  const Frame& frame = source.frame;
  const Plane plane = plane_of(source.move.arc, frame);
  Nine a = source.move.from, b = source.move.from;
  a.head<3>() = start;
  b.head<3>() = centre;
  const Nine from = frame.to_program(a), to = frame.to_program(b);
  const double half = half_step(frame);
  for (int k = 0; k < 2; ++k) {
    const int axis = plane.axes[k];
    const char letter = plane.centre[k];
    const double value = entry.arc_absolute ? to[axis] : to[axis] - from[axis];
    const Word* word = line.find(letter);
    if (word != nullptr && !word->expression && std::abs(word->value - value) <= half) continue;
    if (word == nullptr && !entry.arc_absolute && std::abs(value) <= half) continue;
    line.set(letter, nc_number(value, decimals_of(frame)), "XYZABCUVWIJK");
  }
}

void PathRewriter::edit(Entry& entry, const PredictedMove& predicted) {
  const Source& source = *predicted.timed->element.source;
  const Move& move = source.move;
  if (!placed_) at_ = move.from;
  placed_ = true;
  place_ = entry.place;
  ++entry.done;
  if (entry.machine) {
    at_ = move.to;
    return;
  }
  if (entry.cycle) {
    cycle_move(entry, predicted);
    return;
  }
  const Eigen::Vector3d d0 = (at_ - move.from).head<3>(), d1 = displacement(move, predicted, 1.0);
  summary_.largest_um = std::max(summary_.largest_um, d1.norm() / units::um);
  std::vector<double> ends;
  if (move.kind == MoveKind::traverse)
    ends.push_back(1.0);
  else
    find_pieces(move, predicted, 0.0, 1.0, d0, d1, 0, ends);

  const std::vector<std::pair<char, double>> at_end = {{'M', 0}, {'M', 1},  {'M', 2}, {'M', 5},
                                                       {'M', 9}, {'M', 30}, {'M', 60}};
  ProgramLine line = entry.line;
  std::string last_words;
  if (ends.size() > 1) {
    for (const auto& [letter, number] : at_end)
      if (line.has(letter, number)) last_words += fmt::format(" {}{}", letter, number);
    if (!last_words.empty()) line.remove(at_end);
  }
  const bool arc = move.kind == MoveKind::arc;
  std::string text;
  double u0 = 0.0;
  for (std::size_t k = 0; k < ends.size(); ++k) {
    const double u1 = ends[k];
    const Eigen::Vector3d start = at_.head<3>();
    Nine target = k + 1 == ends.size() ? move.to : AxisMotion::values_at(move, u1);
    target.head<3>() += k + 1 == ends.size() ? d1 : displacement(move, predicted, u1);
    const bool full = arc && ends.size() == 1 && whole_turns(move.arc);
    if (full) {
      // A circle ends where it began.
      const Plane plane = plane_of(move.arc, source.frame);
      Nine to = source.frame.to_program(target);
      const Nine here = source.frame.to_program(at_);
      for (const int axis : plane.axes) to[axis] = here[axis];
      target = source.frame.to_axes(to);
    }
    const std::string before = line.text;
    const Nine reached = set_end(line, entry, source, target, k > 0);
    if (arc) {
      const Eigen::Vector3d normal = move.arc.first.cross(move.arc.second), end = reached.head<3>();
      const Eigen::Vector3d a = start - AxisMotion::values_at(move, u0).head<3>(),
                            b = end - AxisMotion::values_at(move, u1).head<3>();
      const bool radius = line.find('R') != nullptr;
      const bool moved =
          (start - AxisMotion::values_at(move, u0).head<3>()).norm() > 1e-9 || line.text != before || ends.size() > 1;
      if (radius && moved) line.remove({{'R', line.find('R')->value}});
      const Eigen::Vector3d centre =
          full ? Eigen::Vector3d(move.arc.centre + a) : centre_of(start, end, move.arc.centre + 0.5 * (a + b), normal);
      if (!radius || moved) set_centre(line, entry, source, start, centre);
    }
    if (entry.inverse_time && ends.size() > 1 && move.kind != MoveKind::traverse)
      line.set('F', nc_number(move.speed / move.length * units::minute / (u1 - u0), 4), "XYZABCUVWIJKG");
    if (k + 1 == ends.size() && !last_words.empty()) line.text += last_words;
    at_ = reached;
    if (k + 1 < ends.size()) {
      text += line.text + (line.end.empty() ? "\n" : line.end);
      line = ProgramLine::parse("", line.end);
      u0 = u1;
    }
  }
  // The rest of the line stays with its first piece.
  for (const Word& word : line.words)
    if (word.expression) {
      if (word.letter == 'F' && move.speed > 0.0 && !entry.inverse_time)
        line.set('F', nc_number(move.speed / source.frame.unit * units::minute, 4), "");
      else
        refuse(entry, fmt::format("an expression at {}", word.letter), "expressions for coordinates and F");
      break;
    }
  text += line.text;
  entry.edited = text != entry.line.text;
  entry.text = text;
  if (ends.size() > 1) ++summary_.split;
}

/// A cycle becomes its moves, in absolute coordinates.
void PathRewriter::cycle_move(Entry& entry, const PredictedMove& predicted) {
  const Source& source = *predicted.timed->element.source;
  const Move& move = source.move;
  Nine target = move.to;
  target.head<3>() += displacement(move, predicted, 1.0);
  summary_.largest_um = std::max(summary_.largest_um, (target - move.to).head<3>().norm() / units::um);
  if (entry.done == 1) {
    ProgramLine rest = entry.line;
    std::vector<std::pair<char, double>> gone;
    for (const Word& word : rest.words) {
      if (word.expression) refuse(entry, fmt::format("an expression at {} of a cycle", word.letter), "numbers");
      const double code = word.value;
      const bool cycle_word =
          word.letter == 'G' && (code == 73 || (code >= 81 && code <= 89) || code == 98 || code == 99);
      if (cycle_word || std::string("XYZABCUVWRPQLKIJ").find(word.letter) != std::string::npos)
        gone.emplace_back(word.letter, word.value);
    }
    rest.remove(gone);
    entry.before = core::trimmed(rest.text).empty() ? "" : rest.text + (rest.end.empty() ? "\n" : rest.end);
    if (!entry.absolute) entry.before += "G90\n";
    entry.text.clear();
    ++summary_.written_out;
  }
  Entry absolute;
  absolute.absolute = true;
  ProgramLine line = ProgramLine::parse(move.kind == MoveKind::traverse ? "G0" : "G1", "\n");
  at_ = set_end(line, absolute, source, target, true);
  entry.before += line.text + "\n";
  if (entry.done == entry.expected && !entry.absolute) entry.before += "G91\n";
  entry.edited = true;
}

/// A line that names where the control is: it moves nothing, nor may its displaced one.
void PathRewriter::stay(Entry& entry) const {
  if (!placed_ || entry.skipped || entry.machine || entry.line.control || entry.line.assigns ||
      entry.line.has('G', 10) || entry.line.has('G', 4))
    return;
  ProgramLine line = entry.line;
  const Nine now = entry.frame.to_program(at_);
  for (int i = 0; i < 3; ++i) {
    const char letter = letters[i];
    const Word* word = line.find(letter);
    const double goal = entry.absolute ? now[i] : 0.0;
    if (word == nullptr || (!word->expression && std::abs(word->value - goal) <= half_step(entry.frame))) continue;
    line.set(letter, nc_number(goal, decimals_of(entry.frame)), "");
    entry.edited = true;
  }
  if (const Word* word = line.find('F'); word != nullptr && word->expression && !entry.inverse_time)
    line.set('F', nc_number(entry.frame.feed, 4), "");
  entry.text = line.text;
}

void PathRewriter::emit(Entry& entry) {
  if (entry.expected == 0) stay(entry);
  const auto count = [&](const std::string& text) {
    summary_.lines_after += std::count(text.begin(), text.end(), '\n');
    out_(text);
  };
  if (entry.edited) ++summary_.changed;
  const std::string end = entry.line.end.empty() && !flat_ ? "\n" : entry.line.end;
  if (flat_) {
    while (written_ + 1 < entry.number && written_ < lines_.size()) {
      count(lines_.raw(written_));
      ++written_;
    }
    if (entry.number != written_ + 1) return;  // the end of the program is read twice
    written_ = entry.number;
    if (entry.cycle && entry.expected > 0)
      count(entry.before);
    else
      count(entry.text + end);
    return;
  }
  if (!began_) {
    // Lines before the first one that the interpreter reads, such as %.
    for (std::size_t i = 0; i + 1 < entry.number && i < lines_.size(); ++i) count(lines_.raw(i));
    began_ = true;
  }
  if (entry.line.control || entry.line.assigns || entry.line.has('M', 98) || entry.line.has('M', 99)) return;
  if (entry.skipped && !entry.line.words.empty()) return;
  if (entry.line.label && code_) return;  // of a subprogram
  code_ = code_ || !entry.line.words.empty();
  if (entry.expected == 0)
    for (const Word& word : ProgramLine::parse(entry.text, "").words)
      if (word.expression)
        refuse(entry, fmt::format("an expression at {} of a line without a move", word.letter), "a number");
  if (entry.number == 0) return;
  count(entry.cycle && entry.expected > 0 ? entry.before : entry.text + end);
}

void PathRewriter::flush() {
  while (!entries_.empty() && entries_.front().done == entries_.front().expected) {
    emit(entries_.front());
    entries_.pop_front();
  }
}

void PathRewriter::predicted(const PredictedMove& move) {
  while (!entries_.empty() && entries_.front().done == entries_.front().expected) {
    emit(entries_.front());
    entries_.pop_front();
  }
  edit(entries_.front(), move);
}

bool PathRewriter::finish() {
  if (!entries_.empty()) settle(entries_.back());
  flush();
  if (flat_) {
    for (; written_ < lines_.size(); ++written_) {
      out_(lines_.raw(written_));
      ++summary_.lines_after;
    }
  } else if (began_ && is_percent(lines_, 0) && last_line(lines_) > 0 && is_percent(lines_, last_line(lines_))) {
    out_("%\n");
    ++summary_.lines_after;
  }
  if (summary_.largest_um > 0.05) return true;
  const double largest = summary_.largest_um;
  summary_ = {};
  summary_.lines_before = summary_.lines_after = lines_.size();
  summary_.largest_um = largest;
  return false;
}

}  // namespace thermotwin::nc
