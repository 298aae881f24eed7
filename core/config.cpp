// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/config.h"

#define TOML_HEADER_ONLY 1
#define TOML_ENABLE_FORMATTERS 0
#define TOML_ENABLE_UNRELEASED_FEATURES 0
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#include <toml++/toml.h>
#pragma GCC diagnostic pop

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>

#include "core/error.h"
#include "core/file.h"
#include "core/text.h"

namespace thermotwin::core {

struct Config::Data {
  std::string text;
  std::string source;
  toml::table root;
  /// Keys that were asked for, by table: two nodes of one table share what they know.
  std::map<const toml::table*, std::set<std::string>> asked;
};

struct Node::Data {
  Config::Data* config = nullptr;
  const toml::table* table = nullptr;
  std::string path;  ///< "film[3]", empty for the root

  /// The value of a key, which counts as known from now on; null if it is not in the file.
  const toml::node* ask(const std::string& key) const {
    config->asked[table].insert(key);
    return table->get(key);
  }

  bool was_asked(const std::string& key) const {
    const auto known = config->asked.find(table);
    return known != config->asked.end() && known->second.count(key) > 0;
  }

  std::string place(const toml::source_region& region, const std::string& where) const {
    std::string result = config->source;
    if (region.begin.line > 0) result += fmt::format(":{}", region.begin.line);
    return where.empty() ? result : result + " " + where;
  }

  std::string path_of(const std::string& key) const { return path.empty() ? key : path + "." + key; }

  std::string place_of(const std::string& key) const;
  std::string likely_misnamed(const std::string& key) const;
  const toml::node& require(const std::string& key, const std::string& allowed) const;
};

namespace {

/// Keys in the order of the file: the table itself sorts them by name.
std::vector<std::string> keys_as_written(const toml::table& table) {
  struct Entry {
    toml::source_position position;
    std::string key;
  };
  std::vector<Entry> entries;
  for (const auto& [key, value] : table) entries.push_back({key.source().begin, std::string(key.str())});
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry& a, const Entry& b) { return a.position < b.position; });
  std::vector<std::string> keys;
  for (Entry& entry : entries) keys.push_back(std::move(entry.key));
  return keys;
}

/// A value for a message, as it would be written in the file.
std::string shown(const toml::node& node) {
  if (const auto* text = node.as_string()) {
    const std::string& value = text->get();
    return fmt::format("\"{}\"", value.size() > 60 ? value.substr(0, 57) + "..." : value);
  }
  if (const auto* number = node.as_integer()) return fmt::format("{}", number->get());
  if (const auto* number = node.as_floating_point()) return fmt::format("{}", number->get());
  if (const auto* boolean = node.as_boolean()) return boolean->get() ? "true" : "false";
  if (const auto* array = node.as_array()) return fmt::format("an array of {}", array->size());
  return node.is_table() ? "a table" : "a date or time";
}

std::string phrase(const Range& range) {
  const bool bounded_below = range.low > any_number.low;
  const bool bounded_above = range.high < any_number.high;
  if (bounded_below && bounded_above) return fmt::format("a number from {} to {}", range.low, range.high);
  if (range.low == positive.low && !bounded_above) return "a number above 0";
  if (bounded_below) return fmt::format("a number of at least {}", range.low);
  if (bounded_above) return fmt::format("a number of at most {}", range.high);
  return "a finite number";
}

double number_from(const toml::node& node, const std::string& place, const Range& range) {
  double value = 0.0;
  if (const auto* real = node.as_floating_point()) {
    value = real->get();
  } else if (const auto* integer = node.as_integer()) {
    value = static_cast<double>(integer->get());
  } else {
    throw InputError(place, shown(node),
                     phrase(range) + (node.is_string() ? ", without quotes" : ""));
  }
  if (!std::isfinite(value) || value < range.low || value > range.high) {
    throw InputError(place, shown(node), phrase(range));
  }
  return value;
}

const toml::array& array_from(const toml::node& node, const std::string& place,
                              const std::string& allowed) {
  const toml::array* array = node.as_array();
  if (array == nullptr) throw InputError(place, shown(node), allowed);
  return *array;
}

std::string element_place(const std::string& place, std::size_t i) {
  return fmt::format("{}[{}]", place, i + 1);
}

std::vector<double> numbers_from(const toml::node& node, const std::string& place,
                                 const std::string& allowed) {
  const toml::array& array = array_from(node, place, allowed);
  std::vector<double> values;
  for (std::size_t i = 0; i < array.size(); ++i) {
    values.push_back(number_from(array[i], element_place(place, i), any_number));
  }
  return values;
}

std::string text_from(const toml::node& node, const std::string& place) {
  const auto* text = node.as_string();
  if (text == nullptr) throw InputError(place, shown(node), "a text in quotes");
  return text->get();
}

std::string one_of(const std::string& value, const std::string& place,
                   const std::vector<std::string>& allowed) {
  if (std::find(allowed.begin(), allowed.end(), value) != allowed.end()) return value;
  throw InputError(place, "\"" + value + "\"", "one of: " + join(allowed));
}

