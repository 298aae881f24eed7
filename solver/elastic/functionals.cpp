// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/elastic/functionals.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <map>

#include "core/error.h"

namespace thermotwin::solver {
namespace {

/// Node -> its share of the surface, m^2.
std::map<Eigen::Index, double> nodal_areas(const mesh::TetMesh& mesh, const std::vector<int>& faces) {
  std::map<Eigen::Index, double> areas;
  const Eigen::Matrix3Xi& nodes = mesh.order() == 1 ? mesh.faces : mesh.face_edges;
  for (int face : faces)
    for (int i = 0; i < 3; ++i) areas[nodes(i, face)] += mesh.face_area(face) / 3.0;
  return areas;
}

void add(Functional& functional, Eigen::Index node, const Eigen::Vector3d& weight) {
  for (int i = 0; i < 3; ++i)
    if (weight[i] != 0.0) functional.emplace_back(3 * node + i, weight[i]);
}

}  // namespace

void tidy(Functional& functional) {
  std::stable_sort(functional.begin(), functional.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::size_t last = 0;
  for (std::size_t i = 1; i < functional.size(); ++i) {
    if (functional[i].first == functional[last].first)
      functional[last].second += functional[i].second;
    else
      functional[++last] = functional[i];
  }
  if (!functional.empty()) functional.resize(last + 1);
}

double evaluate(const Functional& functional, const Eigen::Ref<const Eigen::VectorXd>& displacement) {
  double sum = 0.0;
  for (const auto& [dof, weight] : functional) sum += weight * displacement[dof];
  return sum;
}

std::array<Functional, 6> rigid_motion(const mesh::TetMesh& mesh, const std::vector<int>& faces,
                                       const Eigen::Vector3d& point, const std::string& surface) {
  const auto areas = nodal_areas(mesh, faces);
  double area = 0.0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const auto& [node, a] : areas) area += a, centre += a * mesh.points.col(node);
  if (!(area > 0.0)) throw core::MeshError("surface '" + surface + "'", "no area", "a surface with triangles");
  centre /= area;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (const auto& [node, a] : areas) {
    const Eigen::Vector3d r = mesh.points.col(node) - centre;
    inertia += a * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  const Eigen::Vector3d principal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia).eigenvalues();
  if (principal[0] < 1e-9 * principal[2]) {
    throw core::MeshError("surface '" + surface + "'", "its nodes lie on a line, so its rotation is unknown",
                          "a surface that extends in two directions");
  }
  const Eigen::Matrix3d inverse = inertia.inverse();
  const Eigen::Vector3d arm = point - centre;
  std::array<Functional, 6> motion;
  for (const auto& [node, a] : areas) {
    const Eigen::Vector3d r = mesh.points.col(node) - centre;
    for (int i = 0; i < 3; ++i) {
      // omega_i = e_i . J^-1 sum a (r x u) = sum a ((J^-1 e_i) x r) . u
      const Eigen::Vector3d rotation = a * inverse.col(i).cross(r);
      add(motion[3 + i], node, rotation);
      // t_i = mean u_i + (omega x arm)_i, and (omega x arm)_i = omega . (arm x e_i)
      const Eigen::Vector3d lever = inverse * arm.cross(Eigen::Vector3d::Unit(i));
      add(motion[i], node, a / area * Eigen::Vector3d::Unit(i) + a * lever.cross(r));
    }
  }
  for (Functional& functional : motion) tidy(functional);
  return motion;
}

Functional radial_growth(const mesh::TetMesh& mesh, const std::vector<int>& faces, const Eigen::Vector3d& origin,
                         const Eigen::Vector3d& direction) {
  const auto areas = nodal_areas(mesh, faces);
  const auto radius = [&](Eigen::Index node) -> Eigen::Vector3d {
    const Eigen::Vector3d r = mesh.points.col(node) - origin;
    return r - r.dot(direction) * direction;
  };
  double area = 0.0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& [node, a] : areas) area += a, mean += a * radius(node);
  mean /= area;
  double sum = 0.0;
  for (const auto& [node, a] : areas) sum += a * (radius(node) - mean).dot(radius(node));
  Functional growth;
  for (const auto& [node, a] : areas) add(growth, node, a / sum * (radius(node) - mean));
  tidy(growth);
  return growth;
}

SkinPoint skin_point(const mesh::TetMesh& mesh, const mesh::TriangleTree& skin, const Eigen::Vector3d& place) {
  const auto nearest = skin.nearest(place);
  SkinPoint found;
  found.distance = nearest.distance;
  found.node = mesh::face_nodes(mesh, nearest.triangle);
  found.weight = mesh::face_shape(mesh.order(), mesh::face_barycentric(mesh, nearest.triangle, nearest.point));
  return found;
}

Functional point_motion(const SkinPoint& point, const Eigen::Vector3d& direction) {
  Functional functional;
  for (Eigen::Index i = 0; i < point.node.size(); ++i) add(functional, point.node[i], point.weight[i] * direction);
  tidy(functional);
  return functional;
}

}  // namespace thermotwin::solver
