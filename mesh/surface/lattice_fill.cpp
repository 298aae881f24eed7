// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/surface/lattice_fill.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <vector>

#include "mesh/body/triangle_tree.h"
#include "mesh/surface/lattice.h"
#include "mesh/surface/winding_number.h"

namespace thermotwin::mesh {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;
using Tet = std::array<int, 4>;

/// A lattice point moves onto the surface where it is nearer to it than this, over the length of the cut edge: the
/// values of Labelle and Shewchuk for which no tetrahedron becomes flat.
constexpr double snap_long = 0.24999, snap_short = 0.41189;
constexpr int halvings = 14;       // of an edge, to find where it is cut
constexpr int samples = 4;         // along each edge of a cube that triangles touch
constexpr int cubes_of_block = 4;  // a side
constexpr double whole = 0.15;     // a winding number this far from a whole number is ambiguous

enum class Side : signed char { outside = -1, on = 0, inside = 1 };

/// Where a segment meets a triangle, as a share of its length; -1: nowhere (Moeller and Trumbore, 1997).
/// @param slack  of barycentric coordinates: what lies beyond an edge by less meets it too
double share_to_triangle(const Vector3d& from, const Vector3d& along, const Vector3d& a, const Vector3d& b,
                         const Vector3d& c, double slack) {
  const Vector3d u = b - a, v = c - a, w = from - a, across = along.cross(v), other = w.cross(u);
  const double height = u.dot(across);
  if (height == 0.0) return -1.0;
  const double beta = w.dot(across) / height, gamma = along.dot(other) / height, share = v.dot(other) / height;
  const bool meets = beta >= -slack && gamma >= -slack && beta + gamma <= 1.0 + slack && share >= 0.0 && share <= 1.0;
  return meets ? share : -1.0;
}

class Cutter {
public:
  Cutter(const Surface& surface, double spacing)
      : surface_(surface),
        lattice_(surface, spacing),
        winding_(surface),
        tree_(surface.points, surface.triangles),
        side_(lattice_.size(), Side::outside),
        moved_(lattice_.size(), -1) {}

  double volume_inside() {
    classify();
    return fill_.inside;
  }

  LatticeFill run() {
    classify();
    snap();
    cut();
    return collect();
  }

private:
  Side side(const Vector3d& point) const { return winding_.inside(point) ? Side::inside : Side::outside; }

  /// A point whose winding number is known.
  struct Known {
    Vector3d point;
    double number;
    bool clear() const { return std::abs(number - std::round(number)) < whole; }
  };

  /// The winding number of a point: each triangle that the way from the known point crosses changes it by one.
  /// @param near  all triangles that the way may cross
  double number_at(const Known& known, const Vector3d& point, const std::vector<int>& near) const {
    double number = std::round(known.number);
    const Vector3d along = point - known.point;
    for (const int t : near) {
      const Vector3i corner = surface_.triangles.col(t);
      const Vector3d a = surface_.points.col(corner[0]), b = surface_.points.col(corner[1]),
                     c = surface_.points.col(corner[2]);
      if (share_to_triangle(known.point, along, a, b, c, 0.0) < 0.0) continue;
      number += (b - a).cross(c - a).dot(along) < 0.0 ? 1.0 : -1.0;
    }
    return number;
  }

  /// The same from two known points, which disagree where a way meets an edge of triangles: then it is summed up.
  double number_at(const std::array<Known, 2>& known, const Vector3d& point, const std::vector<int>& near) const {
    if (known[0].clear() && known[1].clear()) {
      const double number = number_at(known[0], point, near);
      if (number == number_at(known[1], point, near)) return number;
    }
    return winding_(point);
  }

  std::array<Known, 2> known_in(const Eigen::AlignedBox3d& box) const {
    // Off the middle by no simple part of the box: a way along an edge of the file is unlikely.
    const Vector3d first = box.center(), second = box.min() + Vector3d(0.41, 0.37, 0.44).cwiseProduct(box.sizes());
    return {Known{first, winding_(first)}, Known{second, winding_(second)}};
  }

