// SPDX-License-Identifier: GPL-3.0-or-later
// Where along its axis a joint's matrices are made, and what of its slave surface moves as one pad.

#include "solver/contact/grid.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>

#include "solver/contact/contact.h"

namespace thermotwin::solver {

using Eigen::Vector3d;
using mesh::TetMesh;

namespace {

/// Shortest extent of the connected sets along a direction, m.
double shortest_extent(const TetMesh& body, const std::vector<int>& faces, const Vector3d& direction) {
  const std::vector<int> set = connected_sets(body, faces);
  std::map<int, std::pair<double, double>> extent;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (int i = 0; i < 3; ++i) {
      const double along = direction.dot(body.points.col(body.faces(i, faces[f])));
      const auto at = extent.try_emplace(set[f], along, along).first;
      at->second.first = std::min(at->second.first, along);
      at->second.second = std::max(at->second.second, along);
    }
  }
  double shortest = std::numeric_limits<double>::infinity();
  for (const auto& [id, range] : extent) shortest = std::min(shortest, range.second - range.first);
  return shortest;
}

/// Positions of the axis in the workspace grids.
std::vector<double> workspace_positions(const mesh::Machine& machine, const std::string& axis) {
  std::vector<double> positions;
  const auto collect = [&](const std::vector<std::string>& axes, const std::vector<std::vector<double>>& lists) {
    for (std::size_t i = 0; i < axes.size(); ++i)
      if (axes[i] == axis) positions.insert(positions.end(), lists[i].begin(), lists[i].end());
  };
  collect(machine.workspace.axes, machine.workspace.positions);
  collect(machine.workspace.table_axes, machine.workspace.table_positions);
  return positions;
}

/// Sorted corners with evenly divided gaps no longer than spacing.
std::vector<double> divide_evenly(std::vector<double> corners, double spacing, double merge) {
  std::sort(corners.begin(), corners.end());
  std::vector<double> kept;
  for (double c : corners)
    if (kept.empty() || c - kept.back() > merge) kept.push_back(c);
  std::vector<double> grid{kept.front()};
  for (std::size_t i = 1; i < kept.size(); ++i) {
    const double length = kept[i] - kept[i - 1];
    const int cells = std::max(1, static_cast<int>(std::ceil(length / spacing - 1e-9)));
    for (int k = 1; k <= cells; ++k) grid.push_back(k == cells ? kept[i] : kept[i - 1] + length * k / cells);
  }
  return grid;
}

}  // namespace

std::vector<int> connected_sets(const TetMesh& body, const std::vector<int>& faces) {
  std::vector<int> parent(faces.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto find = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  std::map<int, int> seen;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (int i = 0; i < 3; ++i) {
      const auto [at, fresh] = seen.try_emplace(body.faces(i, faces[f]), f);
      if (!fresh) {
        const int a = find(f), b = find(at->second);
        parent[std::max(a, b)] = std::min(a, b);
      }
    }
  }
  std::map<int, int> number;
  std::vector<int> set(faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f) set[f] = number.try_emplace(find(f), number.size()).first->second;
  return set;
}

std::vector<double> contact_grid(const mesh::MachineMesh& mesh, const mesh::JointSpec& joint) {
  if (joint.axis.empty()) return {0.0};
  const mesh::Axis& axis = mesh.machine.axes[mesh.machine.axis_index(joint.axis)];
  std::vector<double> corners = workspace_positions(mesh.machine, axis.id);
  constexpr double turn = 2.0 * std::numbers::pi;
  if (axis.kind == mesh::AxisKind::rotary) {
    constexpr double spacing = turn / 12.0;
    if (!axis.endless) {
      std::erase_if(corners, [&](double x) { return x < axis.low || x > axis.high; });
      corners.insert(corners.end(), {axis.low, axis.high});
      return divide_evenly(std::move(corners), spacing, 1e-9);
    }
    for (double& x : corners) x -= turn * std::floor(x / turn + 1e-12);
    corners.insert(corners.end(), {0.0, turn});
    std::vector<double> grid = divide_evenly(std::move(corners), spacing, 1e-9);
    grid.pop_back();  // a full turn is the first node again
    return grid;
  }
  std::erase_if(corners, [&](double x) { return x < axis.low || x > axis.high; });
  corners.insert(corners.end(), {axis.low, axis.high});
  const double extent = shortest_extent(body_of(mesh, joint.slave), faces_of(mesh, joint.slave), axis.direction);
  const double travel = axis.high - axis.low;
  // A slave surface without extent along the axis (a ring in a plane) gives no length to go by.
  const double spacing = extent > 1e-3 * travel ? 0.5 * extent : travel / 20.0;
  return divide_evenly(std::move(corners), std::isfinite(spacing) && spacing > 0 ? spacing : 1.0, 1e-7);
}

Pads find_pads(const mesh::MachineMesh& mesh, const mesh::JointSpec& joint) {
  const TetMesh& body = body_of(mesh, joint.slave);
  const std::vector<int>& faces = faces_of(mesh, joint.slave);
  const std::vector<int> set = connected_sets(body, faces);

  std::map<int, Eigen::AlignedBox3d> boxes;
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (int i = 0; i < 3; ++i) boxes[set[f]].extend(Vector3d(body.points.col(body.faces(i, faces[f]))));

  const Vector3d axis = joint.sector_axis.normalized();
  const Vector3d east = axis.unitOrthogonal(), north = axis.cross(east);
  const auto cell_of = [&](std::size_t f) {
    const Vector3d centre = body.face_centre(faces[f]);
    if (joint.sectors > 0) {
      const Vector3d r = centre - joint.sector_point;
      const double turns = std::atan2(r.dot(north), r.dot(east)) / (2.0 * std::numbers::pi);
      return std::min(joint.sectors - 1, static_cast<int>((turns - std::floor(turns)) * joint.sectors));
    }
    int cell = 0;
    for (int k = 0; k < 3; ++k) {
      const Eigen::AlignedBox3d& box = boxes.at(set[f]);
      const double length = box.sizes()[k];
      const double share = length > 0 ? (centre[k] - box.min()[k]) / length : 0.0;
      cell = cell * joint.divide[k] + std::clamp(static_cast<int>(share * joint.divide[k]), 0, joint.divide[k] - 1);
    }
    return cell;
  };

  std::map<std::pair<int, int>, int> number;
  std::vector<std::pair<int, int>> keys(faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f) number.emplace(keys[f] = {set[f], cell_of(f)}, 0);
  Pads pads;
  for (auto& [key, id] : number) id = pads.count++;
  for (const auto& key : keys) pads.of_face.push_back(number.at(key));
  return pads;
}

}  // namespace thermotwin::solver
