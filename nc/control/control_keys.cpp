// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/control/control_keys.h"

namespace thermotwin::nc {

using core::Absent;
using core::any_number;
using core::KeyTable;
using core::non_negative;
using core::positive;
using core::required;
namespace key = core::key;

namespace {

const KeyTable word_table{
    "word",
    "A word of the control that LinuxCNC's interpreter does not know, or means otherwise.",
    {
        key::text("word", required, "Letter and number: G43.4, M428; of Siemens programs also a name: CYCLE832."),
        key::word("action", {"skip", "replace", "tcp_on", "tcp_off", "refuse"}, required,
                  "skip: left out; replace: `by` takes its place; tcp_on, tcp_off: tool centre point control begins or "
                  "ends, with `by` in its place; refuse: the program is refused at its line."),
        key::text("by", Absent{"nothing"}, "Words in its place."),
        key::text("with", Absent{"none"}, "Letters of later words of the line that are left out with it: QR."),
        key::text("says", Absent{}, "Reason in the message of a refused word."),
    }};

const KeyTable axis_table{
    "axis",
    "Limits of an axis that machine.toml does not state.",
    {
        key::text("id", required, "Its id in machine.toml."),
        key::number("acceleration_m_s2", "m/s2", {1e-3, 1e3}, Absent{"`acceleration_m_s2` of the file"},
                    "Largest acceleration of a linear axis."),
        key::number("acceleration_deg_s2", "deg/s2", {1e-2, 1e6}, Absent{"`acceleration_deg_s2` of the file"},
                    "Largest acceleration of a rotary axis."),
        key::number("rapid_mm_min", "mm/min", positive, Absent{"that of machine.toml"}, "Largest feed, linear."),
        key::number("rapid_deg_min", "deg/min", positive, Absent{"that of machine.toml"}, "Largest feed, rotary."),
    }};

const KeyTable offset_table{
    "work_offset",
    "A work offset as the control has it before the program: machine position of the program's zero.",
    {
        key::whole("number", 1, 9, required, "1: G54 ... 6: G59, 7 to 9: G59.1 to G59.3."),
        key::number("<axis>_mm", "mm", any_number, 0.0, "Of a linear axis."),
        key::number("<axis>_deg", "deg", any_number, 0.0, "Of a rotary axis."),
        key::number("rotation_deg", "deg", any_number, 0.0, "Rotation of X and Y about its zero."),
    }};

const KeyTable tool_table{"tool",
                          "A tool.",
                          {
                              key::whole("number", 1, 99999, required, "Its number, as T calls it."),
                              key::text("name", Absent{"none"}, "Its name, as T=\"NAME\" calls it."),
                              key::number("length_mm", "mm", any_number, 0.0, "Length offset along Z."),
                              key::number("diameter_mm", "mm", non_negative, 0.0, "Diameter."),
                          }};

const KeyTable limit_table{
    "limits",
    "Where a program is stopped that does not end.",
    {
        key::number("moves", "1", {1.0, 1e10}, Absent{"100 for each line of the program, 1e6 to 2e7"}, "Moves."),
        key::number("lines_without_move", "1", {1.0, 1e10}, 1e6, "Lines in a row that move nothing."),
        key::number("seconds", "s", {1.0, 1e5}, 600.0, "Processor time of the interpreter."),
    }};

const KeyTable control_file{
    "control.toml",
    "A control profile for `nc --control`: words, limits, tools and work offsets of a control.",
    {
        key::schema(),
        key::text("name", Absent{"the file's name"}, "Name in messages."),
        key::word("dialect", {"rs274", "fanuc", "siemens"}, "rs274",
                  "Language of the programs: LinuxCNC's; the same with dwells, feeds and parameters as Fanuc controls "
                  "mean them; that of Sinumerik controls."),
        key::flag("block_delete", true, "Lines that begin with / are left out; false: they run."),
        key::number("arc_radius_tolerance_mm", "mm", non_negative, 0.01,
                    "Largest difference between the radii of an arc at its start and end."),
        key::number("blend_tolerance_mm", "mm", positive, 0.02,
                    "Deviation at a corner where the program states none; it sets the speed there."),
        key::flag("overlaps_corners", false,
                  "Sharp corners: a block brakes while the next one accelerates, each with half of the acceleration "
                  "(LinuxCNC); else they are rounded."),
        key::number("block_cycle_s", "s", {0.0, 1.0}, 0.0,
                    "Shortest time of a path element: the control takes blocks no faster."),
        key::number("acceleration_m_s2", "m/s2", {1e-3, 1e3}, 3.0, "Acceleration of linear axes."),
        key::number("acceleration_deg_s2", "deg/s2", {1e-2, 1e6}, 1500.0, "Acceleration of rotary axes."),
        key::whole("look_ahead", 1, 100000, 500.0, "Path elements that the control looks ahead."),
        key::number("tool_change_s", "s", non_negative, 5.0, "Duration of a tool change."),
        key::number("program_stop_s", "s", non_negative, 0.0, "Assumed duration of M0 and M1."),
        key::number("spindle_start_s", "s", non_negative, 1.0, "Wait for the spindle at M3, M4 and a new S word."),
        key::tables("word", word_table, Absent{"none"}, "Words that are skipped, replaced or refused."),
        key::tables("axis", axis_table, Absent{"none"}, "Limits of single axes."),
        key::tables("tool", tool_table, Absent{"none"}, "Tools; `--tools` reads a table of LinuxCNC instead."),
        key::tables("work_offset", offset_table, Absent{"all zero"}, "Work offsets before the program."),
        key::table("limits", limit_table, Absent{"the defaults"}, "Limits of the interpreter."),
    }};

}  // namespace

const KeyTable& control_keys() { return control_file; }

}  // namespace thermotwin::nc
