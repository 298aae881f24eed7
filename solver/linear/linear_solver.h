// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace thermotwin::solver {

/// By a sparse factor, or by conjugate gradients with multigrid.
enum class LinearSolver { direct, iterative };

}  // namespace thermotwin::solver
