// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis/patches.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "mesh/selection.h"
#include "solver/campaign/full_model.h"
#include "solver/thermal/surfaces.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr int seed_moves = 4;         ///< of seeds to the middle of their clusters
constexpr double fine_enough = 0.03;  ///< m, from any place to the middle of a patch
constexpr double margin_mm = 1.0;     ///< of a box about its triangles: meshes differ

/// The skin of one body in clusters.
struct Skin {
  Eigen::Matrix3Xd centre;
  Eigen::VectorXd area, distance;  ///< to the nearest seed, m
  Eigen::VectorXi cluster;
  std::vector<Index> seeds;  ///< faces

  explicit Skin(const mesh::TetMesh& mesh) : centre(3, mesh.face_count()), area(mesh.face_count()) {
    for (int f = 0; f < centre.cols(); ++f) {
      centre.col(f) = mesh.face_centre(f);
      area[f] = mesh.face_area(f);
    }
    distance.setConstant(mesh.face_count(), std::numeric_limits<double>::infinity());
    cluster.setZero(mesh.face_count());
    const Vector3d middle = centre * area / area.sum();
    Index far = 0;
    (centre.colwise() - middle).colwise().squaredNorm().maxCoeff(&far);
    add(far);
  }
  void add(Index face) {
    for (Index f = 0; f < centre.cols(); ++f) {
      if (const double d = (centre.col(f) - centre.col(face)).norm(); d < distance[f]) {
        distance[f] = d;
        cluster[f] = seeds.size();
      }
    }
    seeds.push_back(face);
  }
  void move_seeds() {
    std::vector<Index> moved;
    for (int s = 0; s < std::ssize(seeds); ++s) {
      Vector3d middle = Vector3d::Zero();
      double sum = 0.0;
      for (Index f = 0; f < centre.cols(); ++f)
        if (cluster[f] == s) middle += area[f] * centre.col(f), sum += area[f];
      middle /= sum;
      Index nearest = seeds[s];
      for (Index f = 0; f < centre.cols(); ++f) {
        if (cluster[f] == s && (centre.col(f) - middle).squaredNorm() < (centre.col(nearest) - middle).squaredNorm())
          nearest = f;
      }
      moved.push_back(nearest);
    }
    seeds.clear();
    distance.setConstant(std::numeric_limits<double>::infinity());
    for (const Index face : moved) add(face);
  }
};

double down(double m) { return (std::floor(1e3 * m) - margin_mm) * 1e-3; }
double up(double m) { return (std::ceil(1e3 * m) + margin_mm) * 1e-3; }

}  // namespace

std::vector<Patch> surface_patches(const mesh::MachineMesh& mesh, int count) {
  std::vector<Skin> skins;
  for (const mesh::TetMesh& body : mesh.bodies) skins.emplace_back(body);
  for (int made = skins.size(); made < count; ++made) {
    Skin* widest = nullptr;
    Index face = 0;
    double most = fine_enough;
    for (Skin& skin : skins) {
      Index at = 0;
      if (const double far = skin.distance.maxCoeff(&at); far > most) most = far, widest = &skin, face = at;
    }
    if (!widest) break;
    widest->add(face);
  }
  std::vector<Patch> patches;
  for (std::size_t b = 0; b < skins.size(); ++b) {
    Skin& skin = skins[b];
    const mesh::TetMesh& body = mesh.bodies[b];
    for (int i = 0; i < seed_moves; ++i) skin.move_seeds();
    for (int s = 0; s < std::ssize(skin.seeds); ++s) {
      Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
      for (Index f = 0; f < skin.centre.cols(); ++f) {
        if (skin.cluster[f] != s) continue;
        for (int i = 0; i < 3; ++i) {
          low = low.cwiseMin(body.points.col(body.faces(i, f)));
          high = high.cwiseMax(body.points.col(body.faces(i, f)));
        }
      }
      Patch patch;
      mesh::Rule rule;
      rule.box_min = low.unaryExpr(&down);
      rule.box_max = high.unaryExpr(&up);
      patch.surface = patch_surface(mesh.machine.bodies[b].id, s, *rule.box_min, *rule.box_max);
      for (const int f : mesh::select_faces(body, patch.surface.any_of.front())) {
        patch.area += skin.area[f];
        patch.centre += skin.area[f] * skin.centre.col(f);
      }
      patch.centre /= patch.area;
      patches.push_back(std::move(patch));
    }
  }
  return patches;
}

mesh::SurfaceSpec patch_surface(const std::string& body, int index, const Vector3d& low, const Vector3d& high) {
  mesh::SurfaceSpec surface;
  surface.id = body + ".patch_" + std::to_string(index);
  surface.body = body;
  surface.place = "surface patch " + surface.id;
  mesh::Rule rule;
  rule.box_min = low;
  rule.box_max = high;
  rule.place = surface.place;
  surface.any_of.push_back(std::move(rule));
  return surface;
}

solver::SparseMatrix patch_loads(const solver::FullModel& full, const std::vector<Patch>& patches) {
  const mesh::MachineMesh& mesh = full.mesh;
  solver::assembly::Triplets triplets;
  for (std::size_t k = 0; k < patches.size(); ++k) {
    const std::size_t b = mesh.machine.body_index(patches[k].surface.body);
    const std::vector<int> faces = mesh::select_faces(mesh.bodies[b], patches[k].surface.any_of.front());
    solver::assembly::FaceSet set{&mesh.bodies[b], &faces, static_cast<int>(mesh.first_node[b]), 0.0};
    for (const int face : faces) set.area += mesh.bodies[b].face_area(face);
    for (const auto& [node, value] : solver::assembly::surface_load(set))
      triplets.emplace_back(node, k, value / set.area);
  }
  return solver::assembly::from_triplets(full.thermal.size, std::ssize(patches), triplets);
}

}  // namespace thermotwin::reduction
