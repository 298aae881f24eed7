// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/rewrite/shift_rewriter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/error.h"
#include "core/text.h"
#include "core/units.h"

namespace thermotwin::nc {

namespace units = core::units;

namespace {

/// "o100" of a line that begins with an O-word, in lower case.
std::string label_of(const ProgramLine& line) {
  const std::string text = core::lower(line.text);
  std::size_t at = text.find_first_not_of(" \t/");
  if (at == std::string::npos || text[at] != 'o') return "";
  const std::size_t end = text[at + 1] == '<' ? text.find('>', at) : text.find_first_not_of("0123456789 ", at + 1);
  return text.substr(at, end == std::string::npos ? end : end - at);
}

}  // namespace

ShiftRewriter::ShiftRewriter(ProgramText lines, std::string name, const AxisMotion& motion,
                             const RewriteOptions& options, std::function<void(const ExpectedMove&)> expect)
    : lines_(std::move(lines)),
      name_(std::move(name)),
      motion_(motion),
      options_(options),
      expect_(std::move(expect)) {
  summary_.lines_before = summary_.lines_after = lines_.size();
  closed_.assign(lines_.size() + 1, false);
  std::map<std::string, std::pair<std::size_t, std::size_t>> spans;
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    const ProgramLine line = lines_.line(i);
    if (line.control) {
      const std::string label = label_of(line);
      spans.emplace(label, std::pair{i, i}).first->second.second = i;
    }
    for (const auto& [letter, number] : {std::pair{'G', 92.0}, {'G', 10.0}})
      if (line.has(letter, number))
        throw core::InputError(fmt::format("{}:{}", name_, i + 1),
                               fmt::format("{}{} with --rewrite shift", letter, number),
                               "work offsets that the program does not set itself");
  }
  for (const auto& [label, span] : spans)
    for (std::size_t i = span.first; i <= span.second; ++i) closed_[i + 1] = true;
  sections_.emplace_back();
}

bool ShiftRewriter::is_open(std::size_t line) const { return line < closed_.size() && !closed_[line]; }

void ShiftRewriter::block(const MoveState& state, const std::string& file, const Frame& frame) {
  if (main_ && retracts_ && moves_in_line_ == 1 && line_ > last_ && is_open(line_)) {
    Section section;
    section.behind = line_;
    section.unit = frame.unit;
    sections_.push_back(section);
    last_ = line_;
    named_.clear();
  }
  line_ = state.line;
  unit_ = frame.unit;
  main_ = file == name_ && state.depth == 0;
  if (main_) main_line_ = line_;
  moves_in_line_ = 0;
  retracts_ = false;
  see_words(file);
}

/// Axis words of the line that runs, in this file; of others nothing is known.
void ShiftRewriter::see_words(const std::string& file) {
  if (file != name_ || line_ < 1 || line_ > lines_.size()) return;
  const ProgramLine line = lines_.line(line_ - 1);
  for (const double number : {90.0, 91.0})
    if (line.has('G', number)) absolute_ = number == 90.0;
  for (const char letter : std::string("XYZ"))
    if (absolute_ && line.find(letter) != nullptr) named_.insert(letter);
}

void ShiftRewriter::move(const Move& move) {
  if (!moved_) {
    // The first update stands before the first line that moves, and before the loop or subprogram that it is in.
    std::size_t line = main_ ? line_ : main_line_;
    const auto units_in = [&](std::size_t at) {
      return at >= 1 && at <= lines_.size() && (lines_.line(at - 1).has('G', 20) || lines_.line(at - 1).has('G', 21));
    };
    if (units_in(line))
      throw core::InputError(fmt::format("{}:{}", name_, line), "the length unit in the first line that moves",
                             "G20 or G21 in a line before it, for --rewrite shift");
    while (line > 1 && !is_open(line)) --line;
    sections_.front().unit = unit_;
    const bool calls = !main_ && line == main_line_;
    sections_.front().behind = is_open(line) && line != line_ && !calls ? line : line - 1;
  }
  moved_ = true;
  ++moves_in_line_;
  const Nine change = move.to - move.from;
  retracts_ = move.kind == MoveKind::traverse && change[2] > 0.0 && change[0] == 0.0 && change[1] == 0.0;
  const int own = static_cast<int>(sections_.size()) - 1;
  section_of_.push_back(own);
  if (move.kind == MoveKind::traverse || sections_.back().cuts) return;
  if (own > 0 && named_.size() < 3) {  // no place of an update: its moves go on with those before
    for (int& section : section_of_) section = std::min(section, own - 1);
    sections_.pop_back();
  }
  sections_.back().cuts = true;
}

