// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/linuxcnc/hal_config.h"

#include <fmt/format.h>

#include <charconv>
#include <set>
#include <sstream>

#include "core/character.h"
#include "core/error.h"
#include "core/file.h"
#include "core/text.h"

namespace thermotwin::compensation {
namespace {

namespace fs = std::filesystem;

struct Entry {
  std::string value;
  int line;
};
using Section = std::multimap<std::string, Entry>;

struct Ini {
  fs::path path;
  std::map<std::string, Section> sections;

  const Entry* find(const std::string& section, const std::string& key) const {
    const auto in = sections.find(section);
    if (in == sections.end()) return nullptr;
    const auto at = in->second.lower_bound(key);
    return at != in->second.end() && at->first == key ? &at->second : nullptr;
  }
  std::string text(const std::string& section, const std::string& key) const {
    const Entry* entry = find(section, key);
    return entry == nullptr ? std::string() : entry->value;
  }
  std::string place(const std::string& section, const std::string& key) const {
    const Entry* entry = find(section, key);
    return fmt::format("{}{} [{}]{}", path.string(), entry == nullptr ? "" : fmt::format(":{}", entry->line), section,
                       key);
  }
  /// @return the number, or `otherwise` where the key is absent
  double number(const std::string& section, const std::string& key, double otherwise) const {
    const Entry* entry = find(section, key);
    if (entry == nullptr) return otherwise;
    double value = 0;
    const char *begin = entry->value.data(), *end = begin + entry->value.size();
    const auto read = std::from_chars(begin, end, value);
    if (read.ec != std::errc() || read.ptr != end)
      throw core::InputError(place(section, key), "'" + entry->value + "'", "a number");
    return value;
  }
};

Ini read_ini(const fs::path& path) {
  Ini ini{path, {}};
  std::istringstream lines(core::read_file(path));
  std::string line, section;
  for (int number = 1; std::getline(lines, line); ++number) {
    const std::string_view text = core::trimmed(line);
    if (text.empty() || text[0] == '#' || text[0] == ';') continue;
    if (text[0] == '[') {
      const std::size_t end = text.find(']');
      if (end == std::string_view::npos)
        throw core::InputError(fmt::format("{}:{}", path.string(), number), std::string(text), "[SECTION]");
      section = text.substr(1, end - 1);
      continue;
    }
    const std::size_t equals = text.find('=');
    if (equals == std::string_view::npos)
      throw core::InputError(fmt::format("{}:{}", path.string(), number), std::string(text), "KEY = VALUE");
    const std::string key(core::trimmed(text.substr(0, equals)));
    ini.sections[section].emplace(key, Entry{std::string(core::trimmed(text.substr(equals + 1))), number});
  }
  return ini;
}

/// [SECTION]KEY and [SECTION](KEY) in a word of a HAL file, as halcmd replaces them.
std::string replaced(std::string word, const Ini& ini) {
  for (std::size_t open = word.find('['); open != std::string::npos; open = word.find('[', open + 1)) {
    const std::size_t close = word.find(']', open);
    if (close == std::string::npos) break;
    std::size_t from = close + 1, end = from;
    const bool bracketed = from < word.size() && word[from] == '(';
    if (bracketed) end = word.find(')', ++from);
    while (!bracketed && end < word.size() && (core::is_letter_or_digit(word[end]) || word[end] == '_')) ++end;
    if (end == std::string::npos) break;
    const Entry* entry = ini.find(word.substr(open + 1, close - open - 1), word.substr(from, end - from));
    if (entry != nullptr) word.replace(open, end + (bracketed ? 1 : 0) - open, entry->value);
  }
  return word;
}

std::vector<std::string> words_of(const std::string& line, const Ini& ini) {
  std::istringstream text(line.substr(0, line.find('#')));
  std::vector<std::string> words;
  for (std::string word; text >> word;) {
    if (word != "=>" && word != "<=" && word != "<=>") words.push_back(replaced(word, ini));
  }
  return words;
}

void add_component_names(const std::vector<std::string>& words, HalConfig& config) {
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (words[i].starts_with("names=")) {
      std::istringstream names(words[i].substr(6));
      for (std::string name; std::getline(names, name, ',');) config.components.push_back(name);
    }
    if (words[0] == "loadusr" && words[i].starts_with("-W") && words[i].ends_with("n") && i + 1 < words.size())
      config.components.push_back(words[i + 1]);
  }
}

void read_hal_line(const std::vector<std::string>& words, const std::string& place, HalConfig& config) {
  const auto link = [&](const std::string& pin, const std::string& signal) {
    config.signal_of_pin.emplace(pin, signal);
    config.place_of_pin.emplace(pin, place);
  };
  const std::string& command = words[0];
  if (command == "net") {
    for (std::size_t i = 2; i < words.size(); ++i) link(words[i], words[1]);
  } else if ((command == "linkps" || command == "linkpp") && words.size() > 2) {
    link(words[1], words[2]);
  } else if (command == "linksp" && words.size() > 2) {
    link(words[2], words[1]);
  } else if (command == "addf" && words.size() > 2 && words[1] == "motion-controller") {
    config.thread = words[2];
  } else if (command == "loadrt" || command == "loadusr") {
    add_component_names(words, config);
  }
}

void read_hal_file(const fs::path& path, const Ini& ini, HalConfig& config) {
  std::istringstream lines(core::read_file(path));
  std::string line, whole;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (!line.empty() && line.back() == '\\') {  // goes on in the next line
      whole += line.substr(0, line.size() - 1) + " ";
      continue;
    }
    const std::vector<std::string> words = words_of(whole + line, ini);
    whole.clear();
    if (!words.empty()) read_hal_line(words, fmt::format("{}:{}", path.string(), number), config);
  }
}

