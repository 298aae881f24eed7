// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/surfaces.h"

#include "core/error.h"

namespace thermotwin::solver::assembly {

using Eigen::Index;
using mesh::MachineMesh;

SparseMatrix from_triplets(Index rows, Index columns, const Triplets& triplets) {
  SparseMatrix matrix(rows, columns);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  matrix.makeCompressed();
  return matrix;
}

FaceSet face_set(const MachineMesh& mesh, const std::string& id) {
  const int surface = mesh.machine.surface_index(id);
  const mesh::SurfaceSpec& spec = mesh.machine.surfaces[surface];
  const int body = mesh.machine.body_index(spec.body);
  FaceSet set{&mesh.bodies[body], &mesh.surfaces[surface], static_cast<int>(mesh.first_node[body]), 0.0};
  for (int face : *set.faces) set.area += set.body->face_area(face);
  if (!(set.area > 0.0))
    throw core::InputError(spec.place, "surface '" + id + "' with an area of 0", "a surface with triangles");
  return set;
}

void add_surface_mass(Triplets& triplets, const FaceSet& set, ElementRules rules) {
  const Eigen::MatrixXd& mass = face_mass(set.body->order(), rules);
  for (int face : *set.faces) {
    const mesh::FaceNodes nodes = set.nodes(face);
    const double area = set.body->face_area(face);
    for (Index i = 0; i < nodes.size(); ++i)
      for (Index j = 0; j < nodes.size(); ++j) triplets.emplace_back(nodes[i], nodes[j], area * mass(i, j));
  }
}

SparseColumn surface_load(const FaceSet& set) {
  SparseColumn load;
  const mesh::FaceValues shares = face_load(set.body->order());
  for (int face : *set.faces) {
    const mesh::FaceNodes nodes = set.nodes(face);
    const double area = set.body->face_area(face);
    for (Index i = 0; i < nodes.size(); ++i)
      if (shares[i] != 0.0) load.emplace_back(nodes[i], area * shares[i]);
  }
  return load;
}

void add_mixed(Triplets& triplets, const FaceSet& set, int fluid) {
  for (const auto& [node, value] : surface_load(set)) {
    triplets.emplace_back(node, fluid, -value);
    triplets.emplace_back(fluid, node, -value);
  }
  triplets.emplace_back(fluid, fluid, set.area);
}

SparseColumn surface_height_load(const FaceSet& set, double level) {
  SparseColumn load;
  for (int face : *set.faces) {
    const mesh::FaceNodes nodes = set.nodes(face);
    const double area = set.body->face_area(face);
    for (const mesh::FacePoint& point : mesh::face_rule(3)) {
      const mesh::FaceValues values = mesh::face_shape(set.body->order(), point.at);
      double z = -level;
      for (int k = 0; k < 3; ++k) z += point.at[k] * set.body->points(2, set.body->faces(k, face));
      for (Index i = 0; i < nodes.size(); ++i) load.emplace_back(nodes[i], area * point.share * z * values[i]);
    }
  }
  return load;
}

}  // namespace thermotwin::solver::assembly
