// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reservations about a verdict: what keeps a named cause from explaining, and leaves the verdict open.

#include <set>
#include <string>

#include "diagnosis/inference/hypothesis_fit.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

/// Changes an explained verdict to ambiguous, with an unknown cause in the set, if the whole record strains the
/// explanation: a size that varies, or another parameter that deviates, by more than expected. Where it is the size of
/// a single source or joint, `other_law` of it is in the set too.
void leave_open(const Problem& problem, const Strain& strain, Diagnosis& out);

/// The same for a reason such as "correcting it worsens ...": the strongest cause stays, with an unknown one in the
/// set.
void leave_open(const std::string& reason, Diagnosis& out);

/// @return whether heat of a source enters a body, by a surface or at a joint
bool heats(const mesh::Machine& machine, const mesh::SourceSpec& source, const std::string& body);

/// The same as leave_open() where one of two causes is the power of a source, and the other one a missing source that
/// follows the same motion and enters the same body: heat that enters elsewhere than the model assumes looks like this.
/// The stated source stays, with the missing one in the set. Where an explanation with such a missing source is
/// strained, a stated source with strong evidence is in the set too.
void leave_one_heat_open(const mesh::Machine& machine, Diagnosis& out);

/// @return why a named cause does not explain: its estimate is nearer to nominal than two of its own standard
///   deviations; empty: none is
std::string uncertain_size(const Diagnosis& diagnosis);

/// @return why a named cause does not explain: its estimate is the largest value that is looked for, or a
///   film's is almost 0; empty: none is
/// @param switched  ids of films that a state switches off: fluid that does not flow transfers no heat
std::string at_bound(const Diagnosis& diagnosis, const std::set<std::string>& switched = {});

/// @return why a named offset of a sensor does not explain: in a record that begins warm, steady heat beside the sensor
///   that had begun before looks alike; empty: none is
std::string perhaps_steady_heat(const Observations& record, const Diagnosis& diagnosis);

/// @return whether the named causes are certain, but an unknown cause acts as well
bool only_unknown_shares(const Diagnosis& diagnosis);

}  // namespace thermotwin::diagnosis
