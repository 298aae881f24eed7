// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What held-out time says: it was never fitted. Residuals per channel, the gain of the extended
// machine at the TCP with its interval.

#include "diagnosis/inference/model_search.h"
#include "diagnosis/judge/diagnosis.h"

namespace thermotwin::diagnosis {

/// Share of the residual's mean square (each channel in units of what is expected of it) that a
/// prediction takes away on held-out time, percent; negative where it makes things worse.
double heldout_explained_percent(const Problem& problem, const Eigen::VectorXd& predicted);

/// Fills residuals, series and the gain. @param best  hypothesis with its prediction
void judge(const Problem& problem, const Hypothesis& best, Diagnosis& out);

/// Why the causes that a verdict names (alone or beside others) do not hold: on held-out time they make the
/// displacements 1.5 times worse, with 95 % confidence, and what it shows is not what they foretell, see
/// heldout_chi_square. Empty where they do hold.
std::string heldout_objection(const Diagnosis& diagnosis, double chi_square);

/// Why held-out time speaks against correcting what is named: it surely worsens the displacements, or a channel that it
/// takes further off than expected. Empty: it does not.
std::string worsened(const Diagnosis& diagnosis);

/// Whether the 95 % interval of the gain lies above zero: of the displacements; where the causes
/// are readings, of the channels that they are of; where no displacement was measured, of the temperatures.
bool worth_extending(const Problem& problem, const Hypothesis& best, const Diagnosis& diagnosis);

}  // namespace thermotwin::diagnosis