void ShiftRewriter::predicted(const PredictedMove& predicted) {
  const Source& source = *predicted.timed->element.source;
  Section& section = sections_[section_of_.front()];
  section_of_.pop_front();
  ExpectedMove expected = ExpectedMove::of(source.move, source.frame, source.move.to);
  if (source.move.kind == MoveKind::arc) expected.angle = source.move.arc.angle;
  expect_(expected);
  if (source.move.kind == MoveKind::traverse) return;
  if (section.seconds == 0.0) {
    section.frame = source.frame;
    section.low = section.high = displacement(source, predicted, predicted.end, predicted.offset_um);
  }
  if (section.frame.work_number != source.frame.work_number)
    throw core::InputError(fmt::format("{}:{}", name_, source.move.state.line),
                           "another work offset between two retracted moves",
                           "a rapid move up along Z before each change of the work offset");
  // The trapezoidal rule over the begin, the moments within and the end.
  double time = predicted.start;
  Eigen::Vector3d last = displacement(source, predicted, predicted.begin, predicted.begin_um);
  const auto add = [&](double until, const Eigen::Vector3d& next) {
    const double seconds = std::max(until - time, 1e-9);
    section.seconds += seconds;
    section.sum += 0.5 * seconds * (last + next);
    section.low = section.low.cwiseMin(last).cwiseMin(next);
    section.high = section.high.cwiseMax(last).cwiseMax(next);
    summary_.largest_um = std::max(summary_.largest_um, next.norm() / units::um);
    time = until;
    last = next;
  };
  for (const MoveSample& sample : predicted.inside)
    add(sample.time, displacement(source, predicted, sample.positions, sample.offset_um));
  add(predicted.time, displacement(source, predicted, predicted.end, predicted.offset_um));
}

/// m, of the programmed point
Eigen::Vector3d ShiftRewriter::displacement(const Source& source, const PredictedMove& predicted, Positions positions,
                                            const Eigen::VectorXd& offset_um) const {
  const Nine nominal = motion_.values(positions, source.move, source.move.to);
  for (std::size_t i = 0; i < predicted.field->axes().size(); ++i)
    positions[motion_.machine().axis_index(predicted.field->axes()[i])] += offset_um[i] * units::um;
  const Eigen::Vector3d displacement = (motion_.values(positions, source.move, nominal) - nominal).head<3>();
  if (displacement.norm() > options_.largest_offset)
    throw core::InputError(fmt::format("{}:{}", name_, source.move.state.line),
                           fmt::format("an offset of {:.1f} um", displacement.norm() / units::um),
                           fmt::format("at most {:.1f} um", options_.largest_offset / units::um));
  return displacement;
}

void ShiftRewriter::finish(const std::function<void(const std::string&)>& out) {
  std::map<std::size_t, std::string> updates;
  std::map<int, Eigen::Vector3d> in_use;
  for (const Section& section : sections_) {
    if (section.seconds == 0.0) continue;
    const Eigen::Vector3d mean = section.sum / section.seconds;
    Eigen::Vector3d& used = in_use.emplace(section.frame.work_number, Eigen::Vector3d::Zero()).first->second;
    if ((mean - used).cwiseAbs().maxCoeff() > options_.tolerance) {
      const double unit = section.unit;
      const int decimals = unit > 0.01 ? 5 : 4;
      std::string text = fmt::format("G10 L2 P{}", section.frame.work_number);
      for (int i = 0; i < 3; ++i) {
        const std::string number = nc_number((section.frame.work[i] + mean[i]) / unit, decimals);
        text += fmt::format(" {}{}", letters[i], number);
        used[i] = std::stod(number) * unit - section.frame.work[i];
        largest_update_ = std::max(largest_update_, std::abs(used[i]));
      }
      updates[section.behind] = text;
      updated_.insert(section.frame.work_number);
    }
    for (const Eigen::Vector3d& end : {section.low, section.high})
      largest_left_ = std::max(largest_left_, (end - used).cwiseAbs().maxCoeff() / units::um);
  }
  for (std::size_t i = 0; i <= lines_.size(); ++i) {
    if (i > 0) out(lines_.raw(i - 1));
    const auto update = updates.find(i);
    if (update == updates.end()) continue;
    const std::string end = i > 0 ? lines_.line(i - 1).end : "\n";
    out((end.empty() ? "\n" : "") + update->second + (end.empty() ? "\n" : end));
    ++summary_.changed;
    ++summary_.lines_after;
  }
}

}  // namespace thermotwin::nc
