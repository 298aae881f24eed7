// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/rewrite/path_rewriter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/progress.h"
#include "core/text.h"
#include "core/units.h"
#include "nc/rewrite/coordinates.h"

namespace thermotwin::nc {

namespace units = core::units;

namespace {

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

/// A circle ends where it began.
Nine closed(const Nine& target, const Nine& at, const Source& source) {
  Nine to = source.frame.to_program(target);
  const Nine here = source.frame.to_program(at);
  for (const int axis : plane_of(source.move.arc, source.frame).axes) to[axis] = here[axis];
  return source.frame.to_axes(to);
}

}  // namespace

PathRewriter::PathRewriter(ProgramText lines, std::string name, const AxisMotion& motion, const RewriteOptions& options,
                           std::function<void(const std::string&)> out, Expect expect)
    : lines_(std::move(lines)),
      name_(std::move(name)),
      motion_(motion),
      options_(options),
      out_(std::move(out)),
      expect_(std::move(expect)) {
  for (std::size_t i = 0; i < lines_.size() && flat_; ++i) {
    const ProgramLine line = lines_.line(i);
    flat_ = !(line.control || line.assigns || line.has('M', 98) || line.has('M', 99));
  }
  summary_.lines_before = lines_.size();
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

/// Modes change by lines that run; whether one ran is known behind it.
void PathRewriter::settle(Entry& entry) {
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

void PathRewriter::edit(Entry& entry, const PredictedMove& predicted) {
  const DisplacedMove displaced(predicted, motion_, options_, entry.place);
  const Move& move = displaced.move();
  if (!placed_) at_ = move.from;
  placed_ = true;
  nominal_ = move.to;
  ++entry.done;
  per_minute_ = false;
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
    write_out_feed(line, entry, displaced.source());
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
  write_out_feed(line, entry, displaced.source());
  if (rapid && displaced.is_cut() && cuts_.count++ == 0) cuts_.first = entry.place;
  const std::string newline = line.end.empty() ? "\n" : line.end;
  entry.text = text + line.text;
  if (per_minute_ && words_at_end.find("M2") == std::string::npos && words_at_end.find("M30") == std::string::npos)
    entry.text += newline + "G93";
  entry.edited = entry.text != entry.line.text;
  if (ends.size() > 1) ++summary_.split;
}

/// A block that begins where the program is not corrected takes the offset on its way.
void PathRewriter::see_begin(const Entry& entry, const DisplacedMove& displaced) {
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
void PathRewriter::write_piece(ProgramLine& line, const Entry& entry, const Source& source, const Piece& piece) {
  const Move& move = source.move;
  const bool arc = move.kind == MoveKind::arc, circle = arc && piece.is_whole() && whole_turns(move.arc);
  const std::string before = line.text;
  const Nine target = circle ? closed(piece.target, at_, source) : piece.target;
  const Nine reached = write_end(line, entry.modes.absolute, source.frame, at_, target, piece.begin > 0.0);
  write_turns(line, move, piece);
  expect(entry, source, piece, target);
  if (arc) write_arc(line, entry, source, piece, reached, line.text != before);
  write_feed(line, entry, source, piece, reached);
  at_ = reached;
}

namespace {

/// With five digits or more.
std::string feed_number(double feed) {
  return nc_number(feed, std::clamp(4 - static_cast<int>(std::floor(std::log10(feed))), 4, 9));
}

}  // namespace

/// The feed of a straight piece with rotary axes, so that it takes its share of the move's time; nothing where the
/// program's own does.
std::optional<std::string> PathRewriter::feed_word(const Source& source, const Piece& piece, const Nine& reached,
                                                   bool inverse) const {
  const Move& move = source.move;
  const Frame& frame = source.frame;
  const bool turns = !(move.to - move.from).segment<3>(3).isZero(0.0);
  if (move.kind != MoveKind::feed || !turns) return std::nullopt;
  Nine change = reached - at_;
  for (int i = 0; i < 9; ++i)
    if (!is_angle(i) && std::abs(change[i]) < 0.1 * half_step(frame) * frame.unit) change[i] = 0.0;
  const auto count = [&](const Nine& of) {
    return frame.feed_length(of) / (has_only_angles(of) ? units::deg : frame.unit);
  };
  const double minutes = move.length / move.speed * (piece.end - piece.begin) / units::minute;
  const double length = count(change), feed = length / minutes;
  // LinuxCNC turns F of G93 into a feed rate of at least 0.1.
  constexpr double least = 0.2;
  if (!(length > 0.0) || (inverse && feed > least)) return std::nullopt;
  const double own = count(move.to - move.from) / (move.length / move.speed / units::minute);
  if (!inverse && std::abs(feed - own) <= 0.01 * own) return std::nullopt;
  const double turn = frame.feed_per_turn && !inverse ? std::abs(move.state.spindle_rpm) : 1.0;
  return feed_number(feed / turn);
}

void PathRewriter::write_feed(ProgramLine& line, const Entry& entry, const Source& source, const Piece& piece,
                              const Nine& reached) {
  const Move& move = source.move;
  const bool inverse = entry.modes.inverse_time;
  constexpr const char* behind = "XYZABCUVWIJKG";
  if (!inverse && line.find('F') != nullptr) other_feed_ = false;
  if (move.kind == MoveKind::traverse) return;
  if (const auto feed = feed_word(source, piece, reached, inverse)) {
    if (inverse) {
      line.remove({{'G', 93}});
      if (!per_minute_) line.text.insert(line.code_end, " G94");
      line = ProgramLine::parse(line.text, line.end);
      per_minute_ = true;
    }
    line.set('F', *feed, behind);
    other_feed_ = true;
  } else if (inverse) {
    if (per_minute_) line.text.insert(line.code_end, " G93");
    if (per_minute_) line = ProgramLine::parse(line.text, line.end);
    per_minute_ = false;
    const double share = piece.end - piece.begin;
    if (!piece.is_whole()) line.set('F', feed_number(move.speed / move.length * units::minute / share), behind);
  } else if (other_feed_ && source.frame.feed > 0.0) {
    line.set('F', feed_number(move.has_only_angles() ? source.frame.angular_feed : source.frame.feed), behind);
    other_feed_ = source.frame.angular_feed != source.frame.feed;
  }
}

/// The word P of an arc counts turns: a piece is less than one.
void PathRewriter::write_turns(ProgramLine& line, const Move& move, const Piece& piece) {
  const Word* word = move.kind == MoveKind::arc ? line.find('P') : nullptr;
  if (word == nullptr) return;
  if (!piece.is_whole()) {
    line.remove('P');
  } else if (word->expression) {
    line.set('P', fmt::format("{:.0f}", std::ceil(move.arc.angle / (2.0 * std::numbers::pi) - 1e-9)), "");
  }
}

void PathRewriter::expect(const Entry& entry, const Source& source, const Piece& piece, const Nine& target) const {
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
void PathRewriter::machine_move(const Entry& entry, const Source& source) {
  const Move& move = source.move;
  if (move.kind != MoveKind::traverse)
    refuse_path(entry.place, "a feed move in machine coordinates (G53)", "G53 with G0, feed moves in a work offset");
  uncorrected_ = true;
  if (entry.line.find('F') != nullptr && !entry.modes.inverse_time) other_feed_ = false;
  const bool all =
      std::none_of(letters.begin(), letters.end(), [&](char letter) { return entry.line.find(letter) != nullptr; });
  for (int i = 0; i < 9; ++i)
    if (all || move.to[i] != move.from[i] || entry.line.find(letters[i]) != nullptr) at_[i] = move.to[i];
  ExpectedMove expected = ExpectedMove::of(move, source.frame, at_);
  expected.slack = summary_.largest_um * units::um;  // a point on the way of G28 is displaced
  expect_(expected, {});
}

/// The centre of an arc that leads from where the control is to a point.
void PathRewriter::write_arc(ProgramLine& line, const Entry& entry, const Source& source, const Piece& piece,
                             const Nine& reached, bool changed) const {
  const Move& move = source.move;
  const auto off = [&](const Eigen::Vector3d& point, double u) -> Eigen::Vector3d {
    return point - AxisMotion::values_at(move, u).head<3>();
  };
  const Eigen::Vector3d start = at_.head<3>(), end = reached.head<3>();
  const Eigen::Vector3d normal = move.arc.first.cross(move.arc.second);
  const Eigen::Vector3d a = off(start, piece.begin), b = off(end, piece.end);
  const bool radius = line.find('R') != nullptr;
  const bool moved = a.norm() > 1e-9 || changed || !piece.is_whole();
  if (radius && !moved) return;
  if (radius) line.remove('R');
  const bool circle = piece.is_whole() && whole_turns(move.arc);
  const Eigen::Vector3d centre =
      circle ? Eigen::Vector3d(move.arc.centre + a) : centre_of(start, end, move.arc.centre + 0.5 * (a + b), normal);
  write_centre(line, entry.modes.arc_absolute, source, start, centre);
}

/// An expression for F becomes its value: parameters are written out.
void PathRewriter::write_out_feed(ProgramLine& line, const Entry& entry, const Source& source) {
  const auto word = std::find_if(line.words.begin(), line.words.end(), [](const Word& one) { return one.expression; });
  if (word == line.words.end()) return;
  if (word->letter != 'F' || !(source.move.speed > 0.0) || entry.modes.inverse_time)
    refuse_path(entry.place, fmt::format("an expression at {}", word->letter), "expressions for coordinates and F");
  line.set('F', nc_number(source.move.speed / source.frame.unit * units::minute, 4), "");
}

/// What a cycle's line has beside the cycle stays before its moves; its feed goes with the first of them.
void PathRewriter::begin_cycle(Entry& entry) {
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
  if (other_feed_ && entry.feed.empty() && !entry.modes.inverse_time) entry.feed = " F" + feed_number(entry.frame.feed);
  other_feed_ = false;
  const std::string text(core::trimmed(rest.text));
  entry.before = text.empty() ? "" : text + (rest.end.empty() ? "\n" : rest.end);
  if (!entry.modes.absolute) entry.before += "G90\n";
  entry.text.clear();
  ++summary_.written_out;
}

/// A cycle becomes its moves, in absolute coordinates.
void PathRewriter::cycle_move(Entry& entry, const DisplacedMove& displaced, const PredictedMove& predicted) {
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
void PathRewriter::stay(Entry& entry) {
  if (placed_ && !entry.skipped && entry.modes.machine)
    for (int i = 0; i < 9; ++i)
      if (entry.line.find(letters[i]) != nullptr) at_[i] = nominal_[i];
  if (!entry.skipped && entry.line.find('F') != nullptr && !entry.modes.inverse_time) other_feed_ = false;
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

void PathRewriter::count(const std::string& text) {
  summary_.lines_after += std::count(text.begin(), text.end(), '\n');
  out_(text);
}

/// A program without loops keeps all of its lines, also those that the interpreter does not read.
void PathRewriter::emit_flat(const Entry& entry) {
  while (written_ + 1 < entry.number && written_ < lines_.size()) {
    count(lines_.raw(written_));
    ++written_;
  }
  if (entry.number != written_ + 1) return;  // the end of the program is read twice
  written_ = entry.number;
  count(entry.modes.cycle && entry.expected > 0 ? entry.before : entry.text + entry.line.end);
}

void PathRewriter::emit(Entry& entry) {
  if (entry.expected == 0) stay(entry);
  if (entry.edited) ++summary_.changed;
  if (flat_) {
    emit_flat(entry);
    return;
  }
  const std::string end = entry.line.end.empty() ? "\n" : entry.line.end;
  if (!began_) {
    // Lines before the first one that the interpreter reads, such as %.
    for (std::size_t i = 0; i + 1 < entry.number && i < lines_.size(); ++i) count(lines_.raw(i));
    began_ = true;
  }
  const bool words = std::any_of(entry.line.words.begin(), entry.line.words.end(),
                                 [](const Word& word) { return word.letter != 'N'; });
  if (entry.line.assigns && words && !entry.skipped)
    refuse_path(entry.place, "a parameter that is set in a line with other words", "a line of its own for it");
  if (entry.line.control || entry.line.assigns || entry.line.has('M', 98) || entry.line.has('M', 99)) return;
  if (entry.skipped && !entry.line.words.empty()) return;
  if (entry.line.label && code_) return;  // of a subprogram
  code_ = code_ || !entry.line.words.empty();
  if (entry.expected == 0)
    for (const Word& word : ProgramLine::parse(entry.text, "").words)
      if (word.expression)
        refuse_path(entry.place, fmt::format("an expression at {} of a line without a move", word.letter), "a number");
  if (entry.number == 0) return;
  ended_ = ended_ || entry.line.has('M', 2) || entry.line.has('M', 30);
  count(entry.modes.cycle && entry.expected > 0 ? entry.before : entry.text + end);
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
  warn();
  if (flat_) {
    for (; written_ < lines_.size(); ++written_) {
      out_(lines_.raw(written_));
      ++summary_.lines_after;
    }
  } else {
    const bool percent =
        began_ && is_percent(lines_, 0) && last_line(lines_) > 0 && is_percent(lines_, last_line(lines_));
    // A main program may end with M99, which goes with the subprograms.
    if (percent || !ended_) {
      out_(percent ? "%\n" : "M2\n");
      ++summary_.lines_after;
    }
  }
  if (summary_.largest_um > 0.05) return true;
  const double largest = summary_.largest_um;
  summary_ = {};
  summary_.lines_before = summary_.lines_after = lines_.size();
  summary_.largest_um = largest;
  return false;
}

}  // namespace thermotwin::nc
