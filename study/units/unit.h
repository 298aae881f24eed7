// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A unit of work of a study: some variants that run one load program side by side. Its name is a hash of everything
// that its results depend on, so that a unit that is done stays done, on any host, and one of another plan, machine or
// version is never taken for it.

#include <cstddef>
#include <string>
#include <vector>

#include "study/plan/design.h"
#include "study/plan/plan.h"

namespace thermotwin::study {

struct Unit {
  std::string id;        ///< 16 hexadecimal digits
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
std::vector<Unit> make_units(const StudyPlan& plan, const Design& design, const UnitOrigin& origin);

}  // namespace thermotwin::study
