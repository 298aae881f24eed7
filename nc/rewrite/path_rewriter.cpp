// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/rewrite/path_rewriter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/progress.h"
#include "core/text.h"
#include "core/units.h"
#include "nc/rewrite/arc_words.h"
#include "nc/rewrite/coordinates.h"

namespace thermotwin::nc {

namespace units = core::units;

namespace {

/// Words that act at the end of a line: of a split line they go with its last piece.
std::string take_words_at_end(ProgramLine& line) {
  const std::vector<std::pair<char, double>> at_end = {{'M', 0}, {'M', 1},  {'M', 2}, {'M', 5},
                                                       {'M', 9}, {'M', 30}, {'M', 60}};
  std::string words;
  for (const auto& [letter, number] : at_end)
    if (line.has(letter, number)) words += fmt::format(" {}{}", letter, number);
  if (!words.empty()) line.remove(at_end);
  return words;
}

}  // namespace

PathRewriter::PathRewriter(ProgramText lines, std::string name, const AxisMotion& motion, const RewriteOptions& options,
                           std::function<void(const std::string&)> out, Expect expect)
    : program_(std::move(lines)),
      name_(std::move(name)),
      motion_(motion),
      options_(options),
      expect_(std::move(expect)),
      text_(program_, std::move(out)) {
  summary_.lines_before = program_.size();
}

ProgramLine PathRewriter::line_of(const std::string& file, std::size_t number) const {
  const ProgramText* lines = &program_;
  if (file != name_) {
    auto found = others_.find(file);
    if (found == others_.end()) found = others_.emplace(file, ProgramText::of_file(file)).first;
    lines = &found->second;
  }
  return number >= 1 && number <= lines->size() ? lines->line(number - 1) : ProgramLine{};
}

/// Modes change by lines that run; whether one ran is known behind it.
void PathRewriter::settle(ExecutedLine& entry) {
  if (entry.settled || entry.skipped) return;
  entry.settled = true;
  modes_.read(entry.line, options_.words, entry.place);
  entry.modes = modes_;
}

void PathRewriter::block(const MoveState& state, const std::string& file, const Frame& frame) {
  if (!entries_.empty()) {
    settle(entries_.back());
    entries_.back().frame = frame;
  }
  ExecutedLine entry;
  entry.place = fmt::format("{}:{}", file, state.line);
  entry.number = state.line;
  entry.line = line_of(file, state.line);
  entry.text = entry.line.text;
  flush();
  entries_.push_back(std::move(entry));
}

void PathRewriter::move() {
  if (entries_.empty()) return;
  ExecutedLine& entry = entries_.back();
  settle(entry);
  ++entry.expected;
  if (!entry.modes.coordinates && !entry.modes.machine)
    refuse_path(entry.place, "a move in a line whose axis words are no coordinates", "a line of its own for the move");
  if (entry.expected > 1 && !entry.modes.cycle && !entry.modes.machine)
    refuse_path(entry.place, "a line of several moves",
                "one line or arc in a line, and the cycles G73, G81, G82, G83, G85, G89");
}

void PathRewriter::dwell(double seconds) {
  if (!entries_.empty()) entries_.back().dwells.emplace_back(entries_.back().expected, seconds);
}

void PathRewriter::skipped() {
  if (!entries_.empty()) entries_.back().skipped = true;
}

void PathRewriter::edit(ExecutedLine& entry, const PredictedMove& predicted) {
  const DisplacedMove displaced(predicted, motion_, options_, entry.place);
  const Move& move = displaced.move();
  if (!placed_) at_ = move.from;
  placed_ = true;
  nominal_ = move.to;
  ++entry.done;
  feed_.begin_line();
  if (entry.modes.machine) {
    machine_move(entry, displaced.source());
    return;
  }
  see_begin(entry, displaced);
  const bool rapid = move.kind == MoveKind::traverse;
  if (entry.modes.cycle) {
    cycle_move(entry, displaced, predicted);
    if (rapid && displaced.is_cut() && cuts_.count++ == 0) cuts_.first = entry.place;
    return;
  }
  const Eigen::Vector3d d0 = (at_ - move.from).head<3>(), d1 = displaced.displacement(1.0);
  summary_.largest_um = std::max(summary_.largest_um, d1.norm() / units::um);
  std::vector<double> ends = {1.0};
  if (!rapid) ends = displaced.pieces(d0, d1);

  const auto displaced_at = [&](double u) {
    Nine point = AxisMotion::values_at(move, u);
    point.head<3>() += displaced.displacement(u);
    return point;
  };
  const bool arc = move.kind == MoveKind::arc;
  ProgramLine line = entry.line;
  const std::string words_at_end = ends.size() > 1 ? take_words_at_end(line) : "";
  std::string text;
  Piece piece;
  for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
    piece.end = ends[k];
    piece.target = displaced_at(piece.end);
    if (arc) piece.middle = displaced_at(0.5 * (piece.begin + piece.end)).head<3>();
    add_points(piece, displaced, predicted);
    write_piece(line, entry, displaced.source(), piece);
    write_out_feed(line, entry.modes, entry.place, displaced.source());
    text += line.text + (line.end.empty() ? "\n" : line.end);
    line = ProgramLine::parse("", line.end);  // the rest of the line stays with its first piece
    piece.begin = piece.end;
  }
  piece.end = 1.0;
  piece.target = move.to;
  piece.target.head<3>() += d1;
  if (arc) piece.middle = displaced_at(0.5 * (piece.begin + piece.end)).head<3>();
  add_points(piece, displaced, predicted);
  write_piece(line, entry, displaced.source(), piece);
  line.text += words_at_end;
  write_out_feed(line, entry.modes, entry.place, displaced.source());
  if (rapid && displaced.is_cut() && cuts_.count++ == 0) cuts_.first = entry.place;
  const std::string newline = line.end.empty() ? "\n" : line.end;
  entry.text = text + line.text;
  if (feed_.is_per_minute() && words_at_end.find("M2") == std::string::npos &&
      words_at_end.find("M30") == std::string::npos)
    entry.text += newline + "G93";
  entry.edited = entry.text != entry.line.text;
  if (ends.size() > 1) ++summary_.split;
}

