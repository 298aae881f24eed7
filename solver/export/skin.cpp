// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/export/skin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace thermotwin::solver {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Boundary nodes of a body. A node's sides are a set of bits: along which axes and ways the normals of its triangles
/// point, so one on a face has one bit, on an edge two, in a corner three.
struct Boundary {
  std::vector<int> nodes;
  std::vector<long> sides;
  std::vector<std::array<Index, 2>> edges;  ///< between nodes with the same sides, as indices into nodes
  double extent = 0;                        ///< m, longest side of the body's box
};

long side_of(const Vector3d& normal) {
  Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return 1L << (2 * axis + (normal[axis] < 0.0 ? 1 : 0));
}

Boundary boundary_of(const mesh::TetMesh& body) {
  std::vector<long> sides(body.nodes(), 0);
  for (Index f = 0; f < body.face_count(); ++f) {
    const long side = side_of(body.face_normal(f));
    for (const int node : body.faces.col(f)) sides[node] |= side;
  }
  Boundary boundary;
  Vector3d low = Vector3d::Constant(1e300), high = -low;
  for (int n = 0; n < body.nodes(); ++n) {
    if (sides[n] == 0) continue;
    boundary.nodes.push_back(n);
    boundary.sides.push_back(sides[n]);
    low = low.cwiseMin(body.points.col(n));
    high = high.cwiseMax(body.points.col(n));
  }
  if (!boundary.nodes.empty()) boundary.extent = (high - low).maxCoeff();
  std::vector<Index> place(body.nodes(), -1);
  for (std::size_t i = 0; i < boundary.nodes.size(); ++i) place[boundary.nodes[i]] = i;
  for (Index f = 0; f < body.face_count(); ++f) {
    for (int c = 0; c < 3; ++c) {
      const int a = body.faces(c, f), b = body.faces((c + 1) % 3, f);
      if (a < b && sides[a] == sides[b]) boundary.edges.push_back({place[a], place[b]});
    }
  }
  return boundary;
}

/// Size of the cells: that of large bodies, and into how many the longest side of a small one is cut at least, so that
/// it keeps a shape.
struct Cells {
  double size, least;
};

/// Cluster of each boundary node, counted from 0; their number. Nodes of one cluster have the same sides, lie in one
/// cell and are connected there: two parallel edges or walls in a cell do not become one.
Index cluster(const mesh::TetMesh& body, const Boundary& boundary, const Cells& cells, std::vector<Index>* clusters) {
  const double size = std::max(std::min(cells.size, boundary.extent / cells.least), 1e-9);
  std::vector<std::array<long, 3>> cell;
  std::vector<Index> parent;  // of trees that are the clusters
  for (const int node : boundary.nodes) {
    const Vector3d point = body.points.col(node) / size;
    cell.push_back({std::lround(point.x()), std::lround(point.y()), std::lround(point.z())});
    parent.push_back(std::ssize(parent));
  }
  const auto root = [&](Index i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const auto& [a, b] : boundary.edges) {
    if (cell[a] != cell[b]) continue;
    const Index first = root(a), second = root(b);
    parent[std::max(first, second)] = std::min(first, second);
  }
  Index count = 0;
  std::vector<Index> number(parent.size(), -1);  // of a root, which comes before the others of its cluster
  for (Index i = 0; i < std::ssize(parent); ++i) {
    const Index of = root(i);
    if (of == i) number[i] = count++;
    if (clusters != nullptr) clusters->push_back(number[of]);
  }
  return count;
}

/// The node of each cluster that is next to its mean.
std::vector<int> representatives(const mesh::TetMesh& body, const Boundary& boundary,
                                 const std::vector<Index>& clusters, Index count) {
  Eigen::Matrix3Xd mean = Eigen::Matrix3Xd::Zero(3, count);
  Eigen::VectorXd members = Eigen::VectorXd::Zero(count);
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    mean.col(clusters[i]) += body.points.col(boundary.nodes[i]);
    members[clusters[i]] += 1.0;
  }
  std::vector<int> nodes(count, -1);
  std::vector<double> distance(count, 1e300);
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    const Index c = clusters[i];
    const double away = (body.points.col(boundary.nodes[i]) - mean.col(c) / members[c]).squaredNorm();
    if (away < distance[c]) distance[c] = away, nodes[c] = boundary.nodes[i];
  }
  return nodes;
}

void add_triangles(const mesh::TetMesh& body, const Boundary& boundary, const std::vector<Index>& clusters, Index first,
                   std::vector<Eigen::Vector3i>& triangles) {
  std::vector<Index> of_node(body.nodes(), -1);
  for (std::size_t i = 0; i < clusters.size(); ++i) of_node[boundary.nodes[i]] = first + clusters[i];
  std::set<std::array<int, 3>> known;
  for (Index f = 0; f < body.face_count(); ++f) {
    std::array<int, 3> corners{};
    for (int c = 0; c < 3; ++c) corners[c] = of_node[body.faces(c, f)];
    if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0]) continue;
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    if (known.insert(corners).second) triangles.emplace_back(corners[0], corners[1], corners[2]);
  }
}

/// The finest cells with at most so many vertices; where even the coarsest have more, those.
Cells cells_for(const mesh::MachineMesh& mesh, const std::vector<Boundary>& boundaries, double extent, Index most) {
  const auto fits = [&](const Cells& cells) {
    Index count = 0;
    for (std::size_t b = 0; b < mesh.bodies.size(); ++b)
      count += cluster(mesh.bodies[b], boundaries[b], cells, nullptr);
    return count <= most;
  };
  for (const double least : {4.0, 2.0, 1.0}) {
    double fine = 1e-3 * extent, coarse = extent;
    if (fits({fine, least})) return {fine, least};
    if (!fits({coarse, least})) continue;
    while (coarse > 1.03 * fine) {
      const double middle = std::sqrt(fine * coarse);
      (fits({middle, least}) ? coarse : fine) = middle;
    }
    return {coarse, least};
  }
  return {extent, 1.0};
}

}  // namespace

Skin make_skin(const mesh::MachineMesh& mesh, Index most) {
  std::vector<Boundary> boundaries;
  double extent = 0.0;
  for (const mesh::TetMesh& body : mesh.bodies) {
    boundaries.push_back(boundary_of(body));
    extent = std::max(extent, boundaries.back().extent);
  }
  const Cells cells = cells_for(mesh, boundaries, extent, most);

  Skin skin;
  std::vector<Eigen::Vector3i> triangles;
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    const mesh::TetMesh& body = mesh.bodies[b];
    std::vector<Index> clusters;
    const Index count = cluster(body, boundaries[b], cells, &clusters), first = std::ssize(skin.nodes);
    skin.first.push_back(first);
    for (const int node : representatives(body, boundaries[b], clusters, count))
      skin.nodes.push_back(mesh.first_node[b] + node);
    add_triangles(body, boundaries[b], clusters, first, triangles);
  }
  skin.first.push_back(std::ssize(skin.nodes));
  skin.points.resize(3, std::ssize(skin.nodes));
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    for (Index v = skin.first[b]; v < skin.first[b + 1]; ++v)
      skin.points.col(v) = mesh.bodies[b].points.col(skin.nodes[v] - mesh.first_node[b]);
  }
  skin.triangles.resize(3, std::ssize(triangles));
  for (std::size_t t = 0; t < triangles.size(); ++t) skin.triangles.col(t) = triangles[t];
  return skin;
}

}  // namespace thermotwin::solver
