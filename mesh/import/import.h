// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Bodies from files. CAD: STEP/IGES/BREP by Gmsh's OpenCASCADE; surface files (STL, OBJ, PLY, 3MF,
// glTF/GLB) by assimp, checked to be closed, consistently oriented, free of duplicates and of
// self-intersection and of a plausible size, then meshed by Gmsh. Tetrahedral meshes that exist:
// Gmsh .msh 4.1 and 2.2, .vtu, Abaqus/CalculiX .inp, with their named groups.

#include <filesystem>
#include <string>

#include "mesh/body/tet_mesh.h"

namespace thermotwin::mesh {

struct ImportOptions {
  std::string body;                 ///< name for messages
  double unit_m = 0.001;            ///< length of one unit of the file in m
  double element_size_m = 0.05;     ///< target edge length away from small features
  double min_element_size_m = 0.0;  ///< 0: a quarter of element_size_m
  int elements_per_turn = 8;        ///< elements on a full circle (curvature), CAD files only
  double max_elements = 4e6;        ///< estimated number beyond which a body is refused before it is meshed
  bool lattice = false;             ///< fill the surface with a cut lattice instead of meshing it (lattice_mesher.h)
  void validate() const;            ///< @throws InputError
};

/// Mesh of the body in the file, by the file's extension (see above). Groups: named parts of a
/// surface file, physical groups, VTK cell or face data "group", *SURFACE and *NSET/*ELSET.
/// It runs in a child process (see import_process.h), so that a damaged file ends in an error.
/// @throws InputError for an unknown extension; MeshError for holes, flipped or duplicate faces, self-intersection, a
///         size that suggests a wrong unit (largest extent outside 1 mm .. 50 m)
TetMesh import_body(const std::filesystem::path& path, const ImportOptions& options);

/// Reads an existing tetrahedral mesh (.msh, .vtu, .inp), linear or quadratic as it is; edges of
/// quadratic tetrahedra are made straight, with a warning if they were not.
TetMesh read_tet_mesh(const std::filesystem::path& path, const ImportOptions& options);

}  // namespace thermotwin::mesh
