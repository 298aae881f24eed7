// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A ridge line through several load programs, its strength chosen by leaving out one whole program after the other:
// rows of one program resemble each other, so a held-out part of a program says little about another one.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "compensation/models/least_squares.h"

namespace thermotwin::compensation {

struct ProgramRows {
  Eigen::MatrixXd features;  ///< (rows x features)
  Eigen::VectorXd target;    ///< (rows)
};

struct ProgramLine {
  Line line;
  double ridge = 0;         ///< see fit_ridge
  double held_out_rms = 0;  ///< root of the mean over programs left out; of the fit where there is one program only
};

/// Rows with NaN are left out. @throws InputError (place) with fewer than three rows, or without a finite fit
ProgramLine fit_on_programs(const std::vector<ProgramRows>& programs, const std::vector<double>& ridges,
                            const std::string& place);

}  // namespace thermotwin::compensation
