// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Numbers and words that the sections of a diagnosis's page share.

#include <string>

#include "diagnosis/judge/diagnosis.h"
#include "mesh/machine/machine.h"

namespace thermotwin::diagnosis {

std::string percent(double value);
/// Probabilities near 0 and 1 keep their meaning.
std::string probability(double p);
std::string display_unit(const std::string& unit);
std::string two_digits(double value);
/// "factor 1.3 ± 0.05"
std::string estimate(const RankedCause& cause);

/// What a page calls its model and what it expects of a residual.
struct Wording {
  std::string subject, below;  ///< title, and what is said below it; plain text
  std::string residual;        ///< of all displacement channels
  std::string expected, band;  ///< what an expected standard deviation consists of
};

/// @param machine  nullptr: a record without a machine
Wording wording(const Diagnosis& d, const mesh::Machine* machine);

/// Without a machine nothing is corrected where nothing is named.
bool shows_change(const Diagnosis& d, const mesh::Machine* machine);

}  // namespace thermotwin::diagnosis
