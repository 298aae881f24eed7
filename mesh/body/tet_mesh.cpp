// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/body/tet_mesh.h"

#include <Eigen/Dense>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "core/error.h"

namespace thermotwin::mesh {

namespace {

using Triple = std::array<int, 3>;

// The four faces of a tetrahedron of positive volume, seen from outside.
constexpr int local_face[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};

/// Place in tet_edge of the edge between two corners.
int edge_between(int a, int b) {
  for (int edge = 0; edge < 6; ++edge) {
    if ((tet_edge[edge][0] == a && tet_edge[edge][1] == b) || (tet_edge[edge][0] == b && tet_edge[edge][1] == a))
      return edge;
  }
  return -1;
}

struct Side {
  Triple key;  ///< sorted nodes
  int element, local;
  bool even;  ///< whether sorting took an even permutation: tells the direction apart
};

bool operator<(const Side& a, const Side& b) { return a.key != b.key ? a.key < b.key : a.element < b.element; }

Side make_side(const Eigen::Matrix4Xi& tets, int element, int local) {
  Side side{{}, element, local, true};
  for (int i = 0; i < 3; ++i) side.key[i] = tets(local_face[local][i], element);
  const auto order = [&](std::size_t i, std::size_t j) {
    if (side.key[i] <= side.key[j]) return;
    std::swap(side.key[i], side.key[j]);
    side.even = !side.even;
  };
  order(0, 1), order(1, 2), order(0, 1);
  return side;
}

[[noreturn]] void fail(const std::string& body, const std::string& found, const std::string& allowed) {
  throw core::MeshError("body '" + body + "'", found, allowed);
}

std::string at(const Eigen::Vector3d& point) {
  return fmt::format("({:.4g}, {:.4g}, {:.4g}) mm", 1e3 * point.x(), 1e3 * point.y(), 1e3 * point.z());
}

void check_elements(const TetMesh& mesh, const std::string& body) {
  if (mesh.elements() == 0) fail(body, "a mesh without elements", "one or more tetrahedra");
  if (!mesh.points.allFinite()) fail(body, "a node with a coordinate that is not a number", "finite coordinates");
  std::vector<char> used(mesh.nodes(), 0);
  for (Eigen::Index e = 0; e < mesh.elements(); ++e) {
    const Eigen::Vector4i nodes = mesh.tets.col(e);
    for (int i = 0; i < 4; ++i) {
      if (nodes[i] < 0 || nodes[i] >= mesh.nodes()) {
        fail(body, fmt::format("element {} refers to node {}", e, nodes[i]),
             fmt::format("nodes 0 .. {}", mesh.nodes() - 1));
      }
      for (int j = 0; j < i; ++j) {
        if (nodes[i] == nodes[j])
          fail(body, fmt::format("element {} has node {} twice", e, nodes[i]), "four different nodes");
      }
      used[nodes[i]] = 1;
    }
    if (mesh.order() == 2) {
      for (const int node : mesh.tet_edges.col(e)) {
        if (node < 0 || node >= mesh.nodes()) {
          fail(body, fmt::format("element {} refers to node {}", e, node),
               fmt::format("nodes 0 .. {}", mesh.nodes() - 1));
        }
        used[node] = 1;
      }
    }
    double longest = 0.0;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < i; ++j)
        longest = std::max(longest, (mesh.points.col(nodes[i]) - mesh.points.col(nodes[j])).norm());
    }
    const double volume = mesh.volume(e);
    const double flat = 1e-9 * longest * longest * longest;
    if (volume < -flat) {
      fail(body,
           fmt::format("element {} at {} is inverted (volume {:.3g} mm^3)", e, at(mesh.points.col(nodes[0])),
                       1e9 * volume),
           "positive volumes");
    }
    if (!(volume > flat)) {
      fail(body,
           fmt::format("element {} at {} is flat (volume {:.3g} mm^3)", e, at(mesh.points.col(nodes[0])), 1e9 * volume),
           "positive volumes");
    }
  }
  for (std::size_t node = 0; node < used.size(); ++node) {
    if (!used[node]) {
      fail(body, fmt::format("node {} at {} belongs to no element", node, at(mesh.points.col(node))),
           "nodes of elements only");
    }
  }
}

}  // namespace

