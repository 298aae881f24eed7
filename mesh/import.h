// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Bodies from files. CAD: STEP/IGES/BREP by Gmsh's OpenCASCADE; surface files (STL, OBJ, PLY, 3MF,
// glTF/GLB) by assimp, checked to be closed, consistently oriented, free of duplicates and of
// self-intersection and of a plausible size, then meshed by Gmsh. Tetrahedral meshes that exist:
// Gmsh .msh 4.1 and 2.2, .vtu, Abaqus/CalculiX .inp, with their named groups.

#include <filesystem>
#include <string>

#include "mesh/tet_mesh.h"

namespace thermotwin::mesh {

/// A triangulated surface as read from a file.
struct Surface {
  Eigen::Matrix3Xd points;     ///< (3 x n) m
  Eigen::Matrix3Xi triangles;  ///< (3 x m)
  std::vector<int> part;       ///< (m) index into part_names (named solids or objects of the file)
  std::vector<std::string> part_names;
};

struct ImportOptions {
  std::string body;                 ///< name for messages
  double unit_m = 0.001;            ///< length of one unit of the file in m
  double element_size_m = 0.05;     ///< target edge length away from small features
  double min_element_size_m = 0.0;  ///< 0: a quarter of element_size_m
  int elements_per_turn = 8;        ///< elements on a full circle (curvature), CAD files only
  double max_elements = 4e6;        ///< estimated number beyond which a body is refused before it is meshed
};

/// Reads, welds equal corners and checks. @throws MeshError for holes, flipped or duplicate faces,
/// self-intersection, a size that suggests a wrong unit (largest extent outside 1 mm .. 50 m)
Surface read_surface(const std::filesystem::path& path, const ImportOptions& options);

/// The checks of read_surface on a surface at hand. @throws MeshError, naming body and triangle
void check_surface(const Surface& surface, const std::string& body);

/// Mesh of the body in the file, by the file's extension (see above). Groups: named parts of a
/// surface file, physical groups, VTK cell or face data "group", *SURFACE and *NSET/*ELSET.
/// It runs in a child process (see import_process.h), so that a damaged file ends in an error.
/// @throws InputError for an unknown extension; MeshError as described above
TetMesh import_body(const std::filesystem::path& path, const ImportOptions& options);

/// Reads an existing tetrahedral mesh (.msh, .vtu, .inp), linear or quadratic as it is; edges of
/// quadratic tetrahedra are made straight, with a warning if they were not.
TetMesh read_tet_mesh(const std::filesystem::path& path, const ImportOptions& options);

/// Writes points, tets, and the point arrays given, as .vtu (VTK XML, appended, LZ4).
void write_vtu(const std::filesystem::path& path, const TetMesh& mesh);

}  // namespace thermotwin::mesh
