// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Files of others go through libraries that a damaged file can crash or hold for ever. So a body is read and
// meshed in a child process with limits; the child's death is an error that names the file.

#include <functional>
#include <string>

#include "core/error.h"
#include "mesh/body/tet_mesh.h"

namespace thermotwin::mesh {

/// The mesher failed on geometry that has no fault of its own: other settings may succeed.
class MesherError : public core::MeshError {
public:
  using core::MeshError::MeshError;
};

struct ImportLimits {
  double processor_s = 1200;  ///< processor time of one body
  double memory_bytes = 0;    ///< address space; 0: twice the memory of this machine
};

/// Runs the work in a child process and hands over its mesh, bit by bit, or its exception of thermotwin::core.
/// SIGINT and SIGTERM are heeded while it runs.
/// @param place  body and file, for messages
/// @throws MesherError if the child crashed; MeshError if it came to its limit of time; what work throws;
///         std::bad_alloc; Interrupted
TetMesh mesh_in_child(const std::string& place, const ImportLimits& limits, const std::function<TetMesh()>& work);

/// Once the work knows how large the mesh will be, the limit of time follows: five minutes and a millisecond a
/// tetrahedron, ten times what Gmsh usually takes, but never more than before. Outside of a child nothing happens.
void limit_time_by(double tetrahedra);

}  // namespace thermotwin::mesh
