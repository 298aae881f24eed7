// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Location errors of an R-Test as a measurement folder for `evaluate` and `diagnose`, alone or together with the loads
// and temperatures of a record that was taken during the test.

#include <filesystem>
#include <optional>

#include "compensation/measurement/measurement.h"
#include "core/table.h"
#include "metrology/rtest/analysis.h"
#include "metrology/rtest/test_points.h"

namespace thermotwin::metrology {

/// @return a row for each cycle: time_s, the observable errors (X0C_um, A0C_um_per_m), their standard uncertainties
///   (std_X0C_um)
core::Table error_table(const Estimates& estimates);

/// @throws InputError (place) unless the text is empty or positions of axes, "X=0,B=90"
void require_pose_text(const std::string& text, const std::string& place);

/// Whether a channel can have this quantity: dx ... rc, a location error of a rotary axis or of the table.
bool is_quantity(const std::string& name);

/// @return one displacement channel for each quantity that is observable in all cycles; its uncertainty is the largest
///   of the cycles. Rows of test and record are merged by time; a channel is blank where it has no row.
/// @param pose           pose of the channels
/// @param against_first  the zero of the channels is the first cycle; else the nominal machine
/// @param beside         record of loads and temperatures  @throws InputError for a channel that test and record have
compensation::Measurement measurement_of(const Estimates& estimates, const std::string& pose, bool against_first,
                                         const std::optional<compensation::Measurement>& beside);
/// The same, with the points and weights of common_points() in each channel, from which a model predicts the location
/// errors. Cycles with other points are blank. Without common points the channels have the pose of the first point.
compensation::Measurement measurement_of(const RTestRecord& record, const RTestAnalysis& analysis,
                                         const TestPoints& points,
                                         const std::optional<compensation::Measurement>& beside);
compensation::Measurement measurement_of(const RTestRecord& record, const RTestAnalysis& analysis,
                                         const std::optional<compensation::Measurement>& beside);

/// The deviations themselves: dx, dy and dz of the TCP error at each place of a discrete test, "dx@1", at the times
/// of the points. If a cycle measures a place twice, the first deviation is taken.
/// @throws InputError: a cycle with more than most_places points, a channel that both have
compensation::Measurement points_measurement_of(const RTestRecord& record,
                                                const std::optional<compensation::Measurement>& beside);
inline constexpr std::size_t most_places = 40;

}  // namespace thermotwin::metrology
