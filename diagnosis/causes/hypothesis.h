// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A hypothesis is a change of the machine: one parameter of one item of machine.toml, or of a measured channel, with
// its nominal value and the prior width that it has as a cause. The same change applies to the full model, to the
// reduced model and to machine.toml.

#include <memory>
#include <string>
#include <vector>

#include "compensation/measurement/measurement.h"
#include "diagnosis/causes/machine_in_time.h"
#include "diagnosis/causes/parameter.h"
#include "mesh/machine/machine.h"

namespace thermotwin::diagnosis {

/// @return the machine with the parameter at the value; its text is unchanged. A step is a LaterFactor. A sensor's
///   offset is that of the sensor which the channel reads. @throws InputError if there is no such item
MachineInTime with_parameter(const MachineInTime& machine, const Parameter& parameter, double value);

/// @return the text of machine.toml with the value changed and a comment with the reason; nothing else differs
/// @throws InputError if the key is not found in the text
std::string extended_text(const mesh::Machine& machine, const Parameter& parameter, double value, double std,
                          const std::string& why);

}  // namespace thermotwin::diagnosis
