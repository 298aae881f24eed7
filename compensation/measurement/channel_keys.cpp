// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/measurement/channel_keys.h"

namespace thermotwin::compensation {

using core::Absent;
using core::any_number;
using core::KeyTable;
using core::non_negative;
using core::required;
namespace key = core::key;

namespace {

const KeyTable pose{"channel.pose",
                    "The pose that a displacement is measured at.",
                    {
                        key::number("<axis>_mm", "mm", any_number, Absent{"0"}, "Position of a linear axis."),
                        key::number("<axis>_deg", "deg", any_number, Absent{"0"}, "Position of a rotary axis."),
                    }};

const KeyTable point{"arrangement.point",
                     "A point at which the deviation of the tool against the table is measured.",
                     {
                         key::table("pose", pose, Absent{"home"}, "The pose of the point."),
                     }};

const KeyTable arrangement{
    "arrangement",
    "The points of a test whose location errors are weighted sums of deviations; `measure analyse` writes it.",
    {
        key::text("id", required, "Id that the key `arrangement` of channels refers to."),
        key::tables("point", point, required, "One for each measured point; a point that is measured twice has two."),
    }};

const KeyTable channel_table{
    "channel",
    "A column of data.csv.",
    {
        key::text("id", required, "The column's name."),
        key::word(
            "kind", {"temperature", "displacement", "speed", "power", "position", "flow", "state"}, required,
            "The measured quantity. A state is 0 (off) to 1 (on), the gradient of an ambient in K/m, or the time of "
            "day in h."),
        key::word("unit",
                  {"degC", "K", "um", "um/m", "rpm", "mm_min", "deg_min", "W", "mm", "deg", "kg_s", "1", "K/m", "h"},
                  required,
                  "Its unit: temperature degC, K; displacement um, um/m; speed rpm, mm_min, deg_min; power W; position "
                  "mm, deg; flow kg_s; state 1, gradient K/m, time of day h."),
        key::number("uncertainty", "its unit", non_negative, Absent{"0 of an input; else required"},
                    "One standard deviation; above 0 for displacements and for temperatures without `input`."),
        key::text("sensor", "", "Id of its sensor in machine.toml."),
        key::text("input", "",
                  "Its channel of the machine: spindle.speed_rpm, axis.X.feed_mm_min, machine.on, air.T_C."),
        key::word("quantity", {"dx",  "dy",  "dz",  "ra",  "rb",  "rc",  "X0A", "Y0A", "Z0A", "A0A", "B0A",
                               "C0A", "X0B", "Y0B", "Z0B", "A0B", "B0B", "C0B", "X0C", "Y0C", "Z0C", "A0C",
                               "B0C", "C0C", "X0T", "Y0T", "Z0T", "A0T", "B0T", "C0T", "R0T"},
                  Absent{},
                  "displacement: a component of the TCP error, or a location error of an axis or of the table (T)."),
        key::table("pose", pose, Absent{"home"}, "displacement: the pose at which it is measured."),
        key::reference("arrangement", "arrangement", Absent{"prediction by definition, at the pose of the channel"},
                       "location error: id of the points from which it was computed."),
        key::numbers("weights", "its unit per um", any_number, Absent{},
                     "Three for each point of the arrangement: the error is the sum of weight times dx, dy and dz, "
                     "tool minus table in the machine frame."),
        key::word("frame", {"machine", "table"}, "machine", "displacement: the frame of its components."),
        key::word("zero", {"first", "absolute"}, "absolute",
                  "displacement: first: zero at its first value; absolute: against the machine at its reference "
                  "temperature."),
        key::text(
            "direction", "",
            "Free text. A word such as air or hall marks a channel of the surroundings. For composite_modules_grid, "
            "tool or table marks a displacement of that side alone."),
    }};

const KeyTable program_table{"program",
                             "A part of the record on which models are judged.",
                             {
                                 key::text("name", required, "Its name; \"training\" and \"day ...\" are reserved."),
                                 key::number("from_s", "s", any_number, required, "`time_s` at its start."),
                                 key::number("to_s", "s", any_number, required, "`time_s` at its end."),
                             }};

const KeyTable record{
    "record",
    "How the record was taken.",
    {key::text(
         "machine", Absent{"not stated: fits every machine with its channels"},
         "`name` in machine.toml of the recorded machine. `evaluate`, `diagnose` and `run` refuse the record with the "
         "model of another machine, and `evaluate` its use as training data for a record of another."),
     key::flag(
         "rows_at_changes", false,
         "true: each change of a speed, power or state has a row at its time. false: in rows over a minute apart a "
         "change may come late, and in a pause anything may have run."),
     key::text("starts_at", Absent{"no time of day: laws over it contribute 0"},
               "Time of day, \"06:30\", at `time_s` = 0. Laws over `day.time_h` then have their input.")}};

const KeyTable channels{
    "channels.toml",
    "The columns of a measurement's data.csv.",
    {
        key::schema(Absent{"1"}),
        key::table("record", record, Absent{}, "How the record was taken."),
        key::tables("arrangement", arrangement, Absent{}, "Points of a test that channels refer to."),
        key::tables("channel", channel_table, required, "One for each column but time_s."),
        key::tables("program", program_table, Absent{}, "Parts of the record that `evaluate` judges."),
    }};

}  // namespace

const KeyTable& channel_keys() { return channels; }

}  // namespace thermotwin::compensation
