// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cases/help.h"

#include <map>
#include <sstream>

#include "tests/cases/program.h"

namespace thermotwin::cases {

namespace {

/// First words of the entries below headings; a continued description is indented further.
std::vector<std::string> entries(const std::string& help, bool options) {
  std::istringstream lines(help);
  std::vector<std::string> found;
  bool footer = false;
  for (std::string line; std::getline(lines, line);) {
    footer = footer || line.starts_with("Exit status:") || line.starts_with("Example:");
    if (footer || line.size() < 3 || !line.starts_with("  ") || line[2] == ' ') continue;
    if ((line[2] == '-') != options) continue;
    std::string word;
    std::istringstream(line) >> word;
    found.push_back(word);
  }
  return found;
}

}  // namespace

std::vector<std::string> verbs() { return entries(thermotwin({"--help"}).out, false); }

namespace {

std::set<std::string> options_in(const std::string& help) {
  std::set<std::string> options;
  for (const std::string& names : entries(help, true)) {
    std::istringstream list(names);
    for (std::string name; std::getline(list, name, ',');) options.insert(name);
  }
  return options;
}

}  // namespace

std::set<std::string> options_of(const std::string& verb) {
  static std::map<std::string, std::set<std::string>> known;
  if (const auto at = known.find(verb); at != known.end()) return at->second;
  const Result help = thermotwin({verb, "--help"});
  if (help.status != 0) return known[verb];
  std::set<std::string> options = options_in(help.out);
  for (const std::string& word : entries(help.out, false)) {  // arguments are in capitals, verbs of a group are not
    if (word.find_first_not_of("abcdefghijklmnopqrstuvwxyz") != std::string::npos) continue;
    options.merge(options_in(thermotwin({verb, word, "--help"}).out));
  }
  return known[verb] = options;
}

}  // namespace thermotwin::cases
