// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/units/unit_work.h"

#include <cstdio>
#include <set>

#include "core/error.h"
#include "core/folder_lock.h"
#include "core/progress.h"

namespace thermotwin::study {
namespace {

namespace fs = std::filesystem;

/// @return whether anything was computed
bool compute_one(const fs::path& study, const std::vector<Unit>& units, std::size_t u,
                 const ComputeUnit& compute_unit) {
  const fs::path folder = unit_folder(study, units[u]);
  if (is_done(study, units[u])) return false;
  const core::FolderLock lock(folder);
  if (is_done(study, units[u])) return false;  // while the lock was waited for
  if (has_result(study, units[u]))
    core::warn(folder.string() + ": results that were changed by hand or are damaged; they are computed again");
  mark_done(study, units[u], compute_unit(u, folder));
  std::error_code ignored;
  fs::remove(folder / checkpoint_file, ignored);
  return true;
}

}  // namespace

Part part_of(const std::string& words) {
  if (words.empty()) return {};
  Part part;
  char rest = 0;
  if (std::sscanf(words.c_str(), "%zu/%zu%c", &part.index, &part.of, &rest) != 2 || part.of == 0 ||
      part.index >= part.of)
    throw core::UsageError("--part " + words + ": not I/N with I from 0 to N - 1");
  return part;
}

Work compute(const fs::path& study, const std::vector<Unit>& units, const Part& part, const ComputeUnit& compute_unit) {
  Work work;
  std::set<std::string> said;  // units with one reason in common: one warning
  const auto fail = [&](const Unit& unit, const std::string& reason) {
    work.failed.push_back(unit.words + ": " + reason);
    write_failure(study, unit, reason);
    if (said.insert(reason).second) core::warn(work.failed.back());
  };
  for (std::size_t u = part.index; u < units.size(); u += part.of) {
    try {
      ++(compute_one(study, units, u, compute_unit) ? work.computed : work.kept);
    } catch (const core::MeshError& error) {
      fail(units[u], error.what());
    } catch (const core::SolverError& error) {
      work.unsolved = true;
      fail(units[u], error.what());
    }
  }
  return work;
}

}  // namespace thermotwin::study