  /// Blocks of cubes without triangles lie on one side. Elsewhere each point is asked.
  void classify() {
    const Vector3i cubes = lattice_.cubes();
    const double cube = std::pow(lattice_.spacing(), 3);
    std::vector<int> near;
    for_each_place(Vector3i::Zero(), cubes - Vector3i::Ones(), cubes_of_block, [&](const Vector3i& first) {
      const Vector3i end = (first.array() + cubes_of_block).min(cubes.array());
      const Eigen::AlignedBox3d box(lattice_.point(2 * first), lattice_.point(2 * end));
      tree_.find(box, near);
      const std::array<Known, 2> known = known_in(box);
      const bool clear = near.empty() && known[0].clear();
      const Side all = known[0].number > 0.5 ? Side::inside : Side::outside;
      if (clear && all == Side::inside) fill_.inside += cube * (end - first).prod();
      // The points on the far faces belong to the next block.
      for_each_place(2 * first, 2 * end - Vector3i::Ones(), 1, [&](const Vector3i& place) {
        if (place[0] % 2 != place[1] % 2 || place[0] % 2 != place[2] % 2) return;
        const bool inside = clear ? all == Side::inside : number_at(known, lattice_.point(place), near) > 0.5;
        side_[lattice_.index(place)] = inside ? Side::inside : Side::outside;
      });
      if (!clear)
        for_each_place(first, end - Vector3i::Ones(), 1, [&](const Vector3i& place) { sample(place, known, near); });
    });
  }

  /// How much of a cube is inside. @param known, near  of its block
  void sample(const Vector3i& cube, const std::array<Known, 2>& known, const std::vector<int>& near) {
    const double volume = std::pow(lattice_.spacing(), 3);
    const Eigen::AlignedBox3d box(lattice_.point(2 * cube), lattice_.point(2 * cube + Vector3i::Constant(2)));
    tree_.find(box, found_);
    const double number = number_at(known, box.center(), near);
    if (found_.empty()) {
      if (number > 0.5) fill_.inside += volume;
      if (std::abs(number - std::round(number)) > whole) fill_.ambiguous += volume;
      return;
    }
    const Known centre{box.center(), number};
    int hits = 0;
    for_each_place(Vector3i::Zero(), Vector3i::Constant(samples - 1), 1, [&](const Vector3i& at) {
      const Vector3d point = box.min() + (at.cast<double>() + Vector3d::Constant(0.5)) * (lattice_.spacing() / samples);
      hits += (centre.clear() ? number_at(centre, point, found_) : winding_(point)) > 0.5;
    });
    fill_.inside += volume * hits / (samples * samples * samples);
  }

  const Vector3d& at(int node) const { return nodes_[node]; }

  /// Where the edge between two sides is cut: at the first triangle behind which the other side lies; without a
  /// triangle (in a hole) by halving.
  Vector3d crossing(const Vector3d& from, const Vector3d& to, Side of_from) {
    Eigen::AlignedBox3d box(from);
    tree_.find(box.extend(to), found_);
    std::vector<double> at;
    for (const int t : found_) {
      const Vector3i corner = surface_.triangles.col(t);
      if (const double share = share_to_triangle(from, to - from, surface_.points.col(corner[0]),
                                                 surface_.points.col(corner[1]), surface_.points.col(corner[2]), 1e-9);
          share >= 0.0)
        at.push_back(share);
    }
    std::sort(at.begin(), at.end());
    for (std::size_t i = 0; i < at.size(); ++i) {
      const double behind = 0.5 * (at[i] + (i + 1 < at.size() ? at[i + 1] : 1.0));
      if (i + 1 == at.size() || side(from + behind * (to - from)) != of_from) return from + at[i] * (to - from);
    }
    double low = 0.0, high = 1.0;
    for (int n = 0; n < halvings; ++n) {
      const double middle = 0.5 * (low + high);
      (side(from + middle * (to - from)) == of_from ? low : high) = middle;
    }
    return from + 0.5 * (low + high) * (to - from);
  }

  /// Lattice points very near to the surface move onto it, each along the edge that is cut nearest.
  void snap() {
    static const std::vector<Vector3i> steps = [] {
      std::vector<Vector3i> all;
      for (int k = 0; k < 3; ++k) all.insert(all.end(), {2 * Vector3i::Unit(k), -2 * Vector3i::Unit(k)});
      for_each_place(Vector3i::Constant(-1), Vector3i::Ones(), 2, [&](const Vector3i& step) { all.push_back(step); });
      return all;
    }();
    for_each_place(Vector3i::Zero(), 2 * lattice_.cubes(), 1, [&](const Vector3i& place) {
      if (place[0] % 2 != place[1] % 2 || place[0] % 2 != place[2] % 2) return;
      const int node = lattice_.index(place);
      const Vector3d here = lattice_.point(place);
      double nearest = std::numeric_limits<double>::infinity();
      Vector3d target;
      for (const Vector3i& step : steps) {
        if (!lattice_.has(place + step)) continue;
        const Side other = side_[lattice_.index(place + step)];
        if (other == Side::on || other == side_[node]) continue;
        const Vector3d there = lattice_.point(place + step), cut = crossing(here, there, side_[node]);
        const double limit = step.squaredNorm() == 4 ? snap_long : snap_short, length = (there - here).norm();
        if (const double distance = (cut - here).norm(); distance < limit * length && distance < nearest)
          nearest = distance, target = cut;
      }
      if (!std::isfinite(nearest)) return;
      side_[node] = Side::on;
      moved_[node] = targets_.size();
      targets_.push_back(target);
    });
  }

