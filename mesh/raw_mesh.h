// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A tetrahedral mesh as a file gives it: any numbering, orphan nodes, sets by name. The readers
// fill one; finish() checks it with the file's own numbers in messages and makes a TetMesh.

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "mesh/import.h"

namespace thermotwin::mesh {

struct RawMesh {
  std::string source;                                     ///< file, for messages
  std::vector<Eigen::Vector3d> points;                    ///< units of the file
  std::vector<long> node_labels;                          ///< the file's numbers of the points
  std::vector<std::array<int, 4>> tets;                   ///< indices into points
  std::vector<long> tet_labels;
  std::vector<int> tet_lines;                             ///< line in the file; empty: unknown
  bool quadratic = false;                                 ///< mid-side nodes were left out
  std::map<std::string, std::vector<std::array<int, 3>>> face_sets;
  std::map<std::string, std::vector<int>> node_sets;      ///< faces with all three nodes in it
  std::map<std::string, std::vector<int>> element_sets;   ///< boundary faces of these elements
};

/// @throws MeshError naming the element of the file that is inverted, flat or has a node twice
TetMesh finish(const RawMesh& raw, const ImportOptions& options);

/// Abaqus or CalculiX text. @throws InputError with source and line
RawMesh parse_inp(const std::string& text, const std::string& source);

/// VTK XML unstructured grid. @throws MeshError
RawMesh read_vtu(const std::filesystem::path& path);

}  // namespace thermotwin::mesh
