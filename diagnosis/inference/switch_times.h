// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A measurement as a problem about the nominal machine. A log says when it saw a speed, power or state changed; a
// tangent tells well enough when that came (Observations::MayHold) to find the place, not to leave it there, since what
// heats within a row is not
// in proportion to the part of it. So changes are moved, as long as the record fits better with them there without any
// cause, and told anew about there.

#include <memory>

#include "diagnosis/record/diagnose_options.h"
#include "diagnosis/response/problem.h"
#include "reduction/model/reduced_model.h"

namespace thermotwin::diagnosis {

struct Seen {
  std::unique_ptr<const Observations> observations;  ///< the response refers to it for its whole life
  std::unique_ptr<const Response> response;
  Problem problem;  ///< about nominal
};

/// @param records  with_record_names()  @throws InputError as observe
Seen see(const reduction::ReducedModel& model, Records records, const DiagnoseOptions& options);
inline Seen see(const reduction::ReducedModel& model, const compensation::Measurement& measurement,
                const DiagnoseOptions& options) {
  return see(model, Records(&measurement, 1), options);
}

}  // namespace thermotwin::diagnosis
