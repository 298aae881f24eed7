// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Each figure that a verification test compares is checked here, and becomes a row of README.md. A
// run of the whole program with THERMOTWIN_VERIFICATION_TABLE=FILE writes that table anew; every
// other run checks that the row is in README.md and that its figure is still true.

#include <string>

namespace thermotwin::test {

/// What is compared: a case, where its numbers are from, the quantity with its unit.
struct Figure {
  std::string name, source, quantity;
};

/// Expects |ours - reference| <= tolerance.
void expect_value(const Figure& figure, double reference, double ours, double tolerance);

/// Expects an observed order within 0.1 of theory.
void expect_order(const Figure& figure, double theory, double observed);

/// Expects an error below a bound that is rounding or the tolerance of a solver; the table says the
/// bound, since the error itself differs between machines.
void expect_below(const Figure& figure, double bound, double error);

}  // namespace thermotwin::test