  /// Every tetrahedron of the lattice: the edge between the centres of two cubes and an edge of their common face.
  void cut() {
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3i u = Vector3i::Unit(axis), v = Vector3i::Unit((axis + 1) % 3), w = Vector3i::Unit((axis + 2) % 3);
      for_each_place(Vector3i::Zero(), lattice_.cubes() - Vector3i::Ones() - u, 1, [&](const Vector3i& cube) {
        const Vector3i c = 2 * cube + Vector3i::Ones(), d = c + 2 * u;
        const std::array<Vector3i, 4> ring{c + u - v - w, c + u + v - w, c + u + v + w, c + u - v + w};
        for (std::size_t e = 0; e < 4; ++e) cut_tet({c, d, ring[e], ring[(e + 1) % 4]});
      });
    }
  }

  int node_of(const Vector3i& place) {
    const int lattice = lattice_.index(place);
    const auto [entry, fresh] = node_number_.emplace(lattice, nodes_.size());
    if (fresh) {
      nodes_.push_back(moved_[lattice] < 0 ? lattice_.point(place) : targets_[moved_[lattice]]);
      rank_.push_back(lattice);
    }
    return entry->second;
  }
  int cut_node(const Vector3i& in, const Vector3i& out) {
    const std::array<int, 2> key{lattice_.index(in), lattice_.index(out)};
    const auto [entry, fresh] = cut_number_.emplace(key, nodes_.size());
    if (fresh) {
      nodes_.push_back(crossing(lattice_.point(in), lattice_.point(out), Side::inside));
      rank_.push_back(lattice_.size() + cut_number_.size());
    }
    return entry->second;
  }

  void add(int a, int b, int c, int d) {
    const double six = (at(b) - at(a)).cross(at(c) - at(a)).dot(at(d) - at(a));
    tets_.push_back(six > 0.0 ? Tet{a, b, c, d} : Tet{b, a, c, d});
  }

  /// A quadrilateral and an apex. The diagonal starts at the corner of lowest rank, as it does in the neighbour.
  void add_pyramid(const std::array<int, 4>& quad, int apex) {
    const auto lowest = std::min_element(quad.begin(), quad.end(), [&](int a, int b) { return rank_[a] < rank_[b]; });
    const std::size_t s = lowest - quad.begin();
    add(quad[s], quad[(s + 1) % 4], quad[(s + 2) % 4], apex);
    add(quad[s], quad[(s + 2) % 4], quad[(s + 3) % 4], apex);
  }

  /// Triangles a0 a1 a2 and b0 b1 b2 with edges a_i b_i: a tetrahedron and a pyramid, seen from the lowest corner.
  void add_prism(std::array<int, 3> a, std::array<int, 3> b) {
    std::size_t s = 0;
    for (std::size_t i = 1; i < 3; ++i)
      if (std::min(rank_[a[i]], rank_[b[i]]) < std::min(rank_[a[s]], rank_[b[s]])) s = i;
    if (rank_[b[s]] < rank_[a[s]]) std::swap(a, b);
    const std::size_t t = (s + 1) % 3, u = (s + 2) % 3;
    add(a[s], b[0], b[1], b[2]);
    add_pyramid({a[t], a[u], b[u], b[t]}, a[s]);
  }