/// "4:7" for an offset; columns count bytes.
std::string line_and_column(const std::string& text, std::size_t offset) {
  const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(offset), '\n');
  const std::size_t before = offset == 0 ? std::string::npos : text.rfind('\n', offset - 1);
  const std::size_t column = before == std::string::npos ? offset + 1 : offset - before;
  return fmt::format("{}:{}", line, column);
}

}  // namespace

Config::Config() : data_(std::make_unique<Data>()) {}
Config::Config(Config&&) noexcept = default;
Config& Config::operator=(Config&&) noexcept = default;
Config::~Config() = default;

Config Config::load(const std::filesystem::path& path) { return parse(read_file(path), path.string()); }

Config Config::parse(const std::string& text, const std::string& source) {
  // The parser is not safe on broken UTF-8, so it never sees any.
  if (const auto offset = find_invalid_utf8(text)) {
    throw InputError(source + ":" + line_and_column(text, *offset),
                     fmt::format("byte {:#04x}", static_cast<unsigned char>(text[*offset])),
                     "text in UTF-8");
  }
  // Nor letters where TOML has none: it takes some of them for an impossible case.
  if (const auto offset = find_bare_non_ascii(text)) {
    throw InputError(source + ":" + line_and_column(text, *offset),
                     fmt::format("byte {:#04x} outside of quotes and comments", static_cast<unsigned char>(text[*offset])),
                     "ASCII there; other letters in quotes");
  }
  Config config;
  config.data_->text = text;
  config.data_->source = source;
  try {
    config.data_->root = toml::parse(std::string_view(text));
  } catch (const toml::parse_error& error) {
    const toml::source_position at = error.source().begin;
    throw InputError(fmt::format("{}:{}:{}", source, at.line, at.column),
                     std::string(error.description()), "TOML 1.0");
  }
  return config;
}

Node Config::root() const {
  auto data = std::make_shared<Node::Data>();
  data->config = data_.get();
  data->table = &data_->root;
  return Node(std::move(data));
}

const std::string& Config::text() const { return data_->text; }
const std::string& Config::source() const { return data_->source; }

Node::Node(std::shared_ptr<Data> data) : data_(std::move(data)) {}

bool Node::has(const std::string& key) const { return data_->ask(key) != nullptr; }

std::vector<std::string> Node::keys() const { return keys_as_written(*data_->table); }

/// A key of this table that nothing has asked for and that reads much like key; empty if none does.
std::string Node::Data::likely_misnamed(const std::string& key) const {
  std::vector<std::string> unknown;
  for (std::string& written : keys_as_written(*table)) {
    if (!was_asked(written)) unknown.push_back(std::move(written));
  }
  const std::string candidate = nearest(key, unknown);
  return edit_distance(key, candidate) <= std::max<std::size_t>(2, key.size() / 3) ? candidate : "";
}

const toml::node& Node::Data::require(const std::string& key, const std::string& allowed) const {
  if (const toml::node* value = ask(key)) return *value;
  const std::string misnamed = likely_misnamed(key);
  throw InputError(place_of(key), "missing" + (misnamed.empty() ? "" : " (found: " + misnamed + ")"),
                   allowed);
}

double Node::number(const std::string& key, Range range) const {
  return number_from(data_->require(key, phrase(range)), place(key), range);
}

double Node::number_or(const std::string& key, double otherwise, Range range) const {
  return has(key) ? number(key, range) : otherwise;
}

Uncertain Node::uncertain(const std::string& key, Range range) const {
  const toml::node* value = data_->ask(key);
  if (value == nullptr || !value->is_table()) return {number(key, range), 0.0};
  const Node inner = table(key);
  const Uncertain result{inner.number("value", range), inner.number("std_percent", non_negative)};
  inner.finish();
  return result;
}

Uncertain Node::uncertain_or(const std::string& key, Uncertain otherwise, Range range) const {
  return has(key) ? uncertain(key, range) : otherwise;
}

int Node::integer(const std::string& key, int low, int high) const {
  const std::string allowed = fmt::format("an integer from {} to {}", low, high);
  const toml::node& value = data_->require(key, allowed);
  const auto* integer = value.as_integer();
  if (integer == nullptr || integer->get() < low || integer->get() > high) {
    throw InputError(place(key), shown(value), allowed);
  }
  return static_cast<int>(integer->get());
}

int Node::integer_or(const std::string& key, int otherwise, int low, int high) const {
  return has(key) ? integer(key, low, high) : otherwise;
}

bool Node::boolean_or(const std::string& key, bool otherwise) const {
  const toml::node* value = data_->ask(key);
  if (value == nullptr) return otherwise;
  const auto* boolean = value->as_boolean();
  if (boolean == nullptr) throw InputError(place(key), shown(*value), "true or false");
  return boolean->get();
}

std::string Node::text(const std::string& key) const {
  return text_from(data_->require(key, "a text in quotes"), place(key));
}

std::string Node::text_or(const std::string& key, const std::string& otherwise) const {
  return has(key) ? text(key) : otherwise;
}

