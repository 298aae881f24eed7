// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Whether a measurement fits a machine, and its channels as rows of the machine's.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "compensation/measurement/measurement.h"
#include "mesh/machine/machine.h"
#include "mesh/machine/plausible_range.h"
#include "solver/operation/channels.h"

namespace thermotwin::compensation {

/// A record that states its machine belongs to this one. @param machine  its name; empty: not known
/// @param of  file or folder whose machine it is  @throws InputError with both names
void require_recorded_on(const Measurement& measurement, const std::string& machine, const std::string& of);

/// Checks against a machine: its name is the same where stated; sensors, inputs, quantities and poses exist; units fit;
/// temperatures are plausible.
void require_fits(const Measurement& measurement, const mesh::Machine& machine);

/// Every reading in degC is a temperature that can be.
/// @throws InputError (file, line, column) for the first one outside the range, with its value if it were in kelvin
void require_plausible(const Measurement& measurement, const mesh::PlausibleRange& range);

/// The same, but a few fault codes of a logger refuse no record: where at most 1 % of a column's values, or three of
/// them where that is more, and fewer than half lie outside, they are blanked.
/// @return a sentence for each such column, with the first value and its time
/// @throws InputError as require_plausible where more lie outside
std::vector<std::string> blank_implausible(Measurement& measurement, const mesh::PlausibleRange& range);

/// Rows of channels for the measurement's intervals: row i holds from time i to i+1 (last: repeats);
/// missing values repeat the last one known (a range ends where its axis stands, Channels::update); inputs that are not
/// measured keep their defaults.
Eigen::MatrixXd channel_rows(const Measurement& measurement, const solver::Channels& channels);

/// Whether a record has the time of day, as a column or by its start.
bool tells_time_of_day(const Measurement& measurement);

}  // namespace thermotwin::compensation
