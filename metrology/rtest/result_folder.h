// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Location errors of an R-Test as a measurement folder for `evaluate` and `diagnose`, alone or beside the loads and
// temperatures of a record that was taken meanwhile.

#include <filesystem>
#include <optional>

#include "compensation/measurement/measurement.h"
#include "core/table.h"
#include "metrology/rtest/analysis.h"
#include "metrology/rtest/test_points.h"

namespace thermotwin::metrology {

/// time_s, then each error that is observable (X0C_um, A0C_um_per_m) with its standard uncertainty (std_X0C_um).
core::Table error_table(const Estimates& estimates);

/// @throws InputError (place) unless the text is empty or positions of axes, "X=0,B=90"
void require_pose_text(const std::string& text, const std::string& place);

/// Whether a channel can have this quantity: dx ... rc, a location error of a rotary axis or of the table.
bool is_quantity(const std::string& name);

/// One displacement channel for each quantity that is observable in all cycles, with its largest standard uncertainty.
/// Rows of both are merged by time; a channel is blank where only the other has a row.
/// @param pose  of the channels  @param against_first  their zero
/// @param beside  the record of loads and temperatures @throws InputError for a channel that both have
compensation::Measurement measurement_of(const Estimates& estimates, const std::string& pose, bool against_first,
                                         const std::optional<compensation::Measurement>& beside);
/// With the points and weights of common_points(), by which a machine predicts them. Cycles with other points are
/// blank. Where there are none in common, the channels have the pose of the first point alone.
compensation::Measurement measurement_of(const RTestRecord& record, const RTestAnalysis& analysis,
                                         const TestPoints& points,
                                         const std::optional<compensation::Measurement>& beside);
compensation::Measurement measurement_of(const RTestRecord& record, const RTestAnalysis& analysis,
                                         const std::optional<compensation::Measurement>& beside);

/// The deviations themselves: dx, dy and dz of the TCP error at each place of a discrete test, "dx@1", at the times
/// of the points. A place that a cycle measures twice has its first deviation.
/// @throws InputError: a cycle with more than most_places points, a channel that both have
compensation::Measurement points_measurement_of(const RTestRecord& record,
                                                const std::optional<compensation::Measurement>& beside);
inline constexpr std::size_t most_places = 40;

}  // namespace thermotwin::metrology
