// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The files of a unit: units/<id>/tcp_<variant>.csv and sensors_<variant>.csv for each of its variants, and `done`,
// which is written last and holds a hash of the tables. A unit whose tables were changed afterwards is computed again.
// `failed` holds the reason why a unit could not be computed; the next run tries it again.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/table.h"
#include "study/units/unit.h"

namespace thermotwin::study {

/// Results of a variant with one load program.
struct VariantTables {
  core::Table tcp;      ///< time_s, axes, dx_um ... rc_um_per_m; one row a time and pose
  core::Table sensors;  ///< time_s, `<sensor>_C`
};

inline constexpr int table_digits = 12;  ///< more than the tables of `campaign` have

std::filesystem::path unit_folder(const std::filesystem::path& study, const Unit& unit);
std::filesystem::path tcp_file(const std::filesystem::path& study, const Unit& unit, std::size_t variant);

/// Whether the unit's files are complete and unchanged.
bool is_done(const std::filesystem::path& study, const Unit& unit);

/// Writes the unit whole or not at all. @param tables  one a variant of the unit  @throws InputError
void write_unit(const std::filesystem::path& study, const Unit& unit, const std::vector<VariantTables>& tables);

/// Notes why the unit cannot be computed; write_unit() removes the note. @throws InputError
void write_failure(const std::filesystem::path& study, const Unit& unit, const std::string& reason);

/// @return the reason that was noted; nothing: the unit is done, or nobody has tried it
std::optional<std::string> failure_of(const std::filesystem::path& study, const Unit& unit);

/// @return ids of units in the folder that are not among these: of another plan, machine or version
std::vector<std::string> stale_units(const std::filesystem::path& study, const std::vector<Unit>& units);

}  // namespace thermotwin::study
