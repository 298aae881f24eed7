// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/key_reference.h"

#include <fmt/format.h>

#include <set>

#include "core/text.h"

namespace thermotwin::core {

namespace {

std::string value_of(const Key& key) {
  std::string text = phrase(key.kind);
  if (key.kind == KeyKind::reference)
    text = key.words.front() == "channel" ? "a channel" : "id of " + key.words.front();
  if (key.kind == KeyKind::table || key.kind == KeyKind::tables) {
    const std::string& name = key.keys->name;
    const std::string brackets = key.kind == KeyKind::table ? "[{0}]" : "[[{0}]]";
    text = fmt::format(fmt::runtime("`" + brackets + "`"), name);
  }
  if (key.list) text += ", or several";
  if (!key.unit.empty() && key.unit != "1") text += ", " + key.unit;
  return text;
}

std::string absent(const Key& key) {
  struct Words {
    std::string operator()(const Required&) const { return "**required**"; }
    std::string operator()(const Absent& state) const { return state.says; }
    std::string operator()(double number) const { return fmt::format("{:g}", number); }
    std::string operator()(bool flag) const { return flag ? "true" : "false"; }
    std::string operator()(const std::string& text) const { return text.empty() ? "" : "\"" + text + "\""; }
  };
  return std::visit(Words(), key.otherwise);
}

std::string allowed(const Key& key) {
  if (key.kind == KeyKind::word) {
    std::vector<std::string> words;
    for (const std::string& word : key.words) words.push_back("`" + word + "`");
    return join(words);
  }
  const bool below = key.range.low > any_number.low, above = key.range.high < any_number.high;
  if (key.name == "schema") return "1";
  if (below && above) return fmt::format("{:g} to {:g}", key.range.low, key.range.high);
  if (key.range.low == positive.low) return "above 0";
  if (below) return fmt::format("{:g} or more", key.range.low);
  if (above) return fmt::format("{:g} or less", key.range.high);
  return "";
}

void write(const KeyTable& table, bool file, std::set<const KeyTable*>& written, std::string& text) {
  if (!written.insert(&table).second) return;
  text += file ? fmt::format("# {}\n\n{}\n", table.name, table.says)
               : fmt::format("\n## {}\n\n{}\n", table.name, table.says);
  text += "\n| key | value | absent | allowed | meaning |\n|---|---|---|---|---|\n";
  for (const Key& key : table.keys) {
    text += fmt::format("| `{}` | {} | {} | {} | {} |\n", key.name, value_of(key), absent(key), allowed(key), key.says);
  }
  for (const Key& key : table.keys)
    if (key.keys != nullptr) write(*key.keys, false, written, text);
}

}  // namespace

std::string key_reference(const KeyTable& file) {
  std::string text;
  std::set<const KeyTable*> written;
  write(file, true, written, text);
  return text;
}

}  // namespace thermotwin::core
