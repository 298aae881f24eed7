// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/body_check.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <numeric>

#include "core/error.h"
#include "core/progress.h"
#include "mesh/body/tet_locator.h"
#include "mesh/body/triangle_tree.h"

namespace thermotwin::mesh {

namespace {

constexpr double largest_overlap = 0.005;  // of the smaller body; facets of round fits cut into each other by less

std::string point_text(const Eigen::Vector3d& p) {
  return fmt::format("[{:.4g}, {:.4g}, {:.4g}] mm", 1e3 * p[0], 1e3 * p[1], 1e3 * p[2]);
}

Eigen::Vector3d centre(const TetMesh& mesh, Eigen::Index element) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < 4; ++i) sum += mesh.points.col(mesh.tets(i, element));
  return 0.25 * sum;
}

/// Some elements of a body: their volume and its centre.
struct Share {
  Eigen::Index elements = 0;
  double volume = 0.0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();

  void add(const TetMesh& mesh, Eigen::Index element) {
    const double v = mesh.volume(element);
    ++elements;
    volume += v;
    moment += v * centre(mesh, element);
  }
  Eigen::Vector3d middle() const { return moment / volume; }
};

/// Least distance of the piece's skin to the skin of all others, m.
double distance_to_others(const TetMesh& mesh, const Pieces& pieces, int piece) {
  std::vector<Eigen::Index> own, other;
  for (Eigen::Index f = 0; f < mesh.face_count(); ++f)
    (pieces.of_element[mesh.face_tet[f]] == piece ? own : other).push_back(f);
  const Eigen::Matrix3Xi triangles = mesh.faces(Eigen::all, other), inside = mesh.faces(Eigen::all, own);
  // Corners against triangles, both ways: exact but for two edges that cross at a distance.
  double least = std::numeric_limits<double>::infinity();
  const auto one_way = [&](const Eigen::Matrix3Xi& from, const Eigen::Matrix3Xi& to) {
    const TriangleTree tree(mesh.points, to);
    for (const int node : from.reshaped()) least = std::min(least, tree.nearest(mesh.points.col(node)).distance);
  };
  one_way(inside, triangles);
  one_way(triangles, inside);
  return least;
}

/// Elements of one whose centre lies in the other.
Share overlap(const TetMesh& one, const TetLocator& other) {
  Share share;
  for (Eigen::Index e = 0; e < one.elements(); ++e)
    if (other.find(centre(one, e)) >= 0) share.add(one, e);
  return share;
}

}  // namespace

Pieces connected_pieces(const TetMesh& mesh) {
  std::vector<int> root(mesh.nodes());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int node) {
    while (root[node] != node) node = root[node] = root[root[node]];
    return node;
  };
  for (Eigen::Index e = 0; e < mesh.elements(); ++e)
    for (int i = 1; i < 4; ++i) root[find(mesh.tets(i, e))] = find(mesh.tets(0, e));
  Pieces pieces;
  std::vector<int> number(root.size(), -1);
  for (Eigen::Index e = 0; e < mesh.elements(); ++e) {
    int& own = number[find(mesh.tets(0, e))];
    if (own < 0) own = pieces.count++;
    pieces.of_element.push_back(own);
  }
  return pieces;
}

void check_pieces(const BodySpec& spec, const TetMesh& mesh, const std::string& place) {
  const Pieces pieces = connected_pieces(mesh);
  if (pieces.count == spec.pieces) return;
  if (pieces.count < spec.pieces) {
    throw core::MeshError(
        place,
        fmt::format("body '{}' has {} unconnected {}", spec.id, pieces.count, pieces.count == 1 ? "piece" : "pieces"),
        fmt::format("pieces = {} as machine.toml states, or pieces = {}", spec.pieces, pieces.count));
  }
  std::vector<Share> shares(pieces.count);
  for (Eigen::Index e = 0; e < mesh.elements(); ++e) shares[pieces.of_element[e]].add(mesh, e);
  const auto least = std::min_element(shares.begin(), shares.end(),
                                      [](const Share& a, const Share& b) { return a.volume < b.volume; });
  throw core::MeshError(
      place,
      fmt::format("body '{}' falls into {} pieces; the smallest ({:.4g} cm3, {} elements) lies around {}, {:.3g} mm "
                  "from the others",
                  spec.id, pieces.count, 1e6 * least->volume, least->elements, point_text(least->middle()),
                  1e3 * distance_to_others(mesh, pieces, least - shares.begin())),
      fmt::format("{} (let solids share faces in CAD, or make each a body with a joint between them; state pieces = {} "
                  "if they are meant to be apart)",
                  spec.pieces == 1 ? "one piece" : fmt::format("pieces = {} as machine.toml states", spec.pieces),
                  pieces.count));
}

void check_overlaps(const Machine& machine, const std::vector<TetMesh>& bodies) {
  std::vector<std::unique_ptr<TetLocator>> locators;
  for (const TetMesh& body : bodies) locators.push_back(std::make_unique<TetLocator>(body));
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      if (!locators[a]->box().intersects(locators[b]->box())) continue;
      Share shared = overlap(bodies[a], *locators[b]);
      if (const Share other = overlap(bodies[b], *locators[a]); other.volume > shared.volume) shared = other;
      const double smaller = std::min(bodies[a].total_volume(), bodies[b].total_volume());
      if (shared.volume <= largest_overlap * smaller) continue;
      const BodySpec &one = machine.bodies[a], &two = machine.bodies[b];
      throw core::MeshError(
          fmt::format("{} bodies '{}' and '{}'", machine.path.string(), one.id, two.id),
          fmt::format(
              "they fill the same place around {} with all axes at home: {:.4g} cm3, {:.3g} % of the smaller one",
              point_text(shared.middle()), 1e6 * shared.volume, 100.0 * shared.volume / smaller),
          fmt::format("bodies that touch at most; check the unit and the position of {} and {}",
                      one.cad.filename().string(), two.cad.filename().string()));
    }
  }
}

void warn_of_poor_quality(const BodySpec& spec, const TetMesh& mesh) {
  const Quality found = quality(mesh);
  if (found.minimum >= poor_quality) return;
  core::warn(
      fmt::format("body '{}': the worst element has a quality of {:.2g} (regular: 1; {:.2g} % of {} elements below "
                  "0.1). Another element_size_mm, or CAD without slivers and nearly coincident faces, improves it",
                  spec.id, found.minimum, found.below_0_1_percent, mesh.elements()));
}

}  // namespace thermotwin::mesh
