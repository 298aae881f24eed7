// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Checks the points of sensors, scales, screws and the TCP. A sensor reads the nearest point of its body, which is
// right beside a faceted cylinder; a point far from the body is a mistake in a digit or in the body's id. A scale may
// stand off it.

#include <vector>

#include "mesh/body/tet_mesh.h"
#include "mesh/machine/machine.h"

namespace thermotwin::mesh {

/// @throws InputError for a sensor that lies further outside its body than the body's element size
void check_sensors(const Machine& machine, const std::vector<TetMesh>& bodies);

/// Warns of a tool or table point that lies far from the box of its body, or that reaches it when taken in metres.
void check_tcp(const Machine& machine, const std::vector<TetMesh>& bodies);

/// Warns of a tool point that lies sideways of the middle of its surface by more than a tenth of the surface's extent:
/// the growth of the body between the two is then not in the TCP error.
/// @param surfaces  triangles of each of Machine::surfaces
void check_tool_surface(const Machine& machine, const std::vector<TetMesh>& bodies,
                        const std::vector<std::vector<int>>& surfaces);

/// Warns of a nut or a fixed bearing that lies further beside the screw's body than the body is thick.
void check_screws(const Machine& machine, const std::vector<TetMesh>& bodies);

/// Warns of a scale whose tape or reading head is further from its body than a tenth of the body's diagonal.
void check_scales(const Machine& machine, const std::vector<TetMesh>& bodies);

}  // namespace thermotwin::mesh
