// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Structured tetrahedral boxes (six tetrahedra a cell, conforming) with their six sides as groups
// x0 x1 y0 y1 z0 z1, and machines put together from such boxes without files.

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "mesh/machine_mesh.h"

namespace thermotwin::test {

/// @param low, high  corners in m   @param cells  along x, y, z
inline mesh::TetMesh box_mesh(const Eigen::Vector3d& low, const Eigen::Vector3d& high, const Eigen::Vector3i& cells) {
  mesh::TetMesh box;
  const auto node = [&](int i, int j, int k) { return (k * (cells[1] + 1) + j) * (cells[0] + 1) + i; };
  box.points.resize(3, (cells[0] + 1) * (cells[1] + 1) * (cells[2] + 1));
  for (int k = 0; k <= cells[2]; ++k) {
    for (int j = 0; j <= cells[1]; ++j) {
      for (int i = 0; i <= cells[0]; ++i) {
        box.points.col(node(i, j, k)) =
            low + (high - low)
                      .cwiseProduct(Eigen::Vector3d(double(i) / cells[0], double(j) / cells[1], double(k) / cells[2]));
      }
    }
  }
  // Kuhn's division: each tetrahedron walks from corner 000 to 111 along the axes in one order.
  constexpr std::array<std::array<int, 3>, 6> walks{{{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  box.tets.resize(4, 6 * cells.prod());
  Eigen::Index t = 0;
  for (int k = 0; k < cells[2]; ++k) {
    for (int j = 0; j < cells[1]; ++j) {
      for (int i = 0; i < cells[0]; ++i) {
        for (const auto& walk : walks) {
          Eigen::Vector3i at(i, j, k);
          box.tets(0, t) = node(at[0], at[1], at[2]);
          for (int s = 0; s < 3; ++s) {
            ++at[walk[s]];
            box.tets(s + 1, t) = node(at[0], at[1], at[2]);
          }
          if (box.volume(t) < 0) std::swap(box.tets(2, t), box.tets(3, t));
          ++t;
        }
      }
    }
  }
  mesh::build_boundary(box, "box");
  const char* names[3][2] = {{"x0", "x1"}, {"y0", "y1"}, {"z0", "z1"}};
  for (int f = 0; f < box.face_count(); ++f) {
    const Eigen::Vector3d normal = box.face_normal(f);
    int axis = 0;
    normal.cwiseAbs().maxCoeff(&axis);
    box.groups[names[axis][normal[axis] > 0 ? 1 : 0]].push_back(f);
  }
  return box;
}

/// Machine and meshes together; surfaces are resolved by the group names of their rules (no rule:
/// the whole skin).
inline mesh::MachineMesh machine_mesh(mesh::Machine machine, std::vector<mesh::TetMesh> bodies) {
  mesh::MachineMesh result;
  result.first_node.push_back(0);
  for (const mesh::TetMesh& body : bodies) result.first_node.push_back(result.first_node.back() + body.nodes());
  for (const mesh::SurfaceSpec& surface : machine.surfaces) {
    const mesh::TetMesh& body = bodies.at(machine.body_index(surface.body));
    std::vector<int> faces;
    for (const mesh::Rule& rule : surface.any_of) {
      const std::vector<int>& group = body.groups.at(rule.group);
      faces.insert(faces.end(), group.begin(), group.end());
    }
    if (surface.any_of.empty())
      for (int f = 0; f < body.face_count(); ++f) faces.push_back(f);
    result.surfaces.push_back(std::move(faces));
  }
  result.machine = std::move(machine);
  result.bodies = std::move(bodies);
  return result;
}

/// The same machine with tetrahedra of this order.
inline mesh::MachineMesh with_order(mesh::MachineMesh mesh, int order) {
  mesh.machine.order = order;
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    mesh::set_order(mesh.bodies[b], order);
    mesh.first_node[b + 1] = mesh.first_node[b] + mesh.bodies[b].nodes();
  }
  return mesh;
}

inline mesh::Material steel() {
  mesh::Material m;
  m.id = "steel";
  m.density = 7800;
  m.specific_heat = {470.0, 0.0};
  m.conductivity = 45;
  m.expansion = {11.5e-6, 0.0};
  m.young = 210e9;
  m.poisson = 0.3;
  return m;
}

inline mesh::BodySpec body(const std::string& id, const std::string& material = "steel", const std::string& parent = "",
                           const std::string& axis = "") {
  mesh::BodySpec b;
  b.id = id;
  b.material = material;
  b.parent = parent;
  b.axis = axis;
  return b;
}

inline mesh::SurfaceSpec surface(const std::string& id, const std::string& body_id,
                                 const std::vector<std::string>& groups = {}) {
  mesh::SurfaceSpec s;
  s.id = id;
  s.body = body_id;
  for (const std::string& group : groups) {
    mesh::Rule rule;
    rule.group = group;
    s.any_of.push_back(rule);
  }
  return s;
}

inline mesh::AmbientSpec ambient(const std::string& id, double default_C, const std::string& follows = "",
                                 double offset = 0.0) {
  mesh::AmbientSpec a;
  a.id = id;
  a.default_C = {default_C, 0.0};
  a.follows = follows;
  a.offset = offset;
  return a;
}

inline mesh::FilmSpec constant_film(const std::string& id, const std::vector<std::string>& surfaces, double coefficient,
                                    const std::string& ambient_id = "air") {
  mesh::FilmSpec f;
  f.id = id;
  f.surfaces = surfaces;
  f.ambient = ambient_id;
  f.coefficient = {coefficient, 0.0};
  return f;
}

inline mesh::Axis linear_axis(const std::string& id, const Eigen::Vector3d& direction, double low, double high) {
  mesh::Axis a;
  a.id = id;
  a.direction = direction.normalized();
  a.low = low;
  a.high = high;
  a.rapid = 1.0;
  return a;
}

}  // namespace thermotwin::test
