// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The folder of a study belongs to one plan or case. That of a unit is units/<id>: its files, and `done`, which is
// written last and holds their names and hashes. A unit whose files were changed afterwards is computed again. `failed`
// holds the reason why a unit could not be computed; the next run tries it again.

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "study/units/unit.h"

namespace thermotwin::study {

/// Names of the results of a unit, relative to its folder.
using UnitFiles = std::vector<std::filesystem::path>;

/// In the folder of a study, from its beginning on: the path of its plan or case.
inline constexpr const char* origin_note = "plan.path";

/// @return whether the folder of a study is noted to be of this plan or case
/// @throws InputError, with both paths, if it is of another one that still exists
bool require_folder_of(const std::filesystem::path& study, const std::filesystem::path& plan);

/// Notes in the folder of a study which plan or case it is of.
/// @throws InputError, with both paths, if it is of another one that still exists
void claim_folder(const std::filesystem::path& study, const std::filesystem::path& plan);

std::filesystem::path unit_folder(const std::filesystem::path& study, const Unit& unit);

/// Whether the unit was finished once; its files are not looked at.
bool has_result(const std::filesystem::path& study, const Unit& unit);

/// Whether the unit's files are complete and unchanged.
bool is_done(const std::filesystem::path& study, const Unit& unit);

/// Notes that these files are the unit's results, and forgets an earlier failure. @throws InputError
void mark_done(const std::filesystem::path& study, const Unit& unit, const UnitFiles& files);

/// Notes why the unit cannot be computed. @throws InputError
void write_failure(const std::filesystem::path& study, const Unit& unit, const std::string& reason);

/// @return the reason that was noted; nothing: the unit is done, or nobody has tried it
std::optional<std::string> failure_of(const std::filesystem::path& study, const Unit& unit);

/// Units by what came of them, whenever and wherever; indices.
struct Standing {
  std::vector<std::size_t> done;
  std::vector<std::size_t> missing;                         ///< that nobody has computed or tried
  std::vector<std::pair<std::size_t, std::string>> failed;  ///< with the reason
};
Standing standing_of(const std::filesystem::path& study, const std::vector<Unit>& units);

/// "unit <id>: words" of each that is missing
std::vector<std::string> missing_words(const std::vector<Unit>& units, const Standing& standing);
/// "words: reason" of each that failed
std::vector<std::string> failed_words(const std::vector<Unit>& units, const Standing& standing);

/// @return ids of units in the folder that are not among these: of another plan, machine or version
std::vector<std::string> stale_units(const std::filesystem::path& study, const std::vector<Unit>& units);

/// Copies the files of a unit that is done to the folder, under their own names; files of one folder appear together.
/// @throws InputError, also if another process writes there
void publish(const std::filesystem::path& study, const Unit& unit, const std::filesystem::path& to);

}  // namespace thermotwin::study