/// A block that begins where the program is not corrected takes the offset on its way.
void PathRewriter::see_begin(const ExecutedLine& entry, const DisplacedMove& displaced) {
  if (!uncorrected_) return;
  uncorrected_ = false;
  const Move& move = displaced.move();
  if (move.kind == MoveKind::traverse) return;
  const Eigen::Vector3d wanted = move.from.head<3>() + displaced.displacement(0.0);
  const double rounding = 10.0 * half_step(displaced.source().frame) * displaced.source().frame.unit;
  if ((at_.head<3>() - wanted).norm() > options_.tolerance + rounding && ramps_.count++ == 0)
    ramps_.first = entry.place;
}

void PathRewriter::warn() const {
  if (ramps_.count > 0)
    core::warn(
        fmt::format("{}: a feed move begins without its offset, which comes in along it ({} such move{} in the "
                    "program); a rapid move to its begin in coordinates of the program corrects it",
                    ramps_.first, ramps_.count, ramps_.count == 1 ? "" : "s"));
  if (cuts_.count > 0)
    core::warn(fmt::format("{}: the offset is cut at the end of an axis's travel ({} rapid moves in the program)",
                           cuts_.first, cuts_.count));
}

/// Moments of the move within a piece. The piece of a move that begins undisplaced is not compared.
void PathRewriter::add_points(Piece& piece, const DisplacedMove& displaced, const PredictedMove& predicted) const {
  piece.inside.clear();
  const Move& move = displaced.move();
  if (predicted.inside.empty() || move.kind == MoveKind::traverse) return;
  const double rounding = 10.0 * half_step(displaced.source().frame) * displaced.source().frame.unit;
  const auto begins_off = [&] {
    const Eigen::Vector3d wanted = move.from.head<3>() + displaced.displacement(0.0);
    return (at_.head<3>() - wanted).norm() > options_.tolerance + rounding;
  };
  for (const MoveSample& sample : predicted.inside) {
    if (sample.u <= piece.begin || sample.u > piece.end) continue;
    if (piece.begin == 0.0 && piece.inside.empty() && begins_off()) return;
    ExpectedPoint& point = piece.inside.emplace_back();
    point.share = (sample.u - piece.begin) / (piece.end - piece.begin);
    const Eigen::Vector3d at = displaced.wanted(sample);
    std::copy(at.begin(), at.end(), point.at.begin());
    point.within = 2.0 * options_.tolerance + rounding;
  }
}

