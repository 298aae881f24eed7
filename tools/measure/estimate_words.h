// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Estimates of cycles on the terminal: a table, and sentences on their uncertainty and residuals.

#include <string>

#include "metrology/fit/estimates.h"
#include "metrology/rtest/analysis.h"

namespace thermotwin::tools {

/// A table of cycles, of many errors of the last cycle alone, with what is not observable and not estimated.
std::string text_of(const metrology::Estimates& estimates);

/// The residual of all cycles by a chi-square test: what is above the stated uncertainty comes from errors that are
/// not estimated, or the stated uncertainty is too small.
std::string residual_words(const metrology::Estimates& estimates, double std);

/// The same of probes around a mandrel, whose stated uncertainties may differ.
std::string misfit_words(const metrology::ResidualTest& test);

}  // namespace thermotwin::tools
