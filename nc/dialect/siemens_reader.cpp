// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/dialect/siemens_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <utility>

#include "core/error.h"
#include "core/text.h"
#include "nc/dialect/siemens_words.h"
#include "nc/dialect/tcp_marker.h"

namespace thermotwin::nc {

using core::InputError;

namespace {

constexpr double mm_per_inch = 25.4;
constexpr std::size_t longest_line = 254;

/// Declarations, and limits of the spindle or the working area, which are blocks of their own.
bool without_effect(const SiemensLine& line) {
  const SiemensStatement& first = line.statements.front();
  return first.name == "EXTERN" || (first.name == "G" && (first.value == "25" || first.value == "26"));
}

int axis_of(const std::string& name) {
  const auto found = name.size() == 1 ? std::find(letters.begin(), letters.end(), name[0]) : letters.end();
  return found == letters.end() ? -1 : found - letters.begin();
}

}  // namespace

SiemensReader::SiemensReader(const ControlProfile& control, int axis_mask, std::string name, const Nine& start)
    : control_(control),
      mask_(axis_mask),
      name_(std::move(name)),
      places_(control, start) {}

std::string SiemensReader::translate(std::string_view line, std::size_t number) {
  place_ = fmt::format("{}:{}", name_, number);
  const SiemensLine parsed = parse_siemens_line(line, place_);
  if (parsed.statements.empty() || without_effect(parsed)) return "";
  std::string text;
  if (is_frame(parsed.statements.front().name)) {
    text = frame(parsed.statements);
  } else {
    Block block;
    for (const SiemensStatement& each : parsed.statements) statement(each, block);
    text = written(block);
  }
  if (text.empty()) return "";
  if (parsed.skip_mark) text.insert(0, "/");
  if (text.size() > longest_line)
    throw InputError(place_, fmt::format("a block of {} characters", text.size()),
                     fmt::format("blocks of at most {} in LinuxCNC's language", longest_line));
  return text;
}

void SiemensReader::statement(const SiemensStatement& statement, Block& block) {
  // Without arguments, or with the empty name of a swivel data set, it ends the tilt.
  const std::string arguments = statement.arguments;
  if (statement.name == "CYCLE800" && (core::trimmed(arguments).empty() || core::trimmed(arguments) == "0")) return;
  if (by_profile(statement, block)) return;
  const std::string& name = statement.name;
  if (name == "G") return g_word(statement, block);
  if (name == "M" || name == "M1") return m_word(statement, block);
  if (name == "T" || name == "D") return tool(statement, block);
  if (statement.is_letter() || name == "S1") return letter(statement, block);
  if (name[0] == 'R' &&
      std::all_of(name.begin() + 1, name.end(), [](unsigned char c) { return std::isdigit(c) != 0; })) {
    parameters_[std::stol(name.substr(1, 9))] = plain(statement);
    return;
  }
  keyword(statement, block);
}

bool SiemensReader::by_profile(const SiemensStatement& statement, Block& block) const {
  const bool word = statement.is_letter() && !statement.assigned && !statement.value.empty();
  for (const WordRule& rule : control_.words) {
    if (!rule.name.empty() ? statement.name != rule.name : !word || statement.name[0] != rule.letter) continue;
    if (rule.name.empty()) {
      if (siemens_value(statement.value, parameters_, place_).number != rule.number) continue;
      // The helper applies rules of letters and numbers.
      block.words.push_back(statement.name + statement.value);
      return true;
    }
    switch (rule.action) {
      case WordRule::Action::refuse:
        refuse(statement, rule.says.empty() ? "a program without it" : "a program without it: it " + rule.says);
      case WordRule::Action::tcp_on: block.tcp = tcp_on_marker; break;
      case WordRule::Action::tcp_off: block.tcp = tcp_off_marker; break;
      default: break;
    }
    if (!rule.by.empty()) block.words.push_back(rule.by);
    return true;
  }
  return false;
}

void SiemensReader::g_word(const SiemensStatement& statement, Block& block) {
  const int number = whole(statement);
  if (is_same_word(number)) {
    if (number >= 93 && number <= 95) inverse_time_ = number == 93;
    block.words.push_back(fmt::format("G{}", number));
  } else if (number == 4) {
    block.dwell = true;
    block.words.emplace_back("G4");
  } else if (number == 90 || number == 91) {
    places_.set_absolute(number == 90);
  } else if (number == 70 || number == 700 || number == 71 || number == 710) {
    unit_g(number, block);
  } else if (!is_skipped_word(number) && !frame_g(number, block) && !path_g(number, block)) {
    refuse_unknown(statement);
  }
}

void SiemensReader::unit_g(int number, Block& block) {
  const bool inch = number == 70 || number == 700;
  if (inch != inch_) places_.change_unit(inch ? 1.0 / mm_per_inch : mm_per_inch);
  inch_ = inch;
  feed_in_inch_ = number == 700;
  block.unit = true;
  block.words.emplace_back(inch ? "G20" : "G21");
}

/// LinuxCNC counts F in the unit of lengths that holds before the line: it takes F before G20 and G21. A feed that
/// holds on stays the same speed when the unit changes.
void SiemensReader::add_feed(Block& block) {
  const bool inch_before = std::exchange(inch_before_, inch_);
  if (!block.feed) return;
  double feed = *block.feed;
  if (!inverse_time_) {
    const double mm = feed_in_inch_ ? feed * mm_per_inch : feed;
    feed = inch_before ? mm / mm_per_inch : mm;
  }
  block.words.insert(block.words.begin() + std::min(block.feed_at, block.words.size()), "F" + number_text(feed));
}

bool SiemensReader::frame_g(int number, Block& block) {
  static const std::map<int, const char*> frames{{54, "G54"},  {55, "G55"},  {56, "G56"},    {57, "G57"},
                                                 {505, "G58"}, {506, "G59"}, {507, "G59.1"}, {508, "G59.2"}};
  if (number == 53 || number == 153) {
    block.machine = true;
    return true;
  }
  const auto found = frames.find(number);
  if (found == frames.end() && number != 500) return false;
  if (number == 500) {  // none: the last one of LinuxCNC, which is zero
    for (const WorkOffset& offset : control_.work_offsets)
      if (offset.number == 9)
        throw InputError(place_, "G500 beside work offset 9 of the control profile", "work offsets 1 to 8, or no G500");
  }
  block.words.emplace_back(number == 500 ? "G59.3" : found->second);
  places_.use_work_offset(number == 500 ? 9 : number < 500 ? number - 53 : number - 500);
  return true;
}

bool SiemensReader::path_g(int number, Block& block) {
  if (number == 9) {
    exact_stop_once_ = true;
  } else if (number == 60 || number == 64 || number == 641) {
    path_ = number;
  } else if (number >= 642 && number <= 645) {
    path_ = 64;
  } else {
    return false;
  }
  block.path_mode = true;
  return true;
}

std::string SiemensReader::path_mode() const {
  if (path_ == 60) return "G61.1";
  if (path_ == 641) return adis_ > 0 ? "G64 P" + number_text(adis_) : "G61";
  return "G64";
}

void SiemensReader::m_word(const SiemensStatement& statement, Block& block) const {
  const long number = whole(statement);
  if (number == 6) block.tool_change = true;
  block.words.push_back(fmt::format("M{}", number == 17 ? 2 : number));
}

void SiemensReader::tool(const SiemensStatement& statement, Block& block) {
  if (statement.name == "D") {
    const long edge = whole(statement);
    if (edge > 1) refuse(statement, "D0 or D1: a tool of the control profile has one edge");
    edge_ = edge == 1;
    block.edge = true;
    return;
  }
  long number = 0;
  if (!statement.value.empty() && statement.value.front() == '"') {
    const std::string name = core::upper(statement.value.substr(1, statement.value.size() - 2));
    std::vector<std::string> names;
    const Tool* found = nullptr;
    for (const Tool& each : control_.tools) {
      if (!each.name.empty()) names.push_back(each.name);
      if (core::upper(each.name) == name) found = &each;
    }
    if (found == nullptr)
      refuse(statement, "name of a [[tool]] of the control profile" +
                            (names.empty() ? std::string(", which names none") : ": " + core::join(names)));
    number = found->number;
  } else {
    number = whole(statement);
  }
  next_tool_ = number > 0;
  block.tool = true;
  block.words.push_back(fmt::format("T{}", number));
}

void SiemensReader::letter(const SiemensStatement& statement, Block& block) {
  const char name = statement.name[0];
  if (const int axis = axis_of(statement.name); axis >= 0) {
    if (block.axes[axis]) refuse(statement, "each axis once in a block");
    block.axes[axis] = value(statement);
  } else if (name == 'I' || name == 'J' || name == 'K') {
    block.centre[name - 'I'] = value(statement);
  } else if (name == 'S') {
    const double speed = plain(statement);
    if (block.dwell) {  // revolutions
      if (speed_ <= 0) refuse(statement, "G4 S behind a spindle speed");
      block.words.push_back("P" + number_text(60.0 * speed / speed_));
    } else {
      speed_ = speed;
      block.words.push_back("S" + number_text(speed));
    }
  } else if (name == 'F') {
    if (block.dwell) {
      block.words.push_back("P" + number_text(plain(statement)));
    } else {
      block.feed = plain(statement);
      block.feed_at = block.words.size();
    }
  } else if (name != 'H') {
    refuse_unknown(statement);
  }
}

void SiemensReader::keyword(const SiemensStatement& statement, Block& block) {
  const std::string& name = statement.name;
  if (name == "SUPA") {
    block.machine = true;
  } else if (name == "CR") {
    block.words.push_back("R" + number_text(plain(statement)));
  } else if (name == "TURN") {
    block.words.push_back(fmt::format("P{}", whole(statement) + 1));
  } else if (name == "ADIS") {
    adis_ = plain(statement);
    block.path_mode = block.path_mode || path_ == 641;
  } else if (name == "TRAORI") {
    if (statement.called && core::trimmed(statement.arguments) != "1" && !core::trimmed(statement.arguments).empty())
      refuse(statement, "TRAORI or TRAORI(1)");
    block.tcp = tcp_on_marker;
    places_.forget();
  } else if (name == "TRAFOOF") {
    block.tcp = tcp_off_marker;
    places_.forget();
  } else if (name == "FGROUP") {
    std::string axes = core::upper(statement.arguments);
    axes.erase(std::remove_if(axes.begin(), axes.end(), [](char c) { return c == ' ' || c == ','; }), axes.end());
    std::sort(axes.begin(), axes.end());
    if (!axes.empty() && axes != "XYZ") refuse(statement, "FGROUP() or FGROUP(X, Y, Z): F counts along these axes");
  } else if (name == "RET") {
    block.words.emplace_back("M2");
  } else if (!is_skipped_keyword(name)) {
    refuse_unknown(statement);
  }
}

std::string SiemensReader::frame(const std::vector<SiemensStatement>& statements) {
  const SiemensStatement& first = statements.front();
  const bool moves = first.name == "TRANS" || first.name == "ATRANS";
  if (!moves && statements.size() > 1)
    refuse(first, "TRANS, ATRANS, or " + first.name + " alone, which ends all frames");
  // Without coordinates each of them ends all programmed frames.
  if (first.name != "ATRANS" || statements.size() == 1) places_.end_shift();
  for (std::size_t i = 1; i < statements.size(); ++i) {
    const int axis = axis_of(statements[i].name);
    if (axis < 0) refuse(statements[i], "coordinates alone behind " + first.name);
    places_.add_shift(axis, plain(statements[i]));
  }
  places_.forget();
  std::string text = "G52";
  for (int i = 0; i < 9; ++i)
    if ((mask_ >> i & 1) != 0) text += fmt::format(" {}{}", letters[i], number_text(places_.shift(i)));
  return text;
}

std::string SiemensReader::written(Block& block) {
  std::string text;
  const auto add = [&text](const std::string& word) { text += (text.empty() ? "" : " ") + word; };
  if (!block.tcp.empty()) add(marker_comment(block.tcp));
  if (exact_stop_once_ && block.path_mode) {
    add("G61.1");
  } else if (block.path_mode || exact_stop_once_) {
    add(path_mode());
    exact_stop_once_ = false;
  }
  add_feed(block);
  for (const std::string& word : block.words) add(word);
  add_tool_length(block, text);
  add_centre(block, text);
  places_.write(block.axes, block.machine, edge_ && tool_in_, place_, text);
  if (!text.empty() && text.front() == ' ') text.erase(0, 1);
  return text;
}

void SiemensReader::add_tool_length(const Block& block, std::string& text) {
  if (block.tool_change) tool_in_ = next_tool_;
  const bool waits = block.tool && !block.tool_change;  // the edge holds from the change on
  if (!block.tool_change && (!block.edge || waits)) return;
  text += text.empty() ? "" : " ";
  text += edge_ && tool_in_ ? "G43" : "G49";
  places_.forget();
}

void SiemensReader::add_centre(const Block& block, std::string& text) {
  int absolute = 0, all = 0;
  for (const auto& each : block.centre) {
    all += each ? 1 : 0;
    absolute += each && each->sense == SiemensSense::absolute ? 1 : 0;
  }
  if (all == 0) return;
  if (absolute != 0 && absolute != all)
    throw InputError(place_, "a centre with I, J, K of both senses", "all of them with AC(), or none");
  if ((absolute != 0) != centre_absolute_) {
    centre_absolute_ = absolute != 0;
    text += centre_absolute_ ? " G90.1" : " G91.1";
  }
  for (int i = 0; i < 3; ++i)
    if (block.centre[i]) text += fmt::format(" {}{}", "IJK"[i], number_text(block.centre[i]->number));
}

SiemensValue SiemensReader::value(const SiemensStatement& statement) const {
  if (statement.value.empty()) refuse(statement, "a number behind " + statement.name);
  return siemens_value(statement.value, parameters_, place_);
}

double SiemensReader::plain(const SiemensStatement& statement) const {
  const SiemensValue read = value(statement);
  if (read.sense != SiemensSense::modal) refuse(statement, "a number without AC, IC, DC, ACP, ACN");
  return read.number;
}

long SiemensReader::whole(const SiemensStatement& statement) const {
  const double number = plain(statement);
  if (number < 0 || number > 99999 || number != std::floor(number)) refuse(statement, "a whole number from 0 to 99999");
  return std::lround(number);
}

void SiemensReader::refuse(const SiemensStatement& statement, const std::string& allowed) const {
  throw InputError(place_, "'" + statement.text() + "'", allowed);
}

void SiemensReader::refuse_unknown(const SiemensStatement& statement) const {
  const std::string word =
      statement.name == "G" || statement.name == "M" ? statement.name + statement.value : statement.name;
  if (is_control_statement(word))
    refuse(statement,
           "programs without jumps, loops, branches, subprograms and definitions; write out the lines that run");
  refuse(statement,
         fmt::format("motion, TRANS, TRAORI; a [[word]] '{}' of the control profile that skips or replaces it", word));
}

}  // namespace thermotwin::nc
