// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/causes/machine_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <vector>

#include "core/character.h"
#include "core/error.h"
#include "core/text.h"

namespace thermotwin::diagnosis {

namespace {

/// A header or a `key = value`; offsets into the text.
struct Statement {
  bool header = false;
  std::string name;
  std::size_t line = 0;            ///< first character of its line
  std::size_t begin = 0, end = 0;  ///< of the value
};

/// First character behind the string that begins at `at`.
std::size_t skip_string(const std::string& text, std::size_t at) {
  const char quote = text[at];
  const std::string triple(3, quote);
  const bool long_form = text.compare(at, 3, triple) == 0;
  for (at += long_form ? 3 : 1; at < text.size(); ++at) {
    if (quote == '"' && text[at] == '\\') {
      ++at;
    } else if (long_form ? text.compare(at, 3, triple) == 0 : text[at] == quote) {
      at += long_form ? 3 : 1;
      // Up to two quotes may stand before the closing three.
      while (long_form && at < text.size() && text[at] == quote) ++at;
      return at;
    }
  }
  return text.size();
}

std::size_t line_end(const std::string& text, std::size_t at) { return std::min(text.find('\n', at), text.size()); }

/// End of the value that begins at `at`: arrays and inline tables may run over lines.
std::size_t value_end(const std::string& text, std::size_t at) {
  int depth = 0;
  while (at < text.size()) {
    const char c = text[at];
    if (c == '"' || c == '\'') {
      at = skip_string(text, at);
      continue;
    }
    if (c == '#') {
      if (depth == 0) break;
      at = line_end(text, at);
      continue;
    }
    if (c == '[' || c == '{') ++depth;
    if (c == ']' || c == '}') --depth;
    if (c == '\n' && depth <= 0) break;
    ++at;
  }
  return at;
}

std::vector<Statement> outline(const std::string& text) {
  std::vector<Statement> statements;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t line = at;
    at = text.find_first_not_of(" \t", at);
    if (at == std::string::npos) break;
    if (text[at] == '\n' || text[at] == '#' || text[at] == '\r') {
      at = line_end(text, at) + 1;
      continue;
    }
    Statement statement;
    statement.line = line;
    if (text[at] == '[') {
      statement.header = true;
      const std::size_t stop = std::min(text.find(']', at), text.size());
      const bool array = text.compare(at, 2, "[[") == 0;
      statement.name = core::trimmed(std::string_view(text).substr(at, stop - at).substr(array ? 2 : 1));
      at = stop;
    } else {
      const std::size_t equals = text.find('=', at);
      if (equals == std::string::npos) break;
      statement.name = core::trimmed(std::string_view(text).substr(at, equals - at));
      statement.begin = std::min(text.find_first_not_of(" \t", equals + 1), text.size());
      at = value_end(text, statement.begin);
      statement.end = at;
      while (statement.end > statement.begin &&
             std::string_view(" \t\r").find(text[statement.end - 1]) != std::string_view::npos)
        --statement.end;
    }
    statements.push_back(statement);
    at = line_end(text, at) + 1;
  }
  return statements;
}

/// The statements of one table: [first, last) without its header.
struct Section {
  std::size_t first = 0, last = 0;
};

const Statement* find_key(const std::vector<Statement>& all, const Section& section, const std::string& key) {
  for (std::size_t i = section.first; i < section.last; ++i)
    if (all[i].name == key) return &all[i];
  return nullptr;
}

/// The table with that id among the headers in [from, to). @param number  of tables with the same id, from 0
bool find_table(const std::string& text, const std::vector<Statement>& all, const std::string& table,
                const std::string& id, std::size_t from, std::size_t to, Section& section,
                const std::string& id_key = "id", int number = 0) {
  for (std::size_t i = from; i < to; ++i) {
    if (!all[i].header || all[i].name != table) continue;
    section.first = i + 1;
    section.last = section.first;
    while (section.last < all.size() && !all[section.last].header) ++section.last;
    const Statement* key = find_key(all, section, id_key);
    if (!key || key->end - key->begin < 2) continue;
    if (text.compare(key->begin + 1, key->end - key->begin - 2, id) == 0 && number-- == 0) return true;
  }
  return false;
}

/// Offsets of the number inside a value: the value itself, or what `value =` says.
std::pair<std::size_t, std::size_t> number_span(const std::string& text, const Statement& statement) {
  if (text[statement.begin] != '{') return {statement.begin, statement.end};
  std::size_t at = statement.begin + 1;
  while (at < statement.end) {
    const std::size_t equals = text.find('=', at);
    if (equals >= statement.end) break;
    const std::size_t stop = std::min(text.find_first_of(",}", equals), statement.end);
    if (core::trimmed(std::string_view(text).substr(at, equals - at)) == "value") {
      std::size_t first = text.find_first_not_of(" \t", equals + 1), last = stop;
      while (last > first && (text[last - 1] == ' ' || text[last - 1] == '\t')) --last;
      return {first, last};
    }
    at = stop + 1;
  }
  return {statement.begin, statement.begin};
}

/// A TOML float or integer that reads back as the same double.
std::string written(double number) { return fmt::format("{}", number); }

}  // namespace

