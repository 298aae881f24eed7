// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A hypothesis is a change to the machine: one parameter of one item of machine.toml (or of a
// measured channel) with its nominal value and a prior width when it is a cause. The same change
// acts on the full model, the reduced one and machine.toml.

#include <memory>
#include <string>
#include <vector>

#include "compensation/measurement/measurement.h"
#include "diagnosis/causes/parameter.h"
#include "mesh/machine/machine.h"

namespace thermotwin::diagnosis {

/// The machine with the parameter at the value. A sensor's offset is that of the sensor that the
/// channel reads. The text of the machine is left as it was. @throws InputError: no such item
mesh::Machine with_parameter(const mesh::Machine& machine, const Parameter& parameter, double value);

/// machine.toml's text with the named value changed and a comment that says why; nothing else
/// differs. @throws InputError if the key cannot be found in the text
std::string extended_text(const mesh::Machine& machine, const Parameter& parameter, double value, double std,
                          const std::string& why);

}  // namespace thermotwin::diagnosis
