// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/toml_place.h"

#include <map>

#include "core/config.h"
#include "core/error.h"
#include "core/file.h"

namespace thermotwin::core {

std::string toml_place(const std::string& text, const std::string& source, const std::string& table,
                       const std::string& key) {
  const std::string fallback = source + " " + (table.empty() ? key : table + "." + key);
  try {
    const Config config = Config::parse(text, source);
    if (table.empty()) return config.root().place(key);
    const auto inner = config.root().table_if(table);
    return inner ? inner->place(key) : fallback;
  } catch (const InputError&) {
    return fallback;
  }
}

std::string toml_place(const std::filesystem::path& file, const std::string& table, const std::string& key) {
  std::error_code ignored;
  const bool exists = std::filesystem::is_regular_file(file, ignored);
  return toml_place(exists ? read_file(file) : std::string(), file.string(), table, key);
}

std::vector<std::string> toml_places_of_ids(const std::filesystem::path& file, const std::string& table,
                                            const std::vector<std::string>& ids) {
  std::map<std::string, std::string> lines;
  try {
    std::error_code ignored;
    if (std::filesystem::is_regular_file(file, ignored)) {
      const Config config = Config::load(file);
      for (const Node& node : config.root().tables(table)) {
        if (!node.has("id")) continue;
        const std::string place = node.place("id");  // "channels.toml:12 channel[3].id"
        lines.emplace(node.text("id"), place.substr(0, place.rfind(' ')));
      }
    }
  } catch (const InputError&) {
    // The file has changed since it was read.
  }
  std::vector<std::string> places;
  for (const std::string& id : ids) {
    const auto line = lines.find(id);
    places.push_back((line == lines.end() ? file.string() : line->second) + " " + table + " '" + id + "'");
  }
  return places;
}

}  // namespace thermotwin::core
