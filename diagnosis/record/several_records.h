// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Several records of one machine: other programs, other days. They are one question: what is wrong with the machine is
// the same in all of them. Their channels are called RECORD/CHANNEL, so that each has readings of its own.

#include <span>
#include <string>
#include <vector>

#include "compensation/measurement/measurement.h"
#include "diagnosis/record/observations.h"

namespace thermotwin::diagnosis {

using Records = std::span<const compensation::Measurement>;

/// @return the names of the records' folders, those that come again with a number; of a single record an empty name
std::vector<std::string> record_names(Records records);

/// @return the records with channels that are called RECORD/CHANNEL; a single one as it is
std::vector<compensation::Measurement> with_record_names(std::vector<compensation::Measurement> records);

/// @return the length that all records' intervals have, s: the longest that one of them needs
double common_interval_s(Records records, double interval_s);

/// One after another on a common axis of time, with the records themselves in Observations::records.
/// @param each  (records) with intervals of equal length  @param names  (records)
Observations joined(std::vector<Observations> each, const std::vector<std::string>& names);

}  // namespace thermotwin::diagnosis