double TetMesh::volume(Eigen::Index element) const {
  const Eigen::Vector3d origin = points.col(tets(0, element));
  const Eigen::Vector3d a = points.col(tets(1, element)) - origin, b = points.col(tets(2, element)) - origin,
                        c = points.col(tets(3, element)) - origin;
  return a.cross(b).dot(c) / 6.0;
}

namespace {
Eigen::Vector3d area_vector(const TetMesh& mesh, Eigen::Index face) {
  const Eigen::Vector3d origin = mesh.points.col(mesh.faces(0, face));
  const Eigen::Vector3d a = mesh.points.col(mesh.faces(1, face)) - origin;
  const Eigen::Vector3d b = mesh.points.col(mesh.faces(2, face)) - origin;
  return 0.5 * a.cross(b);
}
}  // namespace

double TetMesh::face_area(Eigen::Index face) const { return area_vector(*this, face).norm(); }

Eigen::Vector3d TetMesh::face_normal(Eigen::Index face) const { return area_vector(*this, face).normalized(); }

Eigen::Vector3d TetMesh::face_centre(Eigen::Index face) const {
  return (points.col(faces(0, face)) + points.col(faces(1, face)) + points.col(faces(2, face))) / 3.0;
}

double TetMesh::total_volume() const {
  double sum = 0.0;
  for (Eigen::Index e = 0; e < elements(); ++e) sum += volume(e);
  return sum;
}

void build_boundary(TetMesh& mesh, const std::string& body) {
  check_elements(mesh, body);
  std::vector<Side> sides;
  sides.reserve(4 * mesh.elements());
  for (int e = 0; e < mesh.elements(); ++e)
    for (int f = 0; f < 4; ++f) sides.push_back(make_side(mesh.tets, e, f));
  std::sort(sides.begin(), sides.end());
  std::vector<std::pair<int, int>> boundary;  // (element, local face), later in order of elements
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].key == sides[i].key) ++end;
    const Eigen::Vector3d place = mesh.points.col(sides[i].key[0]);
    if (end - i > 2) {
      fail(body,
           fmt::format("the triangle at {} belongs to {} elements ({}, {}, {}, ...)", at(place), end - i,
                       sides[i].element, sides[i + 1].element, sides[i + 2].element),
           "one or two elements a triangle");
    }
    if (end - i == 2 && sides[i].even == sides[i + 1].even) {
      fail(body, fmt::format("elements {} and {} at {} overlap", sides[i].element, sides[i + 1].element, at(place)),
           "neighbours on either side of their triangle");
    }
    if (end - i == 1) boundary.emplace_back(sides[i].element, sides[i].local);
    i = end;
  }
  std::sort(boundary.begin(), boundary.end());
  mesh.faces.resize(3, std::ssize(boundary));
  mesh.face_edges.resize(3, mesh.order() == 2 ? mesh.faces.cols() : 0);
  mesh.face_tet.resize(std::ssize(boundary));
  for (std::size_t i = 0; i < boundary.size(); ++i) {
    const auto [element, local] = boundary[i];
    for (int k = 0; k < 3; ++k) mesh.faces(k, i) = mesh.tets(local_face[local][k], element);
    if (mesh.order() == 2) {
      for (int k = 0; k < 3; ++k) {
        mesh.face_edges(k, i) = mesh.tet_edges(
            edge_between(local_face[local][face_edge[k][0]], local_face[local][face_edge[k][1]]), element);
      }
    }
    mesh.face_tet[i] = element;
  }
}

std::vector<int> find_faces(const TetMesh& mesh, const Eigen::Matrix3Xi& triangles) {
  const auto key_of = [](const Eigen::Vector3i& nodes) {
    Triple key{nodes[0], nodes[1], nodes[2]};
    std::sort(key.begin(), key.end());
    return key;
  };
  std::vector<std::pair<Triple, int>> known;
  known.reserve(mesh.face_count());
  for (Eigen::Index f = 0; f < mesh.face_count(); ++f) known.emplace_back(key_of(mesh.faces.col(f)), f);
  std::sort(known.begin(), known.end());
  std::vector<int> found(triangles.cols(), -1);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Triple key = key_of(triangles.col(i));
    const auto place = std::lower_bound(known.begin(), known.end(), std::pair<Triple, int>{key, -1});
    if (place != known.end() && place->first == key) found[i] = place->second;
  }
  return found;
}

