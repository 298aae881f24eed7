// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/units/unit_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/error.h"
#include "core/file.h"

namespace thermotwin::study {
namespace {

namespace fs = std::filesystem;

constexpr const char* failure_file = "failed";

std::string file_name(const char* table, std::size_t variant) {
  return fmt::format("{}_{:05}.csv", table, variant + 1);
}

std::vector<std::string> names_of(const Unit& unit) {
  std::vector<std::string> names;
  for (const std::size_t variant : unit.variants) {
    names.push_back(file_name("tcp", variant));
    names.push_back(file_name("sensors", variant));
  }
  return names;
}

std::string stamp(const fs::path& folder, const Unit& unit) {
  std::string hashes;
  for (const std::string& name : names_of(unit)) hashes += core::content_hash(core::read_file(folder / name));
  return unit.id + "\n" + core::content_hash(hashes) + "\n";
}

}  // namespace

fs::path unit_folder(const fs::path& study, const Unit& unit) { return study / "units" / unit.id; }

fs::path tcp_file(const fs::path& study, const Unit& unit, std::size_t variant) {
  return unit_folder(study, unit) / file_name("tcp", variant);
}

bool is_done(const fs::path& study, const Unit& unit) {
  const fs::path folder = unit_folder(study, unit);
  std::error_code error;
  if (!fs::exists(folder / "done", error)) return false;
  try {
    return core::read_file(folder / "done") == stamp(folder, unit);
  } catch (const core::InputError&) {
    return false;  // a table is missing: computed again
  }
}

void write_unit(const fs::path& study, const Unit& unit, const std::vector<VariantTables>& tables) {
  core::write_files_by(unit_folder(study, unit), [&](const fs::path& staged) {
    for (std::size_t i = 0; i < tables.size(); ++i) {
      core::write_csv(staged / file_name("tcp", unit.variants[i]), tables[i].tcp, table_digits);
      core::write_csv(staged / file_name("sensors", unit.variants[i]), tables[i].sensors, table_digits);
    }
    core::write_file(staged / "done", stamp(staged, unit));
    std::vector<fs::path> files;
    for (const std::string& name : names_of(unit)) files.emplace_back(name);
    files.emplace_back("done");
    return files;
  });
  std::error_code ignored;
  fs::remove(unit_folder(study, unit) / failure_file, ignored);
}

void write_failure(const fs::path& study, const Unit& unit, const std::string& reason) {
  core::write_file(unit_folder(study, unit) / failure_file, reason + "\n");
}

std::optional<std::string> failure_of(const fs::path& study, const Unit& unit) {
  const fs::path file = unit_folder(study, unit) / failure_file;
  std::error_code error;
  if (!fs::exists(file, error) || is_done(study, unit)) return std::nullopt;
  std::string reason = core::read_file(file);
  while (!reason.empty() && reason.back() == '\n') reason.pop_back();
  return reason;
}

std::vector<std::string> stale_units(const fs::path& study, const std::vector<Unit>& units) {
  std::set<std::string> known;
  for (const Unit& unit : units) known.insert(unit.id);
  std::vector<std::string> stale;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(study / "units", ignored)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_directory(ignored) && !known.contains(name)) stale.push_back(name);
  }
  std::sort(stale.begin(), stale.end());
  return stale;
}

}  // namespace thermotwin::study
