// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/rtest/record_keys.h"

#include "metrology/probe/probe_setup.h"

namespace thermotwin::metrology {

using core::Absent;
using core::any_number;
using core::KeyTable;
using core::positive;
using core::required;
namespace key = core::key;

namespace {

const KeyTable axis_table{
    "axis",
    "A rotary axis of the chain.",
    {
        key::text("id", required, "Its id in the chain."),
        key::number("x_mm", "mm", any_number, 0.0,
                    "x of a point on the axis with all axes at 0, in the machine frame. The location errors of the "
                    "axis are stated at this point."),
        key::number("y_mm", "mm", any_number, 0.0, "y of this point."),
        key::number("z_mm", "mm", any_number, 0.0, "z of this point."),
        key::flag("with_letter", false,
                  "true: a positive position turns the workpiece in the positive sense about x, y or z; false: in the "
                  "negative sense, after ISO 841."),
    }};

const KeyTable record_file{
    "rtest.toml",
    "An R-Test for `measure analyse`, beside points.csv.",
    {
        key::schema(),
        key::text("chain", required, "Kinematic chain after ISO 10791-1, such as V [w C' B' b Y X Z (C1) t]."),
        key::tables("axis", axis_table, Absent{"all rotary axes pass through the origin"},
                    "One for each rotary axis that does not pass through the origin."),
        key::texts("errors", Absent{"the smallest set for the rotary axes that move"},
                   "Location errors to be estimated, such as X0C, Z0T, R0T."),
        key::number("table_radius_mm", "mm", positive, 300.0, "Radius at which R0T is stated."),
        key::number("std_um", "um", positive, required, "Standard uncertainty of one coordinate of a point."),
        key::word("reference", {"first", "absolute"}, "first",
                  "first: errors against the first cycle; absolute: errors against the nominal chain. A single cycle "
                  "is always absolute."),
        key::word("drift", {"repeated", "none"}, "repeated",
                  "repeated: the drift follows from points that a cycle measures twice, within 0.5 deg and 3 mm; none: "
                  "no drift is estimated."),
        key::whole("harmonics", 0, 12, 0.0,
                   "Highest harmonic, from 2, of the component errors of the outermost axis that moves; 0 or 1: none."),
        key::table("probes", probe_keys(), Absent{"points.csv has deviations, or the keys have their defaults"},
                   "The probes, if raw.csv has their readings."),
    }};

const KeyTable grid_file{
    "grid.toml",
    "The points of a volumetric grid for `measure analyse`, beside points.csv.",
    {
        key::schema(),
        key::text("chain", required, "Kinematic chain after ISO 10791-1, such as V [w C' B' b Y X Z (C1) t]."),
        key::tables("axis", axis_table, Absent{"all rotary axes pass through the origin"},
                    "One for each rotary axis that does not pass through the origin."),
        key::texts("errors", Absent{"those that the points distinguish"},
                   "Location errors such as X0T, C0Y, and component errors of linear axes such as EXX1, EBZ2."),
        key::whole("order", 1, 3, 1.0, "Highest power of component errors that are chosen where `errors` is absent."),
        key::number("table_radius_mm", "mm", positive, 300.0, "Radius at which R0T is stated."),
        key::number("std_um", "um", positive, required, "Standard uncertainty of one coordinate of a point."),
        key::word("reference", {"first", "absolute"}, "first",
                  "first: errors against the first cycle; absolute: errors against the nominal chain. A single cycle "
                  "is always absolute."),
        key::word("drift", {"repeated", "none"}, "repeated",
                  "repeated: the drift follows from points that a cycle measures twice, within 0.5 deg and 3 mm; none: "
                  "no drift is estimated."),
    }};

}  // namespace

const KeyTable& record_keys() { return record_file; }
const KeyTable& grid_keys() { return grid_file; }

}  // namespace thermotwin::metrology
