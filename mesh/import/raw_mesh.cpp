// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/raw_mesh.h"

#include <Eigen/Dense>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/error.h"
#include "core/progress.h"
#include "mesh/surface/check.h"

namespace thermotwin::mesh {

namespace {

void check_tets(const RawMesh& raw, const std::string& body) {
  for (std::size_t e = 0; e < raw.tets.size(); ++e) {
    const auto fail = [&](const std::string& what) {
      std::string place = "body '" + body + "': " + raw.source;
      if (!raw.tet_lines.empty()) place += fmt::format(":{}", raw.tet_lines[e]);
      throw core::MeshError(place, fmt::format("element {} {}", raw.tet_labels[e], what),
                            "tetrahedra of positive volume with four nodes");
    };
    const auto& nodes = raw.tets[e];
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < i; ++j)
        if (nodes[i] == nodes[j]) fail(fmt::format("has node {} twice", raw.node_labels[nodes[i]]));
    }
    std::array<Eigen::Vector3d, 4> p;
    for (std::size_t i = 0; i < 4; ++i) p[i] = raw.points[nodes[i]];
    double longest = 0.0;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < i; ++j) longest = std::max(longest, (p[i] - p[j]).norm());
    const double volume = (p[1] - p[0]).cross(p[2] - p[0]).dot(p[3] - p[0]) / 6.0;
    const double flat = 1e-9 * longest * longest * longest;
    if (!std::isfinite(volume)) fail("has a node with a coordinate that is not a number");
    if (volume < -flat) fail(fmt::format("is inverted (volume {:.4g} in units of the file)", volume));
    if (!(volume > flat)) fail(fmt::format("is flat (volume {:.4g} in units of the file)", volume));
  }
}

constexpr double largest_bow = 0.25;  // of an edge node off the middle, over the edge's length
constexpr double straight = 1e-6;

/// Puts the nodes of all edges into the middle. @throws MeshError, see finish
void straighten(const RawMesh& raw, const std::string& body, double unit_m, std::vector<Eigen::Vector3d>& points) {
  std::map<std::pair<int, int>, int> middle;
  double largest = 0.0;
  std::set<int> moved;
  for (std::size_t e = 0; e < raw.tets.size(); ++e) {
    for (std::size_t i = 0; i < 6; ++i) {
      const auto [low, high] = std::minmax(raw.tets[e][tet_edge[i][0]], raw.tets[e][tet_edge[i][1]]);
      const int node = raw.edges[e][i];
      const std::size_t at = node;
      const Eigen::Vector3d a = raw.points[low], b = raw.points[high];
      const double off = (raw.points[at] - 0.5 * (a + b)).norm(), length = (b - a).norm();
      if (!(off <= largest_bow * length) || middle.emplace(std::pair(low, high), node).first->second != node) {
        std::string place = "body '" + body + "': " + raw.source;
        if (!raw.tet_lines.empty()) place += fmt::format(":{}", raw.tet_lines[e]);
        throw core::MeshError(
            place,
            fmt::format("element {}: node {} on the edge of nodes {} and {}{}", raw.tet_labels[e], raw.node_labels[at],
                        raw.node_labels[low], raw.node_labels[high],
                        off <= largest_bow * length ? " is not that of a neighbour" : " is far from its middle"),
            "one node near the middle of each edge, in the order of the format");
      }
      if (off > straight * length) moved.insert(node);
      largest = std::max(largest, off);
      points[at] = 0.5 * (a + b);
    }
  }
  if (!moved.empty()) {
    core::warn(fmt::format("body '{}': {}: edges are kept straight: {} edge nodes move by up to {:.3g} mm", body,
                           raw.source, moved.size(), 1e3 * unit_m * largest));
  }
}

/// Numbers of the nodes that tetrahedra use, in the file's order; -1: orphans.
struct Renumbering {
  std::vector<int> of;  // by the file's index
  int nodes = 0;

