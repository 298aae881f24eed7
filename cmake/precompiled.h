// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// Headers that most sources include, compiled once (THERMOTWIN_PRECOMPILED).
/// Each source still includes all that it uses, because the preset of the fuzzers builds without this file.
#include <Eigen/Dense>
#include <Eigen/SparseCore>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "core/dense_algebra.h"
#include "core/matrix_kernels.h"
