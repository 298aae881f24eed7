// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A heat source that machine.toml does not have: anywhere on the skin of a body, in proportion to one
// of the inputs. Every patch of the reduced model's skin (reduction/patches.h) with every input is a
// hypothesis by itself, linear in its power; all are compared through the reduced model on the
// nominal linearisation,
//   log evidence(k, j) = -1/2 log(1 + s^2 a'a) + 1/2 s^2 (a'r)^2 / (1 + s^2 a'a),
// a, r response to 1 W and residual, both white and without what nuisances take, s the prior's width;
// a power below zero is no source; its heat may enter on the patch, spread about it, or half and half. Loads act through what outputs see of them: a few combinations of
// patches that the outputs can tell from nothing carry all responses. What is left for the search is
// one hypothesis an input, at its best patch, with the prior that all its patches together are worth.

#include "diagnosis/problem.h"

namespace thermotwin::diagnosis {

/// Adds the best places for each of the best inputs to the parameters and columns of a problem.
void add_missing_sources(Problem& problem, const Response& response, const reduction::ReducedModel& model,
                         const compensation::Measurement& measurement);

/// The machine with the source; its surface too, if it is not there yet.
mesh::Machine with_missing_source(const mesh::Machine& machine, const Parameter& parameter, double power_W);

/// machine.toml's text with both at its end, and a comment that says why.
std::string missing_source_text(const mesh::Machine& machine, const Parameter& parameter, double power_W, double std_W, const std::string& why);

/// Heat of the source along the measurement: time_s, power_W, std_W at the ends of the steps.
core::Table source_series(const MissingSource& source, double power_W, double std_W, const Observations& observations, const mesh::Machine& machine);

}  // namespace thermotwin::diagnosis