/// One line or arc; the control is then at its end.
void PathRewriter::write_piece(ProgramLine& line, const ExecutedLine& entry, const Source& source, const Piece& piece) {
  const Move& move = source.move;
  const bool arc = move.kind == MoveKind::arc, circle = arc && piece.is_whole() && whole_turns(move.arc);
  const std::string before = line.text;
  const Nine target = circle ? closed(piece.target, at_, source) : piece.target;
  const Nine reached = write_end(line, entry.modes.absolute, source.frame, at_, target, piece.begin > 0.0);
  write_turns(line, move, piece);
  expect(entry, source, piece, target);
  if (arc) write_arc(line, entry.modes, source, piece, at_, reached, line.text != before);
  feed_.write(line, entry.modes, source, piece, at_, reached);
  at_ = reached;
}

void PathRewriter::expect(const ExecutedLine& entry, const Source& source, const Piece& piece,
                          const Nine& target) const {
  const Move& move = source.move;
  ExpectedMove expected = ExpectedMove::of(move, source.frame, target);
  const bool turns = move.kind != MoveKind::arc && !(move.to - move.from).segment<3>(3).isZero(0.0);
  if (move.speed > 0.0 && (entry.modes.inverse_time || turns))
    expected.seconds = move.length / move.speed * (piece.end - piece.begin);
  else
    expected.speed = move.speed;
  if (move.kind == MoveKind::arc) {
    expected.angle = move.arc.angle * (piece.end - piece.begin);
    std::copy(piece.middle.begin(), piece.middle.end(), expected.middle.begin());
    expected.middle_within = 2.0 * options_.tolerance + 10.0 * half_step(source.frame) * source.frame.unit;
  }
  expect_(expected, piece.inside);
}

/// It stays as it is. Axes that it does not move keep their displacement.
void PathRewriter::machine_move(const ExecutedLine& entry, const Source& source) {
  const Move& move = source.move;
  if (move.kind != MoveKind::traverse)
    refuse_path(entry.place, "a feed move in machine coordinates (G53)", "G53 with G0, feed moves in a work offset");
  uncorrected_ = true;
  feed_.see(entry.line, entry.modes);
  const bool all =
      std::none_of(letters.begin(), letters.end(), [&](char letter) { return entry.line.find(letter) != nullptr; });
  for (int i = 0; i < 9; ++i)
    if (all || move.to[i] != move.from[i] || entry.line.find(letters[i]) != nullptr) at_[i] = move.to[i];
  ExpectedMove expected = ExpectedMove::of(move, source.frame, at_);
  expected.slack = summary_.largest_um * units::um;  // a point on the way of G28 is displaced
  expect_(expected, {});
}

/// What a cycle's line has beside the cycle stays before its moves; its feed goes with the first of them.
void PathRewriter::begin_cycle(ExecutedLine& entry) {
  ProgramLine rest = entry.line;
  std::vector<std::pair<char, double>> gone;
  for (const Word& word : rest.words) {
    if (word.expression)
      refuse_path(entry.place, fmt::format("an expression at {} of a cycle", word.letter), "numbers");
    const double code = word.value;
    const bool cycle_word =
        word.letter == 'G' && (code == 73 || (code >= 81 && code <= 89) || code == 98 || code == 99);
    const bool feed = word.letter == 'F' && !entry.modes.inverse_time;
    if (feed) entry.feed = " " + rest.text.substr(word.begin, word.end - word.begin);
    if (cycle_word || feed || std::string("XYZABCUVWRPQLKIJ@^").find(word.letter) != std::string::npos)
      gone.emplace_back(word.letter, word.value);
  }
  rest.remove(gone);
  entry.feed = feed_.of_cycle(entry);
  const std::string text(core::trimmed(rest.text));
  entry.before = text.empty() ? "" : text + (rest.end.empty() ? "\n" : rest.end);
  if (!entry.modes.absolute) entry.before += "G90\n";
  entry.text.clear();
  ++summary_.written_out;
}

