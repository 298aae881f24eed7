// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The units of `study variants`: some variants that run one load program side by side. Files of a unit:
// tcp_<variant>.csv and sensors_<variant>.csv for each of its variants.

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "core/table.h"
#include "solver/campaign/files.h"
#include "study/plan/design.h"
#include "study/plan/plan.h"
#include "study/units/unit.h"
#include "study/units/unit_files.h"

namespace thermotwin::study {

struct VariantUnit : Unit {
  std::string load;      ///< load program
  std::string size;      ///< mesh size
  std::string matrices;  ///< units of equal text share mesh, matrices and output rows
  std::vector<std::size_t> variants;
};

/// What the results of all units depend on besides plan and case.
struct UnitOrigin {
  std::string version;  ///< of the program
  std::string model;    ///< "full", or the hash of the reduced model's file
};

/// @return the units of the study, those that share matrices one after another
/// @throws InputError if a CAD file of the case cannot be read
std::vector<VariantUnit> make_units(const StudyPlan& plan, const Design& design, const UnitOrigin& origin);

/// Results of a variant with one load program.
struct VariantTables {
  core::Table tcp;      ///< time_s, axes, dx_um ... rc_um_per_m; one row a time and pose
  core::Table sensors;  ///< time_s, `<sensor>_C`
};

using solver::table_digits;

/// Of a variant, in the unit's folder.
std::filesystem::path tcp_file(std::size_t variant);

/// Writes the tables into the unit's folder. @param tables  one a variant of the unit  @throws InputError
UnitFiles write_tables(const std::filesystem::path& folder, const VariantUnit& unit,
                       const std::vector<VariantTables>& tables);

}  // namespace thermotwin::study