std::string Node::choice(const std::string& key, const std::vector<std::string>& allowed) const {
  const std::string words = "one of: " + join(allowed);
  const toml::node& found = data_->require(key, words);
  if (!found.is_string()) throw InputError(place(key), shown(found), words);
  return one_of(text(key), place(key), allowed);
}

std::string Node::choice_or(const std::string& key, const std::string& otherwise,
                            const std::vector<std::string>& allowed) const {
  return has(key) ? choice(key, allowed) : otherwise;
}

Eigen::Vector3d Node::vector3(const std::string& key) const {
  const std::string allowed = "three numbers: [x, y, z]";
  const toml::node& found = data_->require(key, allowed);
  const std::vector<double> values = numbers_from(found, place(key), allowed);
  if (values.size() != 3) throw InputError(place(key), shown(found), allowed);
  return {values[0], values[1], values[2]};
}

std::vector<double> Node::numbers(const std::string& key) const {
  const std::string allowed = "an array of numbers";
  return numbers_from(data_->require(key, allowed), place(key), allowed);
}

std::vector<std::string> Node::texts(const std::string& key) const {
  const std::string allowed = "a text in quotes or an array of such texts";
  const toml::node& found = data_->require(key, allowed);
  if (found.is_string()) return {text(key)};
  const toml::array& array = array_from(found, place(key), allowed);
  std::vector<std::string> result;
  for (std::size_t i = 0; i < array.size(); ++i) {
    result.push_back(text_from(array[i], element_place(place(key), i)));
  }
  return result;
}

std::vector<std::string> Node::texts_or_empty(const std::string& key) const {
  return has(key) ? texts(key) : std::vector<std::string>();
}

Eigen::MatrixX3d Node::points3(const std::string& key) const {
  const std::string allowed = "an array of points: [[x, y, z], ...]", of_one = "three numbers: [x, y, z]";
  const toml::array& array = array_from(data_->require(key, allowed), place(key), allowed);
  Eigen::MatrixX3d points(static_cast<Eigen::Index>(array.size()), 3);
  for (std::size_t i = 0; i < array.size(); ++i) {
    const std::string point_place = element_place(place(key), i);
    const std::vector<double> point = numbers_from(array[i], point_place, of_one);
    if (point.size() != 3) throw InputError(point_place, shown(array[i]), of_one);
    points.row(static_cast<Eigen::Index>(i)) << point[0], point[1], point[2];
  }
  return points;
}

Node Node::table(const std::string& key) const {
  const std::string allowed = fmt::format("one table: [{0}] or {0} = {{...}}", key);
  const toml::node& found = data_->require(key, allowed);
  if (!found.is_table()) throw InputError(place(key), shown(found), allowed);
  auto data = std::make_shared<Data>(*data_);
  data->table = found.as_table();
  data->path = data_->path_of(key);
  return Node(std::move(data));
}

std::optional<Node> Node::table_if(const std::string& key) const {
  return has(key) ? std::optional(table(key)) : std::nullopt;
}

std::vector<Node> Node::tables(const std::string& key) const {
  const toml::node* value = data_->ask(key);
  std::vector<Node> nodes;
  if (value == nullptr) return nodes;
  const std::string allowed = fmt::format("tables: [[{0}]] or {0} = [{{...}}, ...]", key);
  const toml::array& array = array_from(*value, place(key), allowed);
  for (std::size_t i = 0; i < array.size(); ++i) {
    if (!array[i].is_table()) throw InputError(element_place(place(key), i), shown(array[i]), allowed);
    auto data = std::make_shared<Data>(*data_);
    data->table = array[i].as_table();
    data->path = element_place(data_->path_of(key), i);
    nodes.push_back(Node(std::move(data)));
  }
  return nodes;
}

std::string Node::place() const {
  // The root table is the file: line 1 would say less than its name.
  return data_->path.empty() ? data_->config->source : data_->place(data_->table->source(), data_->path);
}

std::string Node::place(const std::string& key) const { return data_->place_of(key); }

std::string Node::Data::place_of(const std::string& key) const {
  for (const auto& [written, value] : *table) {
    if (written.str() == key) return place(written.source(), path_of(key));
  }
  if (path.empty()) return config->source + " " + key;
  return place(table->source(), path_of(key));
}

void Node::finish() const {
  for (const std::string& key : keys()) {
    if (data_->was_asked(key)) continue;
    const std::set<std::string>& known = data_->config->asked[data_->table];
    const std::vector<std::string> names(known.begin(), known.end());
    if (names.empty()) throw InputError(place(key), "unknown key", "no key here");
    throw InputError(place(key), "unknown key",
                     "nearest is " + nearest(key, names));
  }
}

void require_unique_id(const std::string& id, const std::string& place,
                       std::vector<std::string>& seen) {
  const bool well_formed = !id.empty() && std::all_of(id.begin(), id.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '-';
  });
  if (!well_formed) throw InputError(place, "id \"" + id + "\"", "letters, digits and _ . - in an id");
  if (std::find(seen.begin(), seen.end(), id) != seen.end()) {
    throw InputError(place, "id \"" + id + "\" a second time", "each id once");
  }
  seen.push_back(id);
}

}  // namespace thermotwin::core
