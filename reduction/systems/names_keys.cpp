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
        key::number("value", "its unit", any_number, required, "Value of the coefficient where `--film` gives none."),
        key::text("unit", "", "Its unit."),
    }};

const KeyTable input{
    "input",
    "A column of B, in order.",
    {
        key::text("name", required, "Its name."),
        key::number("value", "its unit", any_number, Absent{}, "Value on a machine that stands, for information."),
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
                     "Names, units and values of films, inputs and outputs; an optional file beside the matrices.",
                     {
                         key::schema(),
                         key::tables("film", film, Absent{}, "None, or one for each film matrix."),
                         key::tables("input", input, Absent{}, "None, or one for each column of B."),
                         key::tables("output", output, Absent{}, "None, or one for each row of C."),
                     }};

}  // namespace

const KeyTable& names_keys() { return names; }

}  // namespace thermotwin::reduction