  Renumbering(const RawMesh& raw, bool quadratic) : of(raw.points.size(), -1) {
    for (const auto& tet : raw.tets)
      for (const int node : tet) of[node] = 0;
    if (quadratic) {
      for (const auto& edges : raw.edges)
        for (const int node : edges) of[node] = 0;
    }
    for (int& number : of)
      if (number == 0) number = nodes++;
  }
};

void warn_of_left_out(const RawMesh& raw, const std::string& body, bool quadratic, std::size_t orphans) {
  if (!quadratic && !raw.edges.empty()) {
    core::warn(fmt::format("body '{}': {}: linear and quadratic tetrahedra are mixed; all are read as linear ones",
                           body, raw.source));
  } else if (orphans > 0) {
    core::warn(
        fmt::format("body '{}': {}: {} nodes belong to no tetrahedron and are left out", body, raw.source, orphans));
  }
}

void fill(TetMesh& mesh, const RawMesh& raw, const std::vector<Eigen::Vector3d>& points, const Renumbering& number,
          bool quadratic, double unit_m) {
  mesh.points.resize(3, number.nodes);
  for (std::size_t i = 0; i < number.of.size(); ++i)
    if (number.of[i] >= 0) mesh.points.col(number.of[i]) = unit_m * points[i];
  mesh.tets.resize(4, std::ssize(raw.tets));
  for (std::size_t e = 0; e < raw.tets.size(); ++e)
    for (int i = 0; i < 4; ++i) mesh.tets(i, e) = number.of[raw.tets[e][i]];
  if (!quadratic) return;
  mesh.tet_edges.resize(6, mesh.elements());
  for (std::size_t e = 0; e < raw.edges.size(); ++e)
    for (int i = 0; i < 6; ++i) mesh.tet_edges(i, e) = number.of[raw.edges[e][i]];
}

/// Boundary faces of the file's sets by name.
std::map<std::string, std::set<int>> face_groups(const TetMesh& mesh, const RawMesh& raw, const Renumbering& number) {
  std::map<std::string, std::set<int>> groups;
  for (const auto& [name, triangles] : raw.face_sets) {
    Eigen::Matrix3Xi columns(3, std::ssize(triangles));
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (int i = 0; i < 3; ++i) columns(i, t) = number.of[triangles[t][i]];
    for (const int face : find_faces(mesh, columns))
      if (face >= 0) groups[name].insert(face);  // interfaces inside the body are no boundary
  }
  for (const auto& [name, set] : raw.node_sets) {
    std::vector<char> in(number.nodes, 0);
    for (const int node : set)
      if (number.of[node] >= 0) in[number.of[node]] = 1;
    for (int f = 0; f < mesh.face_count(); ++f) {
      const Eigen::Vector3i corner = mesh.faces.col(f);
      if (std::all_of(corner.begin(), corner.end(), [&](int node) { return in[node] != 0; })) groups[name].insert(f);
    }
  }
  for (const auto& [name, set] : raw.element_sets) {
    const std::set<int> elements(set.begin(), set.end());
    for (int f = 0; f < mesh.face_count(); ++f)
      if (elements.count(mesh.face_tet[f]) > 0) groups[name].insert(f);
  }
  return groups;
}

}  // namespace

TetMesh finish(const RawMesh& raw, const ImportOptions& options) {
  if (raw.tets.empty())
    throw core::MeshError("body '" + options.body + "': " + raw.source, "no tetrahedra", "a tetrahedral volume mesh");
  check_tets(raw, options.body);
  TetMesh mesh;
  mesh.solids = raw.solids;
  const bool quadratic = raw.edges.size() == raw.tets.size();
  std::vector<Eigen::Vector3d> points = raw.points;
  if (quadratic) straighten(raw, options.body, options.unit_m, points);
  const Renumbering number(raw, quadratic);
  warn_of_left_out(raw, options.body, quadratic, raw.points.size() - number.nodes);
  fill(mesh, raw, points, number, quadratic, options.unit_m);
  check_extent(mesh.points, options.body, raw.source);
  build_boundary(mesh, options.body);
  for (const auto& [name, faces] : face_groups(mesh, raw, number)) mesh.groups[name].assign(faces.begin(), faces.end());
  return mesh;
}

}  // namespace thermotwin::mesh
