// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/budget/budget_keys.h"

namespace thermotwin::metrology {

using core::Absent;
using core::any_number;
using core::KeyTable;
using core::non_negative;
using core::positive;
using core::Range;
using core::required;
namespace key = core::key;

namespace {

const KeyTable input_table{
    "input",
    "An input quantity.",
    {
        key::text("name", required, "Its name in formulas: a letter, then letters, digits and _."),
        key::text("unit", "", "Its unit, for the tables."),
        key::text("says", "", "Its meaning, for the tables."),
        key::word("distribution", {"normal", "rectangular", "triangular", "arcsine"}, "normal",
                  "Its distribution. With finite degrees of freedom a normal one becomes a scaled t distribution; of "
                  "any other one the half width is drawn too."),
        key::number("value", "its unit", any_number, Absent{"0, or the mean of the readings"}, "Its estimate."),
        key::number("std", "its unit", non_negative, Absent{"half_width or readings"},
                    "Its standard uncertainty; a normal distribution without readings requires it."),
        key::number("half_width", "its unit", non_negative, Absent{"std or readings"},
                    "Half of the range of a rectangular, triangular or arcsine distribution, in place of std."),
        key::numbers(
            "readings", "its unit", any_number, Absent{"std or half_width"},
            "Repeated readings. The estimate is their mean; its uncertainty has one degree of freedom fewer than there "
            "are readings."),
        key::number("degrees_of_freedom", "1", Range{1.0, 1e300}, Absent{"without limit"},
                    "Degrees of freedom nu of a stated std or half_width, for a half_width at least 1.5. The half "
                    "width is drawn from a rectangular distribution with the relative standard uncertainty "
                    "1 / sqrt(2 nu)."),
    }};

const KeyTable correlation_table{
    "correlation",
    "A correlation of two inputs.",
    {
        key::texts("between", required, "The names of two inputs."),
        key::number("coefficient", "1", Range{-1.0, 1.0}, required, "The correlation coefficient."),
    }};

const KeyTable quantity_table{
    "quantity",
    "A measurand.",
    {
        key::text("name", required, "Its name, as that of an input; later formulas may use it."),
        key::text(
            "formula", required,
            "Its formula of inputs and of the quantities before it: + - * / ^, comparisons, functions such as sqrt, "
            "sin (rad), ln, atan2, min, max, and pi; docs/explanation/metrology.md has all."),
        key::text("unit", "", "Its unit, for the tables."),
    }};

const KeyTable coverage_table{
    "coverage",
    "How wide the intervals are.",
    {
        key::number("probability", "1", Range{0.5, 0.9999}, 0.95,
                    "Coverage probability of the intervals. If `factor` alone is stated, it is the probability of that "
                    "factor for a normal distribution."),
        key::number("factor", "1", positive, Absent{"from the probability and the effective degrees of freedom"},
                    "Coverage factor k of the expanded uncertainty."),
    }};

const KeyTable monte_carlo_table{
    "monte_carlo",
    "The propagation of distributions.",
    {
        key::whole("draws", 10000, 10000000, 1e6, "Number of draws."),
        key::whole("seed", 0, 2147483647, 1.0, "Seed of the random numbers."),
        key::whole("digits", 1, 2, 2.0,
                   "Significant digits of the standard uncertainty. The tolerance between the intervals of both "
                   "methods is half a unit of the last one."),
    }};

const KeyTable budget_file{
    "BUDGET.toml",
    "An uncertainty budget for `measure uncertainty`.",
    {
        key::schema(),
        key::text("says", "", "What is measured, for the tables."),
        key::tables("input", input_table, required, "One for each input quantity."),
        key::texts("simultaneous", Absent{"none"},
                   "Names of inputs whose readings were taken together: their correlation follows from the readings."),
        key::tables("correlation", correlation_table, Absent{"inputs are independent"},
                    "One for each correlated pair."),
        key::tables("quantity", quantity_table, required, "One for each measurand."),
        key::table("coverage", coverage_table, Absent{}, "How wide the intervals are."),
        key::table("monte_carlo", monte_carlo_table, Absent{}, "The propagation of distributions."),
    }};

}  // namespace

const KeyTable& budget_keys() { return budget_file; }

}  // namespace thermotwin::metrology
