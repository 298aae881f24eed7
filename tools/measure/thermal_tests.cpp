// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/measure/thermal_tests.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "compensation/measurement/measurement_check.h"
#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "core/quoted.h"
#include "core/text.h"
#include "core/units.h"
#include "metrology/iso230/thermal_table.h"
#include "tools/measure/json_number.h"

namespace thermotwin::tools {
namespace {

using metrology::ThermalRow;
using metrology::ThermalTable;
using nlohmann::json;
using Rows = std::vector<std::vector<std::string>>;
namespace fs = std::filesystem;

ThermalTable table_of(const fs::path& folder, const std::string& ambient) {
  compensation::Measurement measurement = compensation::read_measurement(folder);
  for (const std::string& words : compensation::blank_implausible(measurement, mesh::PlausibleRange{}))
    core::warn(words);
  return metrology::thermal_table(measurement, ambient);
}

std::string cell(double value, int digits) {
  return std::isnan(value) ? std::string("-") : fmt::format("{:.{}g}", value, digits);
}

json json_of(const ThermalTable& table) {
  json rows = json::array();
  for (const ThermalRow& row : table.rows) {
    rows.push_back({{"channel", row.channel},
                    {"unit", row.unit},
                    {"count", row.count},
                    {"range_first_hour", number_or_null(row.first_hour)},
                    {"range_first_hour_without_noise", number_or_null(row.first_hour_motion)},
                    {"std_of_first_hour_without_noise", number_or_null(row.first_hour_std)},
                    {"range", row.whole},
                    {"range_without_noise", row.motion},
                    {"std_of_range_without_noise", row.motion_std},
                    {"end", row.last},
                    {"std_of_end", row.last_std},
                    {"gradient_per_K", number_or_null(row.gradient)},
                    {"gradient_std", number_or_null(row.gradient_std)},
                    {"reliability_of_ambient", number_or_null(row.reliability)}});
  }
  return {{"duration_s", table.duration},
          {"ambient", table.ambient},
          {"ambient_range_K", table.ambient_range},
          {"rows", rows}};
}

/// Gradients that the scatter of the temperature affects. @param test  in front of the channel; may be empty
std::string reliability_words(const ThermalTable& table, const std::string& test) {
  constexpr double good = 0.9;
  std::string text;
  for (const ThermalRow& row : table.rows) {
    if (!(row.reliability < good)) continue;
    text += fmt::format("{}{} over {}: {:.0f} % of the temperature's variance are its scatter; {}\n", test, row.channel,
                        table.ambient, 100.0 * (1.0 - row.reliability),
                        std::isnan(row.gradient) ? "too much for a gradient" : "the gradient is corrected for it");
  }
  return text;
}

/// Names of tests: those of their folders, or as given where two folders have one name.
std::vector<std::string> names_of(const std::vector<fs::path>& folders) {
  std::vector<std::string> names;
  std::set<std::string> different;
  for (const fs::path& folder : folders) {
    const fs::path trimmed = folder.has_filename() ? folder : folder.parent_path();
    names.push_back(trimmed.filename().string());
    different.insert(names.back());
  }
  if (different.size() == folders.size()) return names;
  names.clear();
  for (const fs::path& folder : folders) names.push_back(folder.lexically_normal().string());
  return names;
}

/// A displacement of one of several tests; null: the test has none of this name and unit.
const ThermalRow* row_named(const ThermalTable& table, const std::string& channel, const std::string& unit) {
  const auto found = std::find_if(table.rows.begin(), table.rows.end(),
                                  [&](const ThermalRow& row) { return row.channel == channel && row.unit == unit; });
  return found == table.rows.end() ? nullptr : &*found;
}

/// Displacements of all tests, in the order in which they come first.
std::vector<std::pair<std::string, std::string>> channels_of(const std::vector<ThermalTable>& tables) {
  std::vector<std::pair<std::string, std::string>> channels;
  for (const ThermalTable& table : tables) {
    for (const ThermalRow& row : table.rows) {
      const std::pair channel{row.channel, row.unit};
      if (std::find(channels.begin(), channels.end(), channel) == channels.end()) channels.push_back(channel);
    }
  }
  return channels;
}

/// A row for each displacement, a column for each test.
Rows side_by_side(const std::vector<std::string>& names, const std::vector<ThermalTable>& tables) {
  Rows rows{{"channel", "unit"}};
  rows[0].insert(rows[0].end(), names.begin(), names.end());
  const bool per_K = !tables.front().ambient.empty();
  for (const auto& [channel, unit] : channels_of(tables)) {
    rows.push_back({channel, unit});
    std::vector<std::string> gradients{"", unit + "/K"};
    for (const ThermalTable& table : tables) {
      const ThermalRow* row = row_named(table, channel, unit);
      rows.back().push_back(row == nullptr ? "-"
                                           : fmt::format("{} / {}", cell(row->first_hour, 3), cell(row->motion, 3)));
      gradients.push_back(row == nullptr ? "-" : cell(row->gradient, 3));
    }
    if (per_K) rows.push_back(gradients);
  }
  std::vector<std::string> duration{"duration", "h"}, ambient{"change of " + tables.front().ambient, "K"};
  for (const ThermalTable& table : tables) {
    duration.push_back(cell(table.duration / core::units::hour, 4));
    ambient.push_back(cell(table.ambient_range, 3));
  }
  rows.push_back(duration);
  if (per_K) rows.push_back(ambient);
  return rows;
}

std::string csv_of(const std::vector<std::string>& names, const std::vector<ThermalTable>& tables) {
  std::string text =
      "test,channel,unit,count,range_first_hour,range,range_without_noise,std_of_range_without_noise,end,std_of_end,"
      "gradient_per_K,gradient_std\n";
  const auto number = [](double value) { return std::isfinite(value) ? fmt::format("{:.9g}", value) : std::string(); };
  for (std::size_t i = 0; i < tables.size(); ++i) {
    for (const ThermalRow& row : tables[i].rows) {
      text += core::csv_cell(names[i]) + "," + core::csv_cell(row.channel) + "," + row.unit;
      text += fmt::format(",{}", row.count);
      for (const double value : {row.first_hour, row.whole, row.motion, row.motion_std, row.last, row.last_std,
                                 row.gradient, row.gradient_std})
        text += "," + number(value);
      text += "\n";
    }
  }
  return text;
}

}  // namespace

void warn_of_other_results(const MeasureOptions& options, const std::string& own) {
  std::vector<std::string> others;
  for (const char* name : {"location_errors.csv", "errors.csv", "displacements.csv", "modes.csv", "thermal_table.json",
                           "thermal_tests.json"}) {
    if (name != own && fs::exists(options.out / name)) others.emplace_back(name);
  }
  if (!others.empty())
    core::warn(fmt::format("{} has results of another test, which stay: {}", options.out.string(), core::join(others)));
}

void analyse_thermal(const MeasureOptions& options) {
  const ThermalTable table = table_of(options.file, options.ambient);
  Rows rows{{"channel", "unit", "first hour", "whole test", "without noise", "u", "end", "u"}};
  if (!table.ambient.empty()) rows[0].insert(rows[0].end(), {"per K", "u"});
  for (const ThermalRow& row : table.rows) {
    rows.push_back({row.channel, row.unit, cell(row.first_hour, 3), cell(row.whole, 3), cell(row.motion, 3),
                    cell(row.motion_std, 2), cell(row.last, 3), cell(row.last_std, 2)});
    if (!table.ambient.empty())
      rows.back().insert(rows.back().end(), {cell(row.gradient, 3), cell(row.gradient_std, 2)});
  }
  const json result = json_of(table);
  warn_of_other_results(options, "thermal_table.json");
  core::write_file(options.out / "thermal_table.json", result.dump(1) + "\n");
  std::string text = core::format_table(rows) + fmt::format("{:.4g} h", table.duration / core::units::hour);
  if (!table.ambient.empty()) text += fmt::format("; {} changes by {:.3g} K", table.ambient, table.ambient_range);
  text += fmt::format("; in {}\n", (options.out / "thermal_table.json").string());
  if (!table.has_an_hour()) text += "the record is shorter than an hour: it has no range of the first hour\n";
  print_summary(options, text + reliability_words(table, ""), result.dump());
}

void analyse_thermal_tests(const MeasureOptions& options) {
  if (!options.record.empty() || !options.channels.empty()) {
    throw core::UsageError(
        "several folders are ISO 230-3 tests of one table; --record and --channels belong to one folder of points");
  }
  std::vector<fs::path> folders{options.file};
  folders.insert(folders.end(), options.others.begin(), options.others.end());
  for (const fs::path& folder : folders) {
    if (!fs::exists(folder / "channels.toml")) {
      throw core::InputError(folder.string(), "no channels.toml",
                             "measurement folders of ISO 230-3 tests, where several folders make one table");
    }
  }
  const std::vector<std::string> names = names_of(folders);
  std::vector<ThermalTable> tables;
  json tests = json::array();
  std::string remarks;
  for (std::size_t i = 0; i < folders.size(); ++i) {
    tables.push_back(table_of(folders[i], options.ambient));
    json test = json_of(tables.back());
    test["test"] = names[i];
    test["folder"] = folders[i].string();
    tests.push_back(test);
    if (!tables.back().has_an_hour())
      remarks += names[i] + " is shorter than an hour: it has no range of the first hour\n";
    remarks += reliability_words(tables.back(), names[i] + ", ");
  }
  const json result = {{"tests", tests}};
  warn_of_other_results(options, "thermal_tests.json");
  core::write_file(options.out / "thermal_tests.csv", csv_of(names, tables));
  core::write_file(options.out / "thermal_tests.json", result.dump(1) + "\n");
  const std::string text = core::format_table(side_by_side(names, tables)) +
                           fmt::format("range of the first hour / of the whole test without noise; in {}\n",
                                       (options.out / "thermal_tests.csv").string());
  print_summary(options, text + remarks, result.dump());
}

}  // namespace thermotwin::tools
