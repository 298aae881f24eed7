// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/systems/names_keys.h"

namespace thermotwin::reduction {

using core::Absent;
using core::any_number;
using core::KeyTable;
using core::required;
namespace key = core::key;

namespace {

const KeyTable film{
    "film",
    "A matrix A_film_NAME.mtx that a film coefficient multiplies.",
    {
        key::text("name", required, "The NAME of the file."),
        key::number("value", "its unit", any_number, required, "The coefficient at which the system stands."),
        key::text("unit", "", "Its unit."),
    }};

const KeyTable input{"input",
                     "A column of B, in order.",
                     {
                         key::text("name", required, "Its name."),
                         key::number("value", "its unit", any_number, Absent{}, "Its size in a load."),
                         key::text("unit", "", "Its unit."),
                     }};

const KeyTable output{"output",
                      "A row of C, in order.",
                      {
                          key::text("name", required, "Its name."),
                          key::number("value", "its unit", any_number, Absent{}, "Not used."),
                          key::text("unit", "", "Its unit."),
                      }};

const KeyTable names{"names.toml",
                     "Names of the films, inputs and outputs of matrices; beside them, optional.",
                     {
                         key::schema(),
                         key::tables("film", film, Absent{}, "None, or one for each film matrix."),
                         key::tables("input", input, Absent{}, "None, or one for each column of B."),
                         key::tables("output", output, Absent{}, "None, or one for each row of C."),
                     }};

}  // namespace

const KeyTable& names_keys() { return names; }

}  // namespace thermotwin::reduction