  void cut_tet(const std::array<Vector3i, 4>& corner) {
    std::vector<Vector3i> in, on, out;
    for (const Vector3i& place : corner) {
      const Side s = side_[lattice_.index(place)];
      (s == Side::inside ? in : s == Side::on ? on : out).push_back(place);
    }
    if (in.empty() && on.size() < 4) return;
    if (out.empty()) {
      std::array<int, 4> n{};
      if (in.empty()) {  // four points on the surface: a thin place, or a corner of the outside
        Vector3d centre = Vector3d::Zero();
        for (const Vector3i& place : on) centre += targets_[moved_[lattice_.index(place)]] / 4.0;
        if (!winding_.inside(centre)) return;
      }
      for (std::size_t i = 0; i < 4; ++i) n[i] = node_of(corner[i]);
      return add(n[0], n[1], n[2], n[3]);
    }
    if (in.size() == 1) {
      std::vector<int> n{node_of(in[0])};
      for (const Vector3i& place : on) n.push_back(node_of(place));
      for (const Vector3i& place : out) n.push_back(cut_node(in[0], place));
      return add(n[0], n[1], n[2], n[3]);
    }
    if (in.size() == 3) {
      add_prism({node_of(in[0]), node_of(in[1]), node_of(in[2])},
                {cut_node(in[0], out[0]), cut_node(in[1], out[0]), cut_node(in[2], out[0])});
    } else if (out.size() == 2) {
      add_prism({node_of(in[0]), cut_node(in[0], out[0]), cut_node(in[0], out[1])},
                {node_of(in[1]), cut_node(in[1], out[0]), cut_node(in[1], out[1])});
    } else {
      add_pyramid({node_of(in[0]), node_of(in[1]), cut_node(in[1], out[0]), cut_node(in[0], out[0])}, node_of(on[0]));
    }
  }

  double volume(const Tet& t) const {
    return (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).dot(at(t[3]) - at(t[0])) / 6.0;
  }

  /// Pieces of less than a thousandth of the body go: crumbs of walls thinner than the lattice.
  LatticeFill collect() {
    std::vector<int> root(nodes_.size());
    std::iota(root.begin(), root.end(), 0);
    const auto find = [&](int node) {
      while (root[node] != node) node = root[node] = root[root[node]];
      return node;
    };
    for (const Tet& t : tets_)
      for (std::size_t i = 1; i < 4; ++i) root[find(t[i])] = find(t[0]);
    std::map<int, double> held;
    double total = 0.0;
    for (const Tet& t : tets_) held[find(t[0])] += volume(t), total += volume(t);
    std::vector<int> number(nodes_.size(), -1), nodes;
    std::vector<Tet> kept;
    for (const Tet& t : tets_) {
      if (held[find(t[0])] < 1e-3 * total) continue;
      Tet& renumbered = kept.emplace_back();
      for (std::size_t i = 0; i < 4; ++i) {
        if (number[t[i]] < 0) number[t[i]] = nodes.size(), nodes.push_back(t[i]);
        renumbered[i] = number[t[i]];
      }
      fill_.volume += volume(t);
    }
    fill_.crumbs =
        std::count_if(held.begin(), held.end(), [&](const auto& piece) { return piece.second < 1e-3 * total; });
    fill_.points.resize(3, std::ssize(nodes));
    for (std::size_t n = 0; n < nodes.size(); ++n) fill_.points.col(n) = at(nodes[n]);
    fill_.tets.resize(4, std::ssize(kept));
    for (std::size_t t = 0; t < kept.size(); ++t) fill_.tets.col(t) = Eigen::Map<const Eigen::Vector4i>(kept[t].data());
    return std::move(fill_);
  }

  const Surface& surface_;
  const Lattice lattice_;
  const WindingNumber winding_;
  const TriangleTree tree_;
  std::vector<Side> side_;         // of each lattice point
  std::vector<int> moved_;         // of each lattice point: index into targets_, or -1
  std::vector<Vector3d> targets_;  // where moved points went
  std::vector<Vector3d> nodes_;    // of tetrahedra
  std::vector<long> rank_;         // of each node: lattice points first
  std::map<int, int> node_number_;
  std::map<std::array<int, 2>, int> cut_number_;
  std::vector<Tet> tets_;
  LatticeFill fill_;
  std::vector<int> found_;  // triangles, kept to save allocations
};

}  // namespace

double lattice_points(const Surface& surface, double spacing) {
  const Vector3d extent = surface.points.rowwise().maxCoeff() - surface.points.rowwise().minCoeff();
  return 2.0 * ((extent / spacing).array() + 5.0).prod();
}

double volume_inside(const Surface& surface, double spacing) { return Cutter(surface, spacing).volume_inside(); }

LatticeFill fill_by_lattice(const Surface& surface, double spacing) { return Cutter(surface, spacing).run(); }

}  // namespace thermotwin::mesh
