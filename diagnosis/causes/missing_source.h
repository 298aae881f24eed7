// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A heat source that is missing in machine.toml, as a change of the machine. inference/missing_source_search.h finds
// its place and its input.

#include <string>

#include "core/table.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/record/observations.h"
#include "mesh/machine/machine.h"

namespace thermotwin::diagnosis {

/// @return the machine with the source, and with its surface if that is missing
mesh::Machine with_missing_source(const mesh::Machine& machine, const Parameter& parameter, double power_W);

/// @return the text of machine.toml with source and surface at its end, and a comment with the reason
std::string missing_source_text(const mesh::Machine& machine, const Parameter& parameter, double power_W, double std_W,
                                const std::string& why);

/// @return the power of the source along the measurement: time_s, power_W, std_W at the ends of the steps; of several
///   records each in its own time, and its number in the column record
core::Table source_series(const MissingSource& source, double power_W, double std_W, const Observations& observations,
                          const mesh::Machine& machine);

/// @return the power of a source over the power that is stated of it, where the input that it follows has a value
double relative_power(const MissingSource& source, double value);

/// @return the input that a source follows, as words: "spindle.speed_rpm", "the time of day, from 13:00 to 17:00 every
///   day"
std::string follows_in_words(const MissingSource& source);

/// @return the absolute value of a channel in a step; 0 if it is unknown
double magnitude(const Observations& observations, int channel, Eigen::Index step);

}  // namespace thermotwin::diagnosis
