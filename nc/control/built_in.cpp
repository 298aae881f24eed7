// SPDX-License-Identifier: GPL-3.0-or-later
#include "nc/control/built_in.h"

namespace thermotwin::nc {

const char* const linuxcnc_profile = R"(schema = 1
name = "linuxcnc"
[[word]]
word = "M428"
action = "tcp_on"
[[word]]
word = "M429"
action = "tcp_off"
[[word]]
word = "M430"
action = "refuse"
says = "switches to kinematics of the user"
)";

const char* const fanuc_profile = R"(schema = 1
name = "fanuc"
dialect = "fanuc"
[[word]]
word = "G43.4"
action = "tcp_on"
by = "G43"
[[word]]
word = "G43.5"
action = "refuse"
says = "tool axis by vector"
[[word]]
word = "G49"
action = "tcp_off"
by = "G49"
[[word]]
word = "G5"
action = "skip"
with = "P"
[[word]]
word = "G5.1"
action = "skip"
with = "QRXYZABCUVW"
[[word]]
word = "G8"
action = "skip"
with = "P"
[[word]]
word = "G68"
action = "refuse"
says = "coordinate rotation"
[[word]]
word = "G68.2"
action = "refuse"
says = "tilted working plane"
[[word]]
word = "G53.1"
action = "refuse"
says = "tilted working plane"
[[word]]
word = "G41.2"
action = "refuse"
says = "three-dimensional cutter compensation"
[[word]]
word = "G42.2"
action = "refuse"
says = "three-dimensional cutter compensation"
[[word]]
word = "G7"
action = "refuse"
says = "switches to diameters in LinuxCNC"
[[word]]
word = "G10.9"
action = "refuse"
[[word]]
word = "G69"
action = "skip"
[[word]]
word = "M10"
action = "skip"
[[word]]
word = "M11"
action = "skip"
[[word]]
word = "M88"
action = "skip"
[[word]]
word = "M89"
action = "skip"
)";

const char* const siemens_profile = R"(schema = 1
name = "siemens"
dialect = "siemens"
[[word]]
word = "M10"
action = "skip"
[[word]]
word = "M11"
action = "skip"
[[word]]
word = "M40"
action = "skip"
[[word]]
word = "CYCLE800"
action = "refuse"
says = "tilts the working plane"
)";

}  // namespace thermotwin::nc
