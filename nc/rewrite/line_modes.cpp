// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/rewrite/line_modes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "core/error.h"

namespace thermotwin::nc {
namespace {

bool is_one_of(int code, std::initializer_list<int> codes) {
  return std::find(codes.begin(), codes.end(), code) != codes.end();
}

}  // namespace

void refuse_path(const std::string& place, const std::string& value, const std::string& allowed) {
  throw core::InputError(place, value + " with --rewrite path", allowed);
}

void LineModes::read(const ProgramLine& line, const std::vector<WordRule>& rules, const std::string& place) {
  machine = false;
  coordinates = true;
  for (const Word& word : line.words) {
    const auto rule = std::find_if(rules.begin(), rules.end(), [&](const WordRule& one) {
      return one.letter == word.letter && !word.expression && std::abs(one.number - word.value) < 1e-6;
    });
    if (rule == rules.end()) {
      take(word, line, place);
      continue;
    }
    if (rule->with.find_first_of("XYZABCUVW") != std::string::npos) coordinates = false;
    for (const Word& instead : ProgramLine::parse(rule->by, "").words) take(instead, line, place);
  }
}

void LineModes::take(const Word& word, const ProgramLine& line, const std::string& place) {
  if (word.letter != 'G') return;
  if (word.expression) refuse_path(place, "a G word with an expression", "G and a number");
  const int code = static_cast<int>(std::lround(10.0 * word.value));
  if (is_one_of(code, {900, 910})) absolute = code == 900;
  if (is_one_of(code, {901, 911})) arc_absolute = code == 901;
  if (is_one_of(code, {930, 940, 950})) inverse_time = code == 930;
  if (is_one_of(code, {0, 10, 20, 30, 800})) cycle = false;
  if (is_one_of(code, {730, 810, 820, 830, 850, 890})) cycle = true;
  if (is_one_of(code, {280, 300, 530})) machine = true;
  if (is_one_of(code, {100, 431, 520})) coordinates = false;
  // X of a dwell is its time, unless it has P.
  if (code == 40 && line.find('P') == nullptr) coordinates = false;
  if (code == 432 && line.find('H') == nullptr) coordinates = false;
  if (is_one_of(code, {410, 411, 420, 421})) refuse_path(place, "cutter radius compensation", "G40");
  if (code == 920) refuse_path(place, "G92", "work offsets G54 to G59.3");
  if (is_one_of(code, {330, 331, 50, 51, 52, 700, 710, 720, 740, 760, 840, 860, 870, 880}))
    refuse_path(place, fmt::format("G{}", word.value), "lines, arcs and the cycles G73, G81, G82, G83, G85, G89");
  if (code == 100 && (line.has('L', 20) || line.has('L', 10) || line.has('L', 11)))
    refuse_path(place, "G10 that measures by the present position", "G10 L1 or L2");
}

}  // namespace thermotwin::nc
