// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A heat source that machine.toml does not have, as a change to the machine. Its place and input are found by
// inference/missing_source_search.h.

#include <string>

#include "core/table.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/record/observations.h"
#include "mesh/machine/machine.h"

namespace thermotwin::diagnosis {

/// The machine with the source; its surface too, if it is not there yet.
mesh::Machine with_missing_source(const mesh::Machine& machine, const Parameter& parameter, double power_W);

/// machine.toml's text with both at its end, and a comment that says why.
std::string missing_source_text(const mesh::Machine& machine, const Parameter& parameter, double power_W, double std_W,
                                const std::string& why);

/// Heat of the source along the measurement: time_s, power_W, std_W at the ends of the steps.
core::Table source_series(const MissingSource& source, double power_W, double std_W, const Observations& observations,
                          const mesh::Machine& machine);

/// Size of a channel's value in a step; 0 where it is not known.
double magnitude(const Observations& observations, int channel, Eigen::Index step);

}  // namespace thermotwin::diagnosis
