// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A unit of work of a study. Its name is a hash of everything that its results depend on, so that a unit that is done
// stays done, on any host, and one of another plan, machine or version is never taken for it.

#include <string>
#include <vector>

#include "solver/campaign/case.h"

namespace thermotwin::study {

struct Unit {
  std::string id;     ///< 16 hexadecimal digits
  std::string words;  ///< for messages
};

/// Hash of what all units of a case depend on: machine, its CAD files, order of the tetrahedra, [time] of case.toml.
/// @param origin  kind of the study, version of the program, and the like
/// @throws InputError if a CAD file cannot be read
std::string hash_of_case(const solver::Case& machine_case, const std::string& origin);

/// Name and content of a load program. @throws InputError if it cannot be read
std::string words_of_load(const solver::Case& machine_case, const std::string& load);

}  // namespace thermotwin::study
