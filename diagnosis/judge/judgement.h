// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Judges a diagnosis on held-out data: residuals per channel, and the gain of the extended machine at the TCP with its
// confidence interval.

#include "diagnosis/inference/model_search.h"
#include "diagnosis/judge/diagnosis.h"

namespace thermotwin::diagnosis {

/// @return the share of the residual's mean square, each channel in units of its expected standard deviation, that a
///   prediction removes on held-out data, percent; negative if it worsens the residual
double heldout_explained_percent(const Problem& problem, const Eigen::VectorXd& predicted);

/// By how many nats a cause that stands beside something unknown is wrong, as held-out data say: if the correction
/// removes a share s of their residual's mean square, what is left is worth (1 - s) / s of what the cause gained.
/// @param h  refined   @param unknown_channels  those that something unknown is in alone, which say nothing here
/// @return 0 if these data hardly show what it changes
double heldout_misfit(const Problem& problem, const Hypothesis& h, const std::vector<std::size_t>& unknown_channels);

/// Fills residuals, series and the gain. @param best  hypothesis with its prediction
void judge(const Problem& problem, const Hypothesis& best, Diagnosis& out);

/// @return the objection to the named causes if they increase the residual of the displacements on held-out data by a
///   factor of 1.5 with 95 % confidence and do not predict these data (heldout_chi_square); else an empty text
std::string heldout_objection(const Diagnosis& diagnosis, double chi_square);

inline constexpr double shows_little =
    0.25;  ///< of the fitted data's share: held-out data with less cannot judge a gain
inline constexpr double not_foretold = 1.5;  ///< chi-square of a mean that was held out

/// @return why held-out data speak against the correction: it surely worsens the displacements, or takes a channel
///   further off than expected; empty if they do not
std::string worsened(const Diagnosis& diagnosis);

/// @return why a named missing source may be the heat of a source whose power is not recorded; empty: it may not
std::string perhaps_unrecorded(const mesh::Machine& machine, const compensation::Measurement& measurement,
                               const Diagnosis& diagnosis);

/// @return whether the 95 % interval of the gain lies above zero. The gain is that of the displacements; for causes in
///   readings that of their channels; without displacements that of the temperatures
bool worth_extending(const Problem& problem, const Hypothesis& best, const Diagnosis& diagnosis);

}  // namespace thermotwin::diagnosis