namespace {

void promote(TetMesh& mesh) {
  struct Edge {
    int low, high, element, local;
    bool operator<(const Edge& other) const {
      return std::tie(low, high, element) < std::tie(other.low, other.high, other.element);
    }
  };
  std::vector<Edge> edges;
  edges.reserve(6 * mesh.elements());
  for (int e = 0; e < mesh.elements(); ++e) {
    for (int i = 0; i < 6; ++i) {
      const auto [low, high] = std::minmax(mesh.tets(tet_edge[i][0], e), mesh.tets(tet_edge[i][1], e));
      edges.push_back({low, high, e, i});
    }
  }
  std::sort(edges.begin(), edges.end());
  mesh.tet_edges.resize(6, mesh.elements());
  std::vector<std::pair<int, int>> ends;
  int next = mesh.nodes();
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const Edge& edge = edges[i];
    if (i == 0 || edge.low != edges[i - 1].low || edge.high != edges[i - 1].high) {
      ends.emplace_back(edge.low, edge.high);
      ++next;
    }
    mesh.tet_edges(edge.local, edge.element) = next - 1;
  }
  const Eigen::Index corners = mesh.nodes();
  mesh.points.conservativeResize(3, next);
  for (std::size_t i = 0; i < ends.size(); ++i)
    mesh.points.col(corners + i) = 0.5 * (mesh.points.col(ends[i].first) + mesh.points.col(ends[i].second));
}

void demote(TetMesh& mesh) {
  std::vector<int> number(mesh.nodes(), -1);
  for (Eigen::Index e = 0; e < mesh.elements(); ++e)
    for (const int node : mesh.tets.col(e)) number[node] = 0;
  int corners = 0;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] == 0) {
      mesh.points.col(corners) = mesh.points.col(i).eval();
      number[i] = corners++;
    }
  }
  mesh.points.conservativeResize(3, corners);
  const auto renumber = [&](int node) { return number[node]; };
  mesh.tets = mesh.tets.unaryExpr(renumber).eval();
  mesh.faces = mesh.faces.unaryExpr(renumber).eval();
  mesh.tet_edges.resize(6, 0);
  mesh.face_edges.resize(3, 0);
}

/// Corner of element e that is this node.
int corner_of(const TetMesh& mesh, Eigen::Index e, int node) {
  int corner = 0;
  while (mesh.tets(corner, e) != node) ++corner;
  return corner;
}

}  // namespace

void set_order(TetMesh& mesh, int order) {
  if (order == mesh.order()) return;
  if (order == 1) return demote(mesh);
  promote(mesh);
  mesh.face_edges.resize(3, mesh.face_count());
  for (Eigen::Index f = 0; f < mesh.face_count(); ++f) {
    const Eigen::Index e = mesh.face_tet[f];
    for (int k = 0; k < 3; ++k) {
      mesh.face_edges(k, f) = mesh.tet_edges(edge_between(corner_of(mesh, e, mesh.faces(face_edge[k][0], f)),
                                                          corner_of(mesh, e, mesh.faces(face_edge[k][1], f))),
                                             e);
    }
  }
}

Quality quality(const TetMesh& mesh) {
  Quality result;
  if (mesh.elements() == 0) return result;
  result.minimum = 1.0;
  result.shortest_edge = 1e300;
  Eigen::Index bad = 0;
  double sum = 0.0;
  for (Eigen::Index e = 0; e < mesh.elements(); ++e) {
    double squares = 0.0;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < i; ++j) {
        const double square = (mesh.points.col(mesh.tets(i, e)) - mesh.points.col(mesh.tets(j, e))).squaredNorm();
        squares += square;
        result.shortest_edge = std::min(result.shortest_edge, square);
        result.longest_edge = std::max(result.longest_edge, square);
      }
    }
    const double volume = std::max(mesh.volume(e), 0.0);
    const double value = squares > 0.0 ? 12.0 * std::pow(3.0 * volume, 2.0 / 3.0) / squares : 0.0;
    result.minimum = std::min(result.minimum, value);
    bad += value < 0.1;
    sum += value;
  }
  result.shortest_edge = std::sqrt(result.shortest_edge);
  result.longest_edge = std::sqrt(result.longest_edge);
  result.mean = sum / mesh.elements();
  result.below_0_1_percent = 100.0 * bad / mesh.elements();
  return result;
}

}  // namespace thermotwin::mesh
