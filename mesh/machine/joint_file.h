// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Reads [[surface]], [[joint]] and [[scale]] of machine.toml. All functions throw InputError with file, line and key.

#include "mesh/machine/reader.h"

namespace thermotwin::mesh::reader {

SurfaceSpec read_surface_spec(const core::Node& node, Draft& draft);

JointSpec read_joint(const core::Node& node, Draft& draft);

ScaleSpec read_scale(const core::Node& node, Draft& draft);

}  // namespace thermotwin::mesh::reader
