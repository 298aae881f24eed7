// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/start_field_vtu.h"

#include <algorithm>

#include "core/error.h"
#include "core/text.h"
#include "mesh/import/vtk_grid.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/start_field.h"

namespace thermotwin::solver {
namespace {

using mesh::VtkArray;
using mesh::VtkGrid;

std::vector<std::string> texts(const VtkGrid& grid, const char* name) {
  const VtkArray* array = mesh::find_array(grid.fields, name);
  return array != nullptr ? array->texts() : std::vector<std::string>();
}

/// The cells of one body with their points in its home frame.
VtkGrid body_grid(const VtkGrid& grid, const VtkArray& body_of_cell, Eigen::Index body,
                  const Eigen::Isometry3d& to_home) {
  VtkGrid part;
  part.points = to_home * grid.points;
  for (std::size_t cell = 0; cell < grid.cells(); ++cell) {
    if (body_of_cell.number(cell) != 1.0 * body) continue;
    part.types.push_back(grid.types[cell]);
    part.nodes.insert(part.nodes.end(), grid.nodes.begin() + grid.first_node[cell],
                      grid.nodes.begin() + grid.first_node[cell + 1]);
    part.first_node.push_back(std::ssize(part.nodes));
  }
  return part;
}

}  // namespace

StartField field_from_vtu(const std::filesystem::path& path, const mesh::MachineMesh& mesh,
                          const ThermalSystem& thermal) {
  const mesh::Machine& machine = mesh.machine;
  if (!std::filesystem::exists(path)) throw core::InputError(path.string(), "no such file", "a .vtu of fields.pvd");
  const VtkGrid grid = mesh::read_vtk_grid(path, {"temperature_C", "body", "body_names", "pose"});
  const VtkArray* temperature = mesh::find_array(grid.point_arrays, "temperature_C");
  const VtkArray* body_of_cell = mesh::find_array(grid.cell_arrays, "body");
  if (temperature == nullptr || body_of_cell == nullptr || grid.cells() == 0)
    throw core::InputError(path.string(), "no cells with temperature_C and body", "a .vtu as simulate writes it");
  Eigen::VectorXd of_points(grid.points.cols());
  for (Eigen::Index i = 0; i < of_points.size(); ++i) of_points[i] = temperature->number(i);
  const std::vector<std::string> names = texts(grid, "body_names"), pose_text = texts(grid, "pose");
  const mesh::Pose pose = pose_text.empty() || pose_text.front().empty()
                              ? mesh::home_pose(machine)
                              : mesh::parse_pose(machine, pose_text.front(), path.string() + " pose");
  StartField start;
  start.temperature = Eigen::VectorXd::Zero(thermal.size);
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    const auto at = std::find(names.begin(), names.end(), machine.bodies[b].id);
    if (at == names.end()) {
      throw core::InputError(path.string(), "no body '" + machine.bodies[b].id + "'",
                             "a field of this machine; it has: " + core::join(names));
    }
    const VtkGrid part =
        body_grid(grid, *body_of_cell, at - names.begin(), mesh::body_transform(machine, b, pose).inverse());
    if (part.cells() == 0) {
      throw core::InputError(path.string(), "body '" + machine.bodies[b].id + "' has no cells",
                             "a field of this machine");
    }
    const mesh::VtkValues found = mesh::interpolate(part, of_points, mesh.bodies[b].points);
    start.farthest = std::max(start.farthest, found.farthest);
    start.temperature.segment(mesh.first_node[b], found.values.size()) = found.values.array() - machine.reference_C;
  }
  set_fluids_to_walls(thermal, start.temperature);
  return start;
}

}  // namespace thermotwin::solver
