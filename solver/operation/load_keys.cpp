// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/operation/load_keys.h"

namespace thermotwin::solver {

using core::Absent;
using core::any_number;
using core::KeyTable;
using core::non_negative;
using core::Range;
using core::required;
namespace key = core::key;

namespace {

constexpr Range duration{1e-6, 1e9};
const Absent as_before{"as before"};

const KeyTable time{
    "time",
    "Time integration of a load program.",
    {
        key::word("scheme", {"fixed", "backward_euler", "adaptive"}, "adaptive",
                  "fixed: SDIRK2, second order, with the steps `time_step_s` of the load program; backward_euler: "
                  "first order, with the same steps; adaptive: TR-BDF2 with error control."),
        key::number("tolerance_K", "K", {1e-8, 10.0}, 0.01, "adaptive: largest estimated error of a step at any node."),
        key::number("shortest_step_s", "s", {1e-6, 1e6}, 0.01,
                    "adaptive: a step of this length is accepted at any error and counted in the summary."),
        key::number("longest_step_s", "s", {1e-6, 1e7}, Absent{"21600, at least the shortest step"},
                    "adaptive: longest step."),
    }};

const KeyTable position{"position",
                        "Initial positions of the axes.",
                        {
                            key::number("<axis>_mm", "mm", any_number, Absent{"0, or the nearest end of its travel"},
                                        "Position of a linear axis within its travel."),
                            key::number("<axis>_deg", "deg", any_number, Absent{"0, or the nearest end of its travel"},
                                        "Position of a rotary axis within its travel."),
                        }};

const KeyTable axis{
    "phase.axis",
    "Motion of one axis in a phase: a range with a feed, a position, or a speed.",
    {
        key::text("id", required, "The axis."),
        key::number("duty_percent", "%", {0.0, 100.0}, 100.0, "Share of the phase in which the axis moves."),
        key::number("speed_rpm", "rpm", any_number, Absent{}, "Speed of an endless rotary axis."),
        key::number("low_mm", "mm", any_number, Absent{},
                    "Lower end of the range that a linear axis moves over; after the phase it stands at its last "
                    "stated position."),
        key::number("high_mm", "mm", any_number, Absent{}, "Its upper end."),
        key::number("feed_mm_min", "mm/min", any_number, Absent{}, "Feed over that range, up to the axis' rapid."),
        key::number("position_mm", "mm", any_number, Absent{}, "Where a linear axis stands from now on."),
        key::number("low_deg", "deg", any_number, Absent{},
                    "Lower end of the range that a rotary axis moves over; after the phase it stands at its last "
                    "stated position."),
        key::number("high_deg", "deg", any_number, Absent{}, "Its upper end."),
        key::number("feed_deg_min", "deg/min", any_number, Absent{}, "Feed over that range, up to the axis' rapid."),
        key::number("position_deg", "deg", any_number, Absent{}, "Where a rotary axis stands from now on."),
        key::flag("clamped", false,
                  "The axis is clamped in this phase, at a position that it states too; it needs the channel "
                  "`axis.<id>.clamp.on`."),
    }};

const KeyTable phase{
    "phase",
    "A stretch of time. A key that is absent keeps its value; axes that are not named stand. Numbers with *ramp* may "
    "be "
    "[from, to].",
    {
        key::text("name", Absent{"phase and its number"}, "Its name in tables."),
        key::number("duration_h", "h", duration, Absent{}, "Its length; one of the three durations is required."),
        key::number("duration_min", "min", duration, Absent{}, "Its length in minutes."),
        key::number("duration_s", "s", duration, Absent{}, "Its length in seconds."),
        key::flag("machine_on", as_before, "false: power off; no standstill losses, all coolants off."),
        key::number("spindle_rpm", "rpm", any_number, as_before, "Speed of the spindle, up to `spindle_max_rpm`."),
        key::flag("cutting_fluid", as_before,
                  "The cutting fluid runs; refused where nothing of the machine depends on it."),
        key::flag("coolant", as_before, "The coolants run; refused for a machine without [[coolant]]."),
        key::number("process_W", "W", non_negative, as_before,
                    "Power of the cutting process, of sources with `drive = \"process\"`."),
        key::number("<drive>_W", "W", non_negative, as_before,
                    "Power of a drive of machine.toml; it replaces the laws of its sources."),
        key::texts("doors_open", as_before, "Doors that stand open from now on; all others are closed."),
        key::number("<ambient>_gradient_K_m", "K/m", {-50.0, 50.0}, as_before,
                    "*ramp* Gradient of an ambient that has one.")
            .or_list(),
        key::number(
            "<ambient>_C", "degC", any_number, as_before,
            "*ramp* Temperature of an ambient, or of a volume whose temperature is given instead of its heat balance.")
            .or_list(),
        key::tables("axis", axis, Absent{"all axes stand"}, "Axes that move or are placed."),
    }};

const KeyTable load{
    "loads/*.toml",
    "A load program: what the machine does, phase by phase.",
    {
        key::schema(),
        key::text("title", Absent{"the file's name"}, "A short description."),
        key::number("initial_C", "degC", any_number, Absent{"reference_C"},
                    "Uniform temperature at the start; within `plausible_C`."),
        key::number("time_step_s", "s", {1e-3, 1e6}, 60.0,
                    "Longest step of the fixed schemes; steps end at every change of the program."),
        key::text("starts_at", Absent{"no time of day: laws over it contribute 0"},
                  "Time of day at the start, \"06:30\": the input of laws over `day.time_h`."),
        key::number("output_s", "s", {1e-3, 1e7}, 300.0, "Interval of the rows of tcp.csv, sensors.csv and heat.csv."),
        key::table("time", time, Absent{"that of case.toml, else scheme = \"fixed\""}, "How it is taken through time."),
        key::table("position", position, Absent{}, "Where axes stand at the start."),
        key::tables("phase", phase, required, "Its phases, one or more."),
    }};

}  // namespace

const KeyTable& load_keys() { return load; }
const KeyTable& time_keys() { return time; }

}  // namespace thermotwin::solver