std::string changed_text(const std::string& text, const std::string& source, const MachineValue& place, double number,
                         const std::string& comment) {
  const std::vector<Statement> all = outline(text);
  const std::string what = "[[" + place.table + "]] with " + place.id_key + " = \"" + place.id + "\"";
  Section section;
  std::string line = comment;
  std::replace_if(
      line.begin(), line.end(), [](char c) { return core::byte_of(c) < 32; }, ' ');
  if (!find_table(text, all, place.table, place.id, 0, all.size(), section, place.id_key)) {
    if (!place.may_lack)
      throw core::InputError(source, "no " + what, "a table with this header and id, so that its key can be changed");
    return text + (text.ends_with('\n') ? "" : "\n") + "\n[[" + place.table + "]]\n" + place.id_key + " = " +
           core::toml_text(place.id) + "\n# " + line + "\n" + place.key + " = " + written(number) + "\n";
  }
  if (!place.part.empty()) {
    std::size_t to = section.last;
    while (to < all.size() && !(all[to].header && !all[to].name.starts_with(place.table + "."))) ++to;
    const std::string table = place.table + "." + place.part_table;
    if (!find_table(text, all, table, place.part, section.last, to, section, place.part_key, place.part_number)) {
      throw core::InputError(source, "no [[" + table + "]] '" + place.part + "' below " + what,
                             "a table with this header and " + place.part_key + ", so that its key can be changed");
    }
  }
  std::string changed = text;
  if (const Statement* key = find_key(all, section, place.key)) {
    const auto [first, last] = number_span(text, *key);
    if (first == last) {
      throw core::InputError(source + " " + what, place.key + " without a number",
                             "a number or {value = .., std_percent = ..}");
    }
    changed.replace(first, last - first, written(number));
    const std::string indent = text.substr(key->line, text.find_first_not_of(" \t", key->line) - key->line);
    changed.insert(key->line, indent + "# " + line + "\n");
    return changed;
  }
  const Statement* id = find_key(all, section, place.part.empty() ? place.id_key : place.part_key);
  std::size_t at = line_end(text, id->end);
  const std::string indent = text.substr(id->line, text.find_first_not_of(" \t", id->line) - id->line);
  std::string added = indent + "# " + line + "\n" + indent + place.key + " = " + written(number);
  if (at == text.size())
    added = "\n" + added;
  else
    ++at, added += "\n";
  return changed.insert(at, added);
}

std::string with_own_material(const std::string& text, const std::string& source, const std::string& material,
                              const std::string& copy, const std::string& body) {
  const auto find = [&](const std::string& in, const std::string& table, const std::string& id,
                        std::vector<Statement>& all) {
    all = outline(in);
    Section section;
    if (!find_table(in, all, table, id, 0, all.size(), section)) {
      throw core::InputError(source, "no [[" + table + "]] with id = \"" + id + "\"",
                             "a table with this header and id");
    }
    return section;
  };
  std::vector<Statement> all;
  std::string changed = text;
  Section section = find(changed, "body", body, all);
  const Statement* key = find_key(all, section, "material");
  if (!key) throw core::InputError(source, "body '" + body + "' without material", "a material");
  changed.replace(key->begin, key->end - key->begin, core::toml_text(copy));
  section = find(changed, "material", material, all);
  const std::size_t from = all[section.first - 1].line;
  const std::size_t last = std::min(line_end(changed, all[section.last - 1].end) + 1, changed.size());
  std::string added = changed.substr(from, last - from);
  const Statement* id = find_key(all, section, "id");
  added.replace(id->begin - from, id->end - id->begin, core::toml_text(copy));
  return changed.insert(last, (changed[last - 1] == '\n' ? "" : "\n") + added);
}

MovableText movable_text(const std::string& text, const mesh::Machine& machine) {
  MovableText movable{text, {}};
  const auto name_of = [&](const std::filesystem::path& file) {
    std::string name = file.filename().string();
    for (int number = 2;; ++number) {
      const auto known = std::find_if(movable.files.begin(), movable.files.end(), [&](const auto& copy) {
        return copy.second == std::filesystem::path("cad") / name;
      });
      if (known == movable.files.end() || known->first == file) return name;
      name = file.stem().string() + "_" + std::to_string(number) + file.extension().string();
    }
  };
  for (const mesh::BodySpec& body : machine.bodies) {
    std::error_code error;
    const std::filesystem::path file = std::filesystem::absolute(body.cad, error).lexically_normal();
    if (error || !std::filesystem::is_regular_file(file, error)) continue;
    const std::vector<Statement> all = outline(movable.text);
    Section section;
    if (!find_table(movable.text, all, "body", body.id, 0, all.size(), section)) continue;
    const Statement* key = find_key(all, section, "cad");
    if (!key) continue;
    // Its buffers lie beside it under names of their own.
    const bool has_buffers = file.extension() == ".gltf";
    const std::filesystem::path copy = has_buffers ? file : std::filesystem::path("cad") / name_of(file);
    movable.text.replace(key->begin, key->end - key->begin, core::toml_text(copy.generic_string()));
    if (!has_buffers &&
        std::find(movable.files.begin(), movable.files.end(), std::pair{file, copy}) == movable.files.end())
      movable.files.emplace_back(file, copy);
  }
  return movable;
}

}  // namespace thermotwin::diagnosis
