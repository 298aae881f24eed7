// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/variants/earlier_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "core/text.h"

namespace thermotwin::study {

namespace fs = std::filesystem;

namespace {

constexpr const char* no_results[] = {"units", "slurm", "before"};  // folders without tables of this kind
constexpr const char* tables[] = {"quantiles.csv", "sensitivities.csv", "sensitivities_by_pose.csv"};

std::vector<std::string> tables_in(const fs::path& study) {
  std::vector<std::string> found;
  std::error_code ignored;
  for (fs::recursive_directory_iterator at(study, ignored), end; at != end; at.increment(ignored)) {
    const std::string name = at->path().filename().string();
    if (at.depth() == 0 && std::find(std::begin(no_results), std::end(no_results), name) != std::end(no_results))
      at.disable_recursion_pending();
    if (at.depth() > 0 && std::find(std::begin(tables), std::end(tables), name) != std::end(tables))
      found.push_back(at->path().lexically_relative(study).generic_string());
  }
  std::sort(found.begin(), found.end());
  return found;
}

/// Those that write_results() makes.
std::set<std::string> tables_of(const VariantStudy& results) {
  std::set<std::string> made;
  for (const GroupStudy& group : results.groups) {
    for (const LoadStudy& load : group.loads) {
      for (const char* table : tables)
        if (load.sensitivity || table == std::string("quantiles.csv"))
          made.insert((fs::path(group.name) / load.load / table).generic_string());
    }
  }
  return made;
}

}  // namespace

std::vector<std::string> set_aside(const fs::path& study, const VariantStudy& results) {
  const std::set<std::string> made = tables_of(results);
  std::vector<std::string> stale = tables_in(study);
  std::erase_if(stale, [&](const std::string& table) { return made.contains(table); });
  if (stale.empty()) return stale;
  int number = 1;
  while (fs::exists(study / "before" / std::to_string(number))) ++number;
  const fs::path before = study / "before" / std::to_string(number);
  try {
    for (const std::string& table : stale) {
      fs::create_directories((before / table).parent_path());
      fs::rename(study / table, before / table);
      std::error_code ignored;
      for (fs::path folder = (study / table).parent_path(); folder != study; folder = folder.parent_path())
        if (!fs::is_empty(folder, ignored) || !fs::remove(folder, ignored)) break;
    }
  } catch (const fs::filesystem_error& error) {
    throw core::InputError(before.string(), error.code().message(), "a folder with write permission");
  }
  core::warn(fmt::format("tables of an earlier run that this one does not make are moved to {}: {}", before.string(),
                         core::join(stale)));
  return stale;
}

}  // namespace thermotwin::study
