// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/rewrite/feed_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/units.h"
#include "nc/rewrite/coordinates.h"

namespace thermotwin::nc {

namespace units = core::units;

namespace {

/// With five digits or more.
std::string feed_number(double feed) {
  return nc_number(feed, std::clamp(4 - static_cast<int>(std::floor(std::log10(feed))), 4, 9));
}

/// The feed of a straight piece with rotary axes, so that it takes its share of the move's time; nothing where the
/// program's own does.
std::optional<std::string> feed_word(const Source& source, const Piece& piece, const Nine& at, const Nine& reached,
                                     bool inverse) {
  const Move& move = source.move;
  const Frame& frame = source.frame;
  const bool turns = !(move.to - move.from).segment<3>(3).isZero(0.0);
  if (move.kind != MoveKind::feed || !turns) return std::nullopt;
  Nine change = reached - at;
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

}  // namespace

void FeedWords::write(ProgramLine& line, const LineModes& modes, const Source& source, const Piece& piece,
                      const Nine& at, const Nine& reached) {
  const Move& move = source.move;
  const bool inverse = modes.inverse_time;
  constexpr const char* behind = "XYZABCUVWIJKG";
  see(line, modes);
  if (move.kind == MoveKind::traverse) return;
  if (const auto feed = feed_word(source, piece, at, reached, inverse)) {
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

std::string FeedWords::of_cycle(const ExecutedLine& cycle) {
  std::string feed = cycle.feed;
  if (other_feed_ && feed.empty() && !cycle.modes.inverse_time) feed = " F" + feed_number(cycle.frame.feed);
  other_feed_ = false;
  return feed;
}

void write_out_feed(ProgramLine& line, const LineModes& modes, const std::string& place, const Source& source) {
  const auto word = std::find_if(line.words.begin(), line.words.end(), [](const Word& one) { return one.expression; });
  if (word == line.words.end()) return;
  if (word->letter != 'F' || !(source.move.speed > 0.0) || modes.inverse_time)
    refuse_path(place, fmt::format("an expression at {}", word->letter), "expressions for coordinates and F");
  line.set('F', nc_number(source.move.speed / source.frame.unit * units::minute, 4), "");
}

}  // namespace thermotwin::nc
