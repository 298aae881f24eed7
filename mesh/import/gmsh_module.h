// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The module that holds Gmsh, and with it OpenCASCADE and a graphical interface: ninety shared libraries. The program
// passes callbacks to its functions, because a module has its own copy of the program's global state.

#include <Eigen/Core>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "mesh/import/gmsh_mesher.h"
#include "mesh/import/raw_mesh.h"
#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

/// One body to be meshed; all of it outlives the call.
struct GmshJob {
  const std::filesystem::path& file;  ///< empty for a surface in memory
  const std::string& place;           ///< for messages
  const ImportOptions& options;
  const Attempt& attempt;
  double unit_m;                                                   ///< of coordinates within Gmsh
  bool iges;                                                       ///< the file is of this type
  std::function<void(const std::string&)> warn;                    ///< takes the text of a warning
  std::function<void(const Eigen::Matrix3Xd& ends)> check_extent;  ///< takes the corners of a box, m, (3 x 2)
  std::function<void(double volume)> require_affordable;           ///< volume in m^3; throws above max_elements
};

/// Functions of the module. Each takes one lock for the whole program, since the state of Gmsh is global.
struct GmshModule {
  /// @param volume  receives the volume of the solids, m^3
  RawMesh (*mesh_cad)(const GmshJob& job, double& volume);
  Surface (*tessellate_cad)(const GmshJob& job);
  /// @param patch  (triangles) number of the patch of each
  RawMesh (*mesh_surface)(const GmshJob& job, const Surface& surface, const std::vector<int>& patch);
  RawMesh (*read_msh)(const std::filesystem::path& path);
};

}  // namespace thermotwin::mesh
