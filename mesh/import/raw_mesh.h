// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A tetrahedral mesh as a file gives it: any numbering, orphan nodes, sets by name. The readers
// fill one; finish() checks it with the file's own numbers in messages and makes a TetMesh.

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "mesh/import/import.h"

namespace thermotwin::mesh {

struct RawMesh {
  std::string source;                    ///< file, for messages
  std::vector<Eigen::Vector3d> points;   ///< units of the file
  std::vector<long> node_labels;         ///< the file's numbers of the points
  std::vector<std::array<int, 4>> tets;  ///< indices into points
  std::vector<long> tet_labels;
  std::vector<int> tet_lines;             ///< line in the file; empty: unknown
  std::vector<std::array<int, 6>> edges;  ///< edge nodes of the tets, see tet_edge; empty or
                                          ///< shorter than tets: some are linear
  int solids = 0;                         ///< see TetMesh
  std::map<std::string, std::vector<std::array<int, 3>>> face_sets;
  std::map<std::string, std::vector<int>> node_sets;     ///< faces with all three nodes in it
  std::map<std::string, std::vector<int>> element_sets;  ///< boundary faces of these elements
};

/// Quadratic if all tetrahedra are; edge nodes that a file has off the middle are moved there, with
/// a warning. Where only some are quadratic, all become linear.
/// @throws MeshError naming the element of the file that is inverted, flat or has a node twice, or
///         whose edge nodes are not beside the middle of its edges or not those of its neighbours
TetMesh finish(const RawMesh& raw, const ImportOptions& options);

}  // namespace thermotwin::mesh