void read_hal_files(const Ini& ini, const fs::path& library, HalConfig& config) {
  const auto section = ini.sections.find("HAL");
  if (section == ini.sections.end()) return;
  for (const auto& [key, entry] : section->second) {
    if (key != "HALFILE" && key != "POSTGUI_HALFILE") continue;
    std::string name;
    std::istringstream(entry.value) >> name;
    const bool of_library = name.starts_with("LIB:");
    const fs::path in_folder = ini.path.parent_path() / name;
    const fs::path path = of_library ? library / name.substr(4) : fs::exists(in_folder) ? in_folder : library / name;
    if (path.extension() == ".tcl")
      config.unread.push_back(name + ": Tcl is not read");
    else if (!fs::exists(path))
      config.unread.push_back(name + ": not found");
    else
      read_hal_file(path, ini, config);
  }
}

/// "coordinates=XYZBC" of the kinematics, else [TRAJ]COORDINATES; joints are numbered in this order.
std::string coordinates_of(const Ini& ini) {
  const std::string kinematics = ini.text("KINS", "KINEMATICS");
  const std::size_t at = kinematics.find("coordinates=");
  std::string letters, raw = at == std::string::npos ? ini.text("TRAJ", "COORDINATES")
                                                     : kinematics.substr(at + 12, kinematics.find(' ', at) - at - 12);
  for (const char letter : core::upper(raw)) {
    if (letter == ' ' || letter == ',' || letter == '"') continue;
    if (std::string("XYZABCUVW").find(letter) == std::string::npos)
      throw core::InputError(
          ini.place(at == std::string::npos ? "TRAJ" : "KINS", at == std::string::npos ? "COORDINATES" : "KINEMATICS"),
          "'" + raw + "'", "letters of XYZABCUVW");
    letters += letter;
  }
  return letters;
}

double mm_per_unit(const Ini& ini) {
  const std::string unit = ini.text("TRAJ", "LINEAR_UNITS");
  if (unit == "mm" || unit == "metric") return 1.0;
  if (unit == "inch" || unit == "in" || unit == "imperial") return 25.4;
  throw core::InputError(ini.place("TRAJ", "LINEAR_UNITS"), unit.empty() ? "absent" : "'" + unit + "'",
                         "mm, metric, inch, in or imperial");
}

}  // namespace

const HalAxis* HalConfig::axis(char letter) const {
  for (const HalAxis& one : axes) {
    if (one.letter == letter) return &one;
  }
  return nullptr;
}

HalConfig read_hal_config(const fs::path& path, const fs::path& library) {
  const Ini ini = read_ini(path);
  HalConfig config;
  config.ini = path;
  std::istringstream(ini.text("KINS", "KINEMATICS")) >> config.kinematics;
  if (config.kinematics.empty())
    throw core::InputError(path.string() + " [KINS]KINEMATICS", "absent", "an INI file of LinuxCNC 2.9");
  config.mm_per_unit = mm_per_unit(ini);
  int joint = 0;
  std::set<char> seen;
  for (const char letter : coordinates_of(ini)) {
    const std::string section = fmt::format("AXIS_{}", letter);
    // A letter that occurs twice is a gantry; its first joint tells the position.
    if (seen.insert(letter).second)
      config.axes.push_back(
          {letter, joint, ini.number(section, "MAX_VELOCITY", 0.0), ini.number(section, "OFFSET_AV_RATIO", 0.0) > 0.0});
    ++joint;
  }
  read_hal_files(ini, library, config);
  return config;
}

}  // namespace thermotwin::compensation
