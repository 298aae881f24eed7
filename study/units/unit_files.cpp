// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/units/unit_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "core/error.h"
#include "core/file.h"
#include "core/folder_lock.h"
#include "core/progress.h"

namespace thermotwin::study {
namespace {

namespace fs = std::filesystem;

constexpr const char* failure_file = "failed";
constexpr const char* done_file = "done";

std::string stamp(const fs::path& folder, const Unit& unit, const UnitFiles& files) {
  std::string text = unit.id + "\n";
  for (const fs::path& file : files)
    text += core::content_hash(core::read_file(folder / file)) + " " + file.generic_string() + "\n";
  return text;
}

/// Files that a stamp names.
UnitFiles files_of(const std::string& stamp) {
  UnitFiles files;
  std::istringstream lines(stamp);
  std::string line;
  std::getline(lines, line);  // the unit
  while (std::getline(lines, line))
    if (const auto at = line.find(' '); at != std::string::npos) files.emplace_back(line.substr(at + 1));
  return files;
}

}  // namespace

bool require_folder_of(const fs::path& study, const fs::path& plan) {
  const fs::path note = study / origin_note, own = fs::canonical(plan);
  if (!fs::exists(note)) return false;
  std::string other = core::read_file(note);
  while (!other.empty() && other.back() == '\n') other.pop_back();
  std::error_code ignored;
  if (other == own.string()) return true;
  if (fs::exists(other, ignored) && !fs::equivalent(other, own, ignored)) {
    throw core::InputError(study.string(), fmt::format("the results of {}, not of {}", other, own.string()),
                           "one plan or case a folder: another --out, or another name for one of the plans");
  }
  return false;
}

void claim_folder(const fs::path& study, const fs::path& plan) {
  if (!require_folder_of(study, plan)) core::write_file(study / origin_note, fs::canonical(plan).string() + "\n");
}

fs::path unit_folder(const fs::path& study, const Unit& unit) { return study / "units" / unit.id; }

bool has_result(const fs::path& study, const Unit& unit) {
  std::error_code error;
  return fs::exists(unit_folder(study, unit) / done_file, error);
}

bool is_done(const fs::path& study, const Unit& unit) {
  const fs::path folder = unit_folder(study, unit);
  if (!has_result(study, unit)) return false;
  try {
    const std::string noted = core::read_file(folder / done_file);
    return noted == stamp(folder, unit, files_of(noted));
  } catch (const core::InputError&) {
    return false;  // a file is missing: computed again
  }
}

void mark_done(const fs::path& study, const Unit& unit, const UnitFiles& files) {
  const fs::path folder = unit_folder(study, unit);
  core::write_file(folder / done_file, stamp(folder, unit, files));
  std::error_code ignored;
  fs::remove(folder / failure_file, ignored);
}

void write_failure(const fs::path& study, const Unit& unit, const std::string& reason) {
  core::write_file(unit_folder(study, unit) / failure_file, reason + "\n");
}

std::optional<std::string> failure_of(const fs::path& study, const Unit& unit) {
  const fs::path file = unit_folder(study, unit) / failure_file;
  std::error_code error;
  if (!fs::exists(file, error)) return std::nullopt;
  std::string reason = core::read_file(file);
  while (!reason.empty() && reason.back() == '\n') reason.pop_back();
  return reason;
}

Standing standing_of(const fs::path& study, const std::vector<Unit>& units) {
  Standing standing;
  core::Progress progress("reading units", units.size());
  for (std::size_t u = 0; u < units.size(); ++u) {
    if (is_done(study, units[u]))
      standing.done.push_back(u);
    else if (auto reason = failure_of(study, units[u]))
      standing.failed.emplace_back(u, std::move(*reason));
    else {
      standing.missing.push_back(u);
      if (has_result(study, units[u])) {
        core::warn(unit_folder(study, units[u]).string() +
                   ": results that were changed by hand or are damaged; the unit counts as missing");
      }
    }
    progress.advance();
  }
  return standing;
}

std::vector<std::string> missing_words(const std::vector<Unit>& units, const Standing& standing) {
  std::vector<std::string> words;
  for (const std::size_t u : standing.missing) words.push_back(fmt::format("unit {}: {}", units[u].id, units[u].words));
  return words;
}

std::vector<std::string> failed_words(const std::vector<Unit>& units, const Standing& standing) {
  std::vector<std::string> words;
  for (const auto& [u, reason] : standing.failed) words.push_back(units[u].words + ": " + reason);
  return words;
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

void publish(const fs::path& study, const Unit& unit, const fs::path& to) {
  const fs::path from = unit_folder(study, unit);
  const UnitFiles files = files_of(core::read_file(from / done_file));
  for (auto first = files.begin(); first != files.end();) {
    const fs::path folder = first->parent_path();
    const auto last =
        std::find_if(first, files.end(), [&](const fs::path& file) { return file.parent_path() != folder; });
    const core::FolderLock lock(to / folder);
    core::write_files_by(to / folder, [&](const fs::path& staged) {
      std::vector<fs::path> names;
      for (; first != last; ++first) {
        names.push_back(first->filename());
        core::write_file(staged / names.back(), core::read_file(from / *first));
      }
      return names;
    });
  }
}

}  // namespace thermotwin::study
