// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Causes that a record does not tell from simpler ones.

#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

/// A parameter that the record does not tell from a simpler cause is no cause beside it, but stays as uncertain as it
/// is: the other bodies of a material show nothing of it.
void drop_causes_like_simpler_ones(const mesh::Machine& machine, Problem& problem);

}  // namespace thermotwin::diagnosis