/// A cycle becomes its moves, in absolute coordinates.
void PathRewriter::cycle_move(ExecutedLine& entry, const DisplacedMove& displaced, const PredictedMove& predicted) {
  const Move& move = displaced.move();
  const Source& source = displaced.source();
  const bool rapid = move.kind == MoveKind::traverse;
  const Eigen::Vector3d d0 = (at_ - move.from).head<3>(), d1 = displaced.displacement(1.0);
  summary_.largest_um = std::max(summary_.largest_um, d1.norm() / units::um);
  if (entry.done == 1) begin_cycle(entry);
  Piece piece;
  for (const double end : rapid ? std::vector<double>{1.0} : displaced.pieces(d0, d1)) {
    piece.end = end;
    piece.target = AxisMotion::values_at(move, end);
    piece.target.head<3>() += end == 1.0 ? d1 : displaced.displacement(end);
    add_points(piece, displaced, predicted);
    ProgramLine line = ProgramLine::parse(rapid ? "G0" : "G1", "\n");
    at_ = write_end(line, true, source.frame, at_, piece.target, true);
    entry.before += line.text + (rapid ? "" : entry.feed) + "\n";
    if (!rapid) entry.feed.clear();
    ExpectedMove expected = ExpectedMove::of(move, source.frame, piece.target);
    expected.path_mode = 0;  // a cycle has its own
    expect_(expected, piece.inside);
    piece.begin = piece.end;
  }
  for (const auto& [behind, seconds] : entry.dwells)
    if (behind == entry.done)
      entry.before +=
          fmt::format("G4 P{}\n", options_.dwells_in_ms ? fmt::format("{:.0f}", 1e3 * seconds) : nc_number(seconds, 4));
  if (entry.done == entry.expected && !entry.modes.absolute) entry.before += "G91\n";
  entry.edited = true;
}

/// A line that names where the control is: it moves nothing, nor may its displaced one.
void PathRewriter::stay(ExecutedLine& entry) {
  if (placed_ && !entry.skipped && entry.modes.machine)
    for (int i = 0; i < 9; ++i)
      if (entry.line.find(letters[i]) != nullptr) at_[i] = nominal_[i];
  if (!entry.skipped) feed_.see(entry.line, entry.modes);
  if (!placed_ || entry.skipped || entry.modes.machine || !entry.modes.coordinates || entry.line.control ||
      entry.line.assigns)
    return;
  ProgramLine line = entry.line;
  const Nine now = entry.frame.to_program(at_);
  if (take_polar(line)) {
    for (int i = 0; i < 2; ++i)
      line.set(letters[i], nc_number(entry.modes.absolute ? now[i] : 0.0, decimals_of(entry.frame)), "XG");
    entry.edited = true;
  }
  for (int i = 0; i < 3; ++i) {
    const char letter = letters[i];
    const Word* word = line.find(letter);
    const double goal = entry.modes.absolute ? now[i] : 0.0;
    if (word == nullptr || (!word->expression && std::abs(word->value - goal) <= half_step(entry.frame))) continue;
    line.set(letter, nc_number(goal, decimals_of(entry.frame)), "");
    entry.edited = true;
  }
  if (const Word* word = line.find('F'); word != nullptr && word->expression && !entry.modes.inverse_time)
    line.set('F', nc_number(entry.frame.feed, 4), "");
  entry.text = line.text;
}

void PathRewriter::emit(ExecutedLine& entry) {
  if (entry.expected == 0) stay(entry);
  if (entry.edited) ++summary_.changed;
  text_.add(entry);
}

void PathRewriter::flush() {
  while (!entries_.empty() && entries_.front().done == entries_.front().expected) {
    emit(entries_.front());
    entries_.pop_front();
  }
}

void PathRewriter::predicted(const PredictedMove& move) {
  flush();
  edit(entries_.front(), move);
}

bool PathRewriter::finish() {
  if (!entries_.empty()) settle(entries_.back());
  flush();
  warn();
  text_.finish();
  summary_.lines_after = text_.lines_after();
  if (summary_.largest_um > 0.05) return true;
  const double largest = summary_.largest_um;
  summary_ = {};
  summary_.lines_before = summary_.lines_after = program_.size();
  summary_.largest_um = largest;
  return false;
}

}  // namespace thermotwin::nc
