// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/plan/plan_keys.h"

namespace thermotwin::study {

using core::Absent;
using core::any_number;
using core::KeyTable;
using core::positive;
using core::required;
namespace key = core::key;

namespace {

const KeyTable parameter_table{
    "parameter",
    "A parameter of the machine that differs between variants: fixed values, or a distribution to draw from.",
    {
        key::text("kind", required, "A kind of diagnosis.json that acts on the machine, such as `source_power`."),
        key::texts("where", required,
                   "Ids of items as in diagnosis.json; `*` is every item with a std_percent in machine.toml."),
        key::numbers("values", "of the kind", any_number, Absent{"drawn"},
                     "Values of which every combination is computed: factors on the nominal value, or values that are "
                     "added to it, as the kind says."),
        key::numbers("range", "of the kind", any_number, Absent{"normal"},
                     "Lowest and highest value of a uniform distribution."),
        key::number("std_percent", "%", positive, Absent{"std_percent of machine.toml"},
                    "Standard deviation of a factor, normal within 2.5 standard deviations."),
        key::number("std", "of the kind", positive, Absent{"std_percent"},
                    "Standard deviation of an added value, normal within 2.5 standard deviations."),
    }};

const KeyTable plan_file{
    "PLAN.toml",
    "A plan for `study variants`.",
    {
        key::schema(),
        key::text("title", "", "Its meaning, for the report."),
        key::text("case", required, "The case folder or case.toml, absolute or from the plan's folder."),
        key::texts("loads", Absent{"holdout of the case"}, "Load programs that every variant runs."),
        key::texts("size", Absent{"size of the case"},
                   "Mesh sizes: coarse, standard, fine or factors on the element sizes; each is a group of results."),
        key::whole("samples", 0, 100000, 0.0,
                   "Number of machines drawn for each mesh size and each combination of fixed values."),
        key::word("sampling", {"latin", "random", "pick_freeze"}, "latin",
                  "A Latin hypercube; independent draws; or the design of Saltelli, with samples x (parameters + 2) "
                  "machines."),
        key::whole("seed", 0, 2147483647, 1.0, "Seed of the draws."),
        key::whole("block", 1, 1000, 12.0, "Largest number of variants that one unit of work computes side by side."),
        key::tables("parameter", parameter_table, Absent{"the machine as stated alone"},
                    "One for each kind of parameter that differs."),
    }};

}  // namespace

const KeyTable& variant_plan_keys() { return plan_file; }

}  // namespace thermotwin::study
