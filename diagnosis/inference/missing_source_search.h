// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A heat source that machine.toml does not have: anywhere on the skin of a body, in proportion to one
// of the inputs. Every patch of the reduced model's skin (reduction/basis/patches.h) with every input is a
// hypothesis by itself, linear in its power; all are compared through the reduced model on the
// nominal linearisation,
//   log evidence(k, j) = -1/2 log(1 + s^2 a'a) + 1/2 s^2 (a'r)^2 / (1 + s^2 a'a),
// a, r response to 1 W and residual, both white and without what nuisances take, s the prior's width;
// a power below zero is no source; its heat may enter on the patch, spread about it, or half and half. Loads act
// through what outputs see of them: a few combinations of patches that the outputs can tell from nothing carry all
// responses. What is left for the search is one hypothesis an input, at its best patch, with the prior that all its
// patches together are worth.

#include "diagnosis/causes/parameter.h"
#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

/// Adds the best places for each of the best inputs to the parameters and columns of a problem.
void add_missing_sources(Problem& problem, const Response& response, const reduction::ReducedModel& model,
                         Records records);

}  // namespace thermotwin::diagnosis
