// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes in VTK XML files.
// Groups in a file: the boundary triangles follow the tetrahedra as cells of their own, once for
// each group, with cell data "group" (0: none) that counts in the field data "group_names".

#include "mesh/import/vtk_mesh_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "mesh/body/shape.h"
#include "mesh/import/raw_mesh.h"
#include "mesh/import/vtk_grid.h"

namespace thermotwin::mesh {

namespace {

/// Names of the groups by cell or by point; empty name: no group.
class GroupNames {
public:
  GroupNames(const std::vector<VtkArray>& arrays, const std::vector<VtkArray>& fields)
      : groups_(find_array(arrays, "group")),
        names_(find_array(fields, "group_names")) {}
  std::string operator()(Eigen::Index i) const {
    if (groups_ == nullptr) return {};
    if (!groups_->texts().empty()) return i < std::ssize(groups_->texts()) ? groups_->texts()[i] : std::string();
    const double value = groups_->number(i);
    if (!std::isfinite(value) || value == 0.0 || std::abs(value) > 1e9) return {};
    const long number = std::lround(value);
    if (names_ != nullptr && number >= 1 && number <= std::ssize(names_->texts())) return names_->texts()[number - 1];
    return std::to_string(number);
  }

private:
  const VtkArray *groups_, *names_;
};

/// Nodes of a cell that has at least as many. @throws MeshError
template <Eigen::Index count>
std::array<int, count> cell_nodes(const VtkGrid& grid, std::size_t cell, Eigen::Index first, const std::string& file) {
  const Eigen::Index begin = grid.first_node[cell] + first;
  if (begin + count > grid.first_node[cell + 1])
    throw core::MeshError(file, fmt::format("cell {} has too few points for its type", cell), "points of its type");
  std::array<int, count> nodes;
  std::copy_n(grid.nodes.begin() + begin, count, nodes.begin());
  return nodes;
}

}  // namespace

RawMesh read_vtu(const std::filesystem::path& path) {
  const VtkGrid grid = read_vtk_grid(path, {"group", "group_names"});
  const std::string file = path.string();
  RawMesh raw;
  raw.source = file;
  for (Eigen::Index i = 0; i < grid.points.cols(); ++i) {
    raw.points.emplace_back(grid.points.col(i));
    raw.node_labels.push_back(i);
  }
  const GroupNames by_cell(grid.cell_arrays, grid.fields), by_point(grid.point_arrays, grid.fields);
  for (std::size_t c = 0; c < grid.cells(); ++c) {
    const VtkCell type{grid.types[c]};
    const std::string group = by_cell(c);
    if (type == VtkCell::tet || type == VtkCell::tet_10) {
      if (!group.empty()) raw.element_sets[group].push_back(raw.tets.size());
      raw.tets.push_back(cell_nodes<4>(grid, c, 0, file));
      raw.tet_labels.push_back(c);
      if (type == VtkCell::tet_10) raw.edges.push_back(cell_nodes<6>(grid, c, 4, file));
    } else if (type == VtkCell::triangle || type == VtkCell::triangle_6) {
      if (!group.empty()) raw.face_sets[group].push_back(cell_nodes<3>(grid, c, 0, file));
    } else if (grid.dimensions[c] == 3) {
      throw core::MeshError(file, fmt::format("cell {} is of VTK type {}", c, grid.types[c]), "tetrahedra (10, 24)");
    }
  }
  for (Eigen::Index i = 0; i < grid.points.cols(); ++i)
    if (const std::string group = by_point(i); !group.empty()) raw.node_sets[group].push_back(i);
  return raw;
}

void write_vtu(const std::filesystem::path& path, const TetMesh& mesh) {
  VtkGrid grid;
  grid.points = mesh.points;
  for (Eigen::Index e = 0; e < mesh.elements(); ++e)
    grid.add_cell(mesh.order() == 2 ? VtkCell::tet_10 : VtkCell::tet, tet_nodes(mesh, e));
  std::vector<std::string> names;
  std::vector<int> group(mesh.elements(), 0);
  for (const auto& [name, faces] : mesh.groups) {
    names.push_back(name);
    for (const int face : faces) {
      const FaceNodes nodes = face_nodes(mesh, face);
      grid.add_cell(nodes.size() == 6 ? VtkCell::triangle_6 : VtkCell::triangle, nodes);
      group.push_back(names.size());
    }
  }
  grid.cell_arrays.push_back(
      {"group", Eigen::MatrixXi(Eigen::Map<const Eigen::RowVectorXi>(group.data(), std::ssize(group))), {}});
  if (!names.empty()) grid.add_texts("group_names", names);
  write_vtk_file(path, grid, VtkFile::unstructured_grid);
}

}  // namespace thermotwin::mesh
