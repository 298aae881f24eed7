// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/control/control_profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <set>
#include <sstream>

#include "core/character.h"
#include "core/config.h"
#include "core/error.h"
#include "core/file.h"
#include "core/text.h"
#include "core/unique_id.h"
#include "core/units.h"
#include "nc/control/built_in.h"
#include "nc/control/control_keys.h"

namespace thermotwin::nc {

using core::InputError;
using core::Node;
namespace units = core::units;

namespace {

/// MSG, CYCLE832, SPOS: a statement with a name.
bool is_statement(const std::string& word) {
  const auto letter = [](unsigned char c) { return std::isalpha(c) != 0 || c == '_'; };
  return word.size() > 1 && letter(word[0]) && letter(word[1]) &&
         std::all_of(word.begin(), word.end(), [&](unsigned char c) { return letter(c) || std::isdigit(c) != 0; });
}

void read_word_name(const Node& node, Dialect dialect, WordRule& rule) {
  const std::string word = node.text("word");
  if (dialect == Dialect::siemens && is_statement(word)) {
    rule.name = core::upper(word);
    return;
  }
  const auto bad = [&] {
    return InputError(node.place("word"), "'" + word + "'",
                      dialect == Dialect::siemens ? "a letter and a number such as M21, or a name such as CYCLE832"
                                                  : "a letter and a number such as G43.4 or M428");
  };
  if (word.size() < 2 || !core::is_letter(word[0])) throw bad();
  rule.letter = core::upper(word[0]);
  const auto read = std::from_chars(word.data() + 1, word.data() + word.size(), rule.number);
  if (read.ec != std::errc() || read.ptr != word.data() + word.size() || !(rule.number >= 0 && rule.number < 1e5))
    throw bad();
}

WordRule read_word(const Node& node, Dialect dialect) {
  WordRule rule;
  read_word_name(node, dialect, rule);
  const std::string action = node.choice("action");
  rule.action = action == "skip"      ? WordRule::Action::skip
                : action == "replace" ? WordRule::Action::replace
                : action == "tcp_on"  ? WordRule::Action::tcp_on
                : action == "tcp_off" ? WordRule::Action::tcp_off
                                      : WordRule::Action::refuse;
  rule.by = node.text_or("by", "");
  rule.with = core::upper(node.text_or("with", ""));
  if (!std::all_of(rule.with.begin(), rule.with.end(), [](unsigned char c) { return std::isalpha(c) != 0; }))
    throw InputError(node.place("with"), "'" + rule.with + "'", "letters of words such as QR");
  rule.says = node.text_or("says", "");
  for (const std::string& text : {rule.by, rule.with, rule.says})
    if (text.find_first_of("()\n\r;") != std::string::npos)
      throw InputError(node.place(), "'" + text + "'", "text without brackets, semicolons and line ends");
  if (rule.action == WordRule::Action::skip && !rule.by.empty())
    throw InputError(node.place("by"), "'" + rule.by + "' with action = \"skip\"", "action = \"replace\", or no by");
  if (rule.action == WordRule::Action::replace && rule.by.empty())
    throw InputError(node.place("action"), "replace without by", "by = \"...\", or action = \"skip\"");
  node.finish();
  return rule;
}

void read_axes(const Node& root, const mesh::Machine& machine, ControlProfile& profile) {
  const double linear = root.number("acceleration_m_s2"), rotary = root.number("acceleration_deg_s2") * units::deg;
  for (const mesh::Axis& axis : machine.axes) {
    const bool is_linear = axis.kind == mesh::AxisKind::linear;
    // A rapid of 0 is none stated: a machining centre's usual one.
    const double rapid = axis.rapid > 0 ? axis.rapid : is_linear ? 0.5 : 60.0 * units::deg;
    profile.axes.push_back({rapid, is_linear ? linear : rotary});
  }
  std::vector<std::string> seen;
  for (const Node& node : root.tables("axis")) {
    const std::string id = node.text("id");
    core::require_unique_id(id, node.place("id"), seen);
    const int index = machine.axis_index(id);
    if (index < 0) {
      std::vector<std::string> ids;
      for (const mesh::Axis& axis : machine.axes) ids.push_back(axis.id);
      throw InputError(node.place("id"), "unknown axis '" + id + "'", "one of: " + core::join(ids));
    }
    const bool is_linear = machine.axes[index].kind == mesh::AxisKind::linear;
    AxisLimits& limits = profile.axes[index];
    if (is_linear) {
      limits.acceleration = node.number_or("acceleration_m_s2", limits.acceleration);
      limits.speed = node.number_or("rapid_mm_min", limits.speed / units::mm_min) * units::mm_min;
    } else {
      limits.acceleration = node.number_or("acceleration_deg_s2", limits.acceleration / units::deg) * units::deg;
      limits.speed = node.number_or("rapid_deg_min", limits.speed / units::deg_min) * units::deg_min;
    }
    node.finish();
  }
}

WorkOffset read_work_offset(const Node& node, const mesh::Machine& machine) {
  WorkOffset offset;
  offset.number = node.integer("number", 1, 9);
  for (const mesh::Axis& axis : machine.axes) {
    const int letter = letter_of(axis);
    if (letter < 0) continue;
    const bool linear = axis.kind == mesh::AxisKind::linear;
    offset.offset[letter] =
        node.number_or(axis.id + (linear ? "_mm" : "_deg"), 0.0) * (linear ? units::mm : units::deg);
  }
  offset.rotation = node.number_or("rotation_deg", 0.0) * units::deg;
  node.finish();
  return offset;
}

ControlProfile read_profile(const core::Config& config, const std::string& fallback, const mesh::Machine& machine) {
  const Node root = config.root();
  root.schema(1);
  ControlProfile profile;
  profile.name = root.text_or("name", fallback);
  const std::string dialect = root.choice_or("dialect", "rs274");
  profile.dialect = dialect == "siemens" ? Dialect::siemens : dialect == "fanuc" ? Dialect::fanuc : Dialect::rs274;
  profile.block_delete = root.boolean_or("block_delete", true);
  profile.arc_radius_tolerance = root.number("arc_radius_tolerance_mm") * units::mm;
  profile.blend_tolerance = root.number("blend_tolerance_mm") * units::mm;
  profile.block_cycle = root.number("block_cycle_s");
  profile.overlaps_corners = root.boolean_or("overlaps_corners", false);
  profile.look_ahead = root.integer_or("look_ahead", 500, 1, 100000);
  profile.tool_change = root.number("tool_change_s");
  profile.program_stop = root.number("program_stop_s");
  profile.spindle_start = root.number("spindle_start_s");
  for (const Node& word : root.tables("word")) {
    WordRule rule = read_word(word, profile.dialect);
    for (const WordRule& own : profile.words) {
      if (own.name == rule.name && own.letter == rule.letter && own.number == rule.number)
        throw InputError(word.place("word"), "'" + word.text("word") + "' a second time", "each word once");
    }
    profile.words.push_back(std::move(rule));
  }
  read_axes(root, machine, profile);
  std::set<int> numbers;
  for (const Node& node : root.tables("tool")) {
    Tool tool;
    tool.number = node.integer("number", 1, 99999);
    tool.name = node.text_or("name", "");
    if (!numbers.insert(tool.number).second)
      throw InputError(node.place("number"), fmt::format("tool {} twice", tool.number), "each tool once");
    tool.offset[2] = node.number("length_mm") * units::mm;
    tool.diameter = node.number("diameter_mm") * units::mm;
    node.finish();
    profile.tools.push_back(tool);
  }
  numbers.clear();
  for (const Node& node : root.tables("work_offset")) {
    profile.work_offsets.push_back(read_work_offset(node, machine));
    if (const int number = profile.work_offsets.back().number; !numbers.insert(number).second)
      throw InputError(node.place("number"), fmt::format("work offset {} twice", number), "each work offset once");
  }
  if (const auto limits = root.table_if("limits")) {
    const double moves = limits->number_or("moves", 0.0);
    profile.moves_stated = moves > 0.0;
    profile.moves = profile.moves_stated ? moves : 2e7;
    profile.lines_without_move = limits->number("lines_without_move");
    profile.seconds = limits->number("seconds");
    limits->finish();
  } else {
    profile.moves = 2e7;
    profile.lines_without_move = 1e6;
    profile.seconds = 600;
  }
  root.finish();
  return profile;
}

}  // namespace

std::string built_in_profile(const std::string& name) {
  if (name == "linuxcnc") return linuxcnc_profile;
  if (name == "fanuc") return fanuc_profile;
  if (name == "siemens") return siemens_profile;
  return "";
}

void ControlProfile::use_table(std::vector<Tool> table) {
  for (Tool& tool : table)
    for (const Tool& named : tools)
      if (named.number == tool.number) tool.name = named.name;
  tools = std::move(table);
}

ControlProfile ControlProfile::parse(const std::string& text, const std::string& source, const mesh::Machine& machine) {
  return read_profile(core::Config::parse(text, source, &control_keys()), source, machine);
}

ControlProfile ControlProfile::load(const std::string& name, const mesh::Machine& machine) {
  if (const std::string text = built_in_profile(name); !text.empty()) return parse(text, name, machine);
  if (!std::filesystem::exists(name))
    throw InputError("--control", "'" + name + "'", "linuxcnc, fanuc, siemens or the file of a control profile");
  return read_profile(core::Config::load(name, &control_keys()), std::filesystem::path(name).stem().string(), machine);
}

std::vector<Tool> read_tool_table(const std::filesystem::path& path) {
  std::istringstream lines(core::read_file(path));
  std::vector<Tool> tools;
  std::set<int> numbers;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const std::string place = path.string() + ":" + std::to_string(number);
    if (!line.empty() && line.back() == '\r') line.pop_back();
    std::istringstream words(line.substr(0, line.find(';')));
    Tool tool;
    bool any = false;
    for (std::string word; words >> word;) {
      const auto letter = core::upper(word[0]);
      double value = 0;
      const char* from = word.data() + 1 + (word.size() > 1 && word[1] == '+' ? 1 : 0);
      const auto read = std::from_chars(from, word.data() + word.size(), value);
      if (read.ec != std::errc() || read.ptr != word.data() + word.size() || !std::isfinite(value) ||
          std::abs(value) > 1e6)
        throw InputError(place, "'" + word + "'", "words such as T1 P1 Z12.5 D6, then ;comment");
      if ((letter == 'T' || letter == 'Q') && value != std::floor(value))
        throw InputError(place, "'" + word + "'", "a whole number for T and Q");
      any = true;
      const auto axis = std::find(letters.begin(), letters.end(), letter);
      if (letter == 'T') {
        tool.number = static_cast<int>(value);
      } else if (axis != letters.end()) {
        const int i = static_cast<int>(axis - letters.begin());
        tool.offset[i] = value * (is_angle(i) ? units::deg : units::mm);
      } else if (letter == 'D') {
        tool.diameter = value * units::mm;
      } else if (letter == 'I') {
        tool.front_angle = value;
      } else if (letter == 'J') {
        tool.back_angle = value;
      } else if (letter == 'Q') {
        tool.orientation = static_cast<int>(value);
      } else if (letter != 'P') {
        throw InputError(place, "'" + word + "'", "the letters T P X Y Z A B C U V W D I J Q");
      }
    }
    if (!any) continue;
    if (tool.number < 1) throw InputError(place, "no tool number", "T and a number from 1");
    if (!numbers.insert(tool.number).second)
      throw InputError(place, fmt::format("tool {} twice", tool.number), "each tool once");
    tools.push_back(tool);
  }
  return tools;
}

int letter_of(const mesh::Axis& axis) {
  if (axis.id.size() != 1) return -1;
  const auto found = std::find(letters.begin(), letters.end(), axis.id[0]);
  if (found == letters.end()) return -1;
  const int letter = static_cast<int>(found - letters.begin());
  return is_angle(letter) == (axis.kind == mesh::AxisKind::rotary) ? letter : -1;
}

}  // namespace thermotwin::nc
