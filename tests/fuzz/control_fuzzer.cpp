// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes are a control profile of a five-axis machine or an InputError. The limits of one that was read are above 0,
// and no text of it leaves a comment of the program.
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/error.h"
#include "nc/control/control_profile.h"
#include "tests/fuzz/require.h"
#include "tests/machines/five_axis.h"

using namespace thermotwin;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const mesh::Machine machine = compensation::test::five_axis_machine();
  try {
    const nc::ControlProfile profile =
        nc::ControlProfile::parse(std::string(reinterpret_cast<const char*>(data), size), "fuzz.toml", machine);
    require(profile.axes.size() == machine.axes.size(), "limits of each axis");
    for (const nc::AxisLimits& axis : profile.axes) require(axis.speed > 0 && axis.acceleration > 0, "an axis moves");
    require(profile.moves >= 1 && profile.seconds >= 1 && profile.look_ahead >= 1, "limits above 0");
    for (const nc::WordRule& rule : profile.words)
      require((rule.by + rule.with + rule.says).find_first_of("()\n;") == std::string::npos, "text stays in its place");
  } catch (const core::InputError&) {}
  return 0;
}
