// SPDX-License-Identifier: GPL-3.0-or-later
// Whether a triangulated surface encloses a volume, and the repair that is safe: welding.

#include "mesh/surface/check.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "core/error.h"
#include "mesh/surface/self_intersection.h"
#include "mesh/surface/surface.h"
#include "mesh/surface/winding_number.h"

namespace thermotwin::mesh {

namespace {

using Eigen::Vector3d;

[[noreturn]] void fail(const std::string& body, const std::string& found, const std::string& allowed) {
  throw core::MeshError("body '" + body + "'", found, allowed);
}

std::string at(const Vector3d& point) {
  return fmt::format("({:.4g}, {:.4g}, {:.4g}) mm", 1e3 * point.x(), 1e3 * point.y(), 1e3 * point.z());
}

Vector3d centre(const Surface& surface, Eigen::Index triangle) {
  Vector3d sum = Vector3d::Zero();
  for (int i = 0; i < 3; ++i) sum += surface.points.col(surface.triangles(i, triangle));
  return sum / 3.0;
}

struct Edge {
  int low, high;  ///< nodes
  int triangle;
  bool forward;  ///< runs from low to high
  auto key() const { return std::pair{low, high}; }
};

std::vector<Edge> sorted_edges(const Surface& surface) {
  std::vector<Edge> edges;
  edges.reserve(3 * surface.triangles.cols());
  for (int t = 0; t < surface.triangles.cols(); ++t) {
    for (int i = 0; i < 3; ++i) {
      const int a = surface.triangles(i, t), b = surface.triangles((i + 1) % 3, t);
      edges.push_back({std::min(a, b), std::max(a, b), t, a < b});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
    return x.key() != y.key() ? x.key() < y.key() : x.triangle < y.triangle;
  });
  return edges;
}

/// Calls visit(first, last) for each set of uses of one edge.
template <class Visit>
void for_each_edge(const std::vector<Edge>& edges, const Visit& visit) {
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end].key() == edges[i].key()) ++end;
    visit(i, end);
    i = end;
  }
}

void check_triangles(const Surface& surface, const std::string& body) {
  if (surface.triangles.cols() == 0) fail(body, "a surface without triangles", "a closed surface");
  if (!surface.points.allFinite()) fail(body, "a corner with a coordinate that is not a number", "finite coordinates");
  const Eigen::Index nodes = surface.points.cols();
  std::vector<std::pair<std::array<int, 3>, int>> keys;
  for (int t = 0; t < surface.triangles.cols(); ++t) {
    const Eigen::Vector3i corner = surface.triangles.col(t);
    if (corner.minCoeff() < 0 || corner.maxCoeff() >= nodes) {
      fail(body, fmt::format("triangle {} refers to a corner that does not exist", t),
           fmt::format("corners 0 .. {}", nodes - 1));
    }
    const Vector3d a = surface.points.col(corner[0]), b = surface.points.col(corner[1]),
                   c = surface.points.col(corner[2]);
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    if (!((b - a).cross(c - a).norm() > 1e-9 * longest * longest)) {
      fail(body, fmt::format("triangle {} at {} is degenerate (no area)", t, at(centre(surface, t))),
           "triangles with area");
    }
    std::array<int, 3> key{corner[0], corner[1], corner[2]};
    std::sort(key.begin(), key.end());
    keys.emplace_back(key, t);
  }
  std::sort(keys.begin(), keys.end());
  for (std::size_t i = 1; i < keys.size(); ++i) {
    if (keys[i].first == keys[i - 1].first) {
      fail(body,
           fmt::format("triangle {} at {} is a duplicate of triangle {}", keys[i].second,
                       at(centre(surface, keys[i].second)), keys[i - 1].second),
           "each triangle once");
    }
  }
}

void check_edges(const Surface& surface, const std::string& body) {
  const std::vector<Edge> edges = sorted_edges(surface);
  long open = 0, flipped = 0, crowded = 0;
  const Edge *first_open = nullptr, *first_flipped = nullptr, *first_crowded = nullptr;
  for_each_edge(edges, [&](std::size_t first, std::size_t last) {
    const Edge* edge = &edges[first];
    if (last - first == 1) {
      if (open++ == 0) first_open = edge;
    } else if (last - first > 2) {
      if (crowded++ == 0) first_crowded = edge;
    } else if (edges[first].forward == edges[first + 1].forward) {
      if (flipped++ == 0) first_flipped = &edges[first + 1];
    }
  });
  const auto middle = [&](const Edge* edge) {
    return at(0.5 * (surface.points.col(edge->low) + surface.points.col(edge->high)));
  };
  if (crowded > 0) {
    fail(body,
         fmt::format("{} edges belong to more than two triangles; the first at {} (triangle {})", crowded,
                     middle(first_crowded), first_crowded->triangle),
         "a surface that bounds one solid; parts that touch must be united before");
  }
  if (open > 0) {
    fail(body,
         fmt::format("the surface has holes: {} open edges; the first at {} (triangle {})", open, middle(first_open),
                     first_open->triangle),
         "a closed surface");
  }
  if (flipped > 0) {
    fail(body,
         fmt::format("flipped faces: at {} edges both neighbours turn the same way; the first at {} (triangle {})",
                     flipped, middle(first_flipped), first_flipped->triangle),
         "triangles that all turn counterclockwise seen from outside");
  }
}

double signed_volume(const Surface& surface) {
  double sum = 0.0;
  const Vector3d origin = surface.points.col(surface.triangles(0, 0));  // less cancellation
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    const Vector3d a = surface.points.col(surface.triangles(0, t)) - origin;
    const Vector3d b = surface.points.col(surface.triangles(1, t)) - origin;
    const Vector3d c = surface.points.col(surface.triangles(2, t)) - origin;
    sum += a.dot(b.cross(c)) / 6.0;
  }
  return sum;
}

}  // namespace

double winding(const Surface& surface, const Vector3d& point) {
  double sum = 0.0;
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    const Vector3d a = surface.points.col(surface.triangles(0, t)) - point;
    const Vector3d b = surface.points.col(surface.triangles(1, t)) - point;
    const Vector3d c = surface.points.col(surface.triangles(2, t)) - point;
    sum += share_of_triangle(a, b, c);
  }
  return sum;
}

Surface select(const Surface& surface, const std::vector<char>& take) {
  Surface part;
  part.part_names = surface.part_names;
  std::vector<int> renumber(surface.points.cols(), -1);
  std::vector<int> nodes, triangles;
  for (int t = 0; t < surface.triangles.cols(); ++t) {
    if (!take[t]) continue;
    triangles.push_back(t);
    for (int i = 0; i < 3; ++i) {
      int& number = renumber[surface.triangles(i, t)];
      if (number < 0) {
        number = nodes.size();
        nodes.push_back(surface.triangles(i, t));
      }
    }
  }
  part.points.resize(3, std::ssize(nodes));
  for (std::size_t n = 0; n < nodes.size(); ++n) part.points.col(n) = surface.points.col(nodes[n]);
  part.triangles.resize(3, std::ssize(triangles));
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (int i = 0; i < 3; ++i) part.triangles(i, t) = renumber[surface.triangles(i, triangles[t])];
    part.part.push_back(surface.part.empty() ? 0 : surface.part[triangles[t]]);
  }
  return part;
}

int weld(Surface& surface) {
  const Eigen::Index count = surface.points.cols();
  if (count == 0) return 0;
  const Vector3d low = surface.points.rowwise().minCoeff();
  const double extent = (surface.points.rowwise().maxCoeff() - low).maxCoeff();
  const double tolerance = 1e-6 * extent;
  // Cells of the tolerance's size: equal corners are in the same or in neighbouring cells.
  using Cell = std::array<long, 3>;
  struct Hash {
    std::size_t operator()(const Cell& c) const {
      const std::size_t x = c[0], y = c[1], z = c[2];
      return x * 73856093u ^ y * 19349663u ^ z * 83492791u;
    }
  };
  std::unordered_map<Cell, std::vector<int>, Hash> cells;
  std::vector<int> renumber(count);
  std::vector<Vector3d> kept;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Vector3d point = surface.points.col(i);
    Cell cell{0, 0, 0};
    if (tolerance > 0.0)
      for (std::size_t k = 0; k < 3; ++k) cell[k] = std::lround(std::floor((point[k] - low[k]) / tolerance));
    int same = -1;
    for (long dx = -1; dx <= 1 && same < 0; ++dx) {
      for (long dy = -1; dy <= 1 && same < 0; ++dy) {
        for (long dz = -1; dz <= 1 && same < 0; ++dz) {
          const auto found = cells.find({cell[0] + dx, cell[1] + dy, cell[2] + dz});
          if (found == cells.end()) continue;
          for (const int n : found->second) {
            if ((kept[n] - point).norm() <= tolerance) {
              same = n;
              break;
            }
          }
        }
      }
    }
    if (same < 0) {
      same = kept.size();
      kept.push_back(point);
      cells[cell].push_back(same);
    }
    renumber[i] = same;
  }
  surface.points.resize(3, std::ssize(kept));
  for (std::size_t n = 0; n < kept.size(); ++n) surface.points.col(n) = kept[n];
  Eigen::Index left = 0;
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    Eigen::Vector3i corner = surface.triangles.col(t);
    for (int& node : corner) node = renumber[node];
    if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) continue;
    surface.triangles.col(left) = corner;
    surface.part[left] = surface.part[t];
    ++left;
  }
  const int dropped = surface.triangles.cols() - left;
  surface.triangles.conservativeResize(3, left);
  surface.part.resize(left);
  return dropped;
}

double enclosed_volume(const Surface& surface) {
  double volume = 0.0;
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    const Vector3d a = surface.points.col(surface.triangles(0, t)), b = surface.points.col(surface.triangles(1, t)),
                   c = surface.points.col(surface.triangles(2, t));
    volume += a.dot(b.cross(c)) / 6.0;
  }
  return volume;
}

std::vector<int> shells(const Surface& surface, int& count) {
  std::vector<int> root(surface.points.cols());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int node) {
    while (root[node] != node) {
      root[node] = root[root[node]];
      node = root[node];
    }
    return node;
  };
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t)
    for (int i = 1; i < 3; ++i) root[find(surface.triangles(i, t))] = find(surface.triangles(0, t));
  std::vector<int> number(root.size(), -1), shell;
  count = 0;
  for (Eigen::Index t = 0; t < surface.triangles.cols(); ++t) {
    int& n = number[find(surface.triangles(0, t))];
    if (n < 0) n = count++;
    shell.push_back(n);
  }
  return shell;
}

std::vector<Surface> pieces(const Surface& surface, const std::string& body) {
  int count = 0;
  const std::vector<int> shell = shells(surface, count);
  std::vector<Surface> parts;
  for (int s = 0; s < count; ++s) {
    std::vector<char> take(shell.size());
    std::transform(shell.begin(), shell.end(), take.begin(), [&](int n) { return n == s; });
    parts.push_back(select(surface, take));
  }
  // Depth: how many other shells are around it. Solid at even depth, cavity at odd depth.
  const std::size_t n = count;
  std::vector<std::vector<std::size_t>> around(n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j)
      if (i != j && std::abs(winding(parts[j], parts[i].points.col(0))) > 0.5) around[i].push_back(j);
  }
  std::vector<std::vector<std::size_t>> cavities(n);
  for (std::size_t i = 0; i < n; ++i) {
    const bool solid = around[i].size() % 2 == 0;
    const double volume = signed_volume(parts[i]);
    if ((volume > 0.0) != solid) {
      fail(body,
           fmt::format("the surface at {} is inside out (volume {:.4g} mm^3)", at(centre(parts[i], 0)), 1e9 * volume),
           solid ? "normals that point out of the solid" : "normals of a cavity that point into it");
    }
    if (!solid) {
      cavities[*std::max_element(around[i].begin(), around[i].end(), [&](std::size_t a, std::size_t b) {
        return around[a].size() < around[b].size();
      })].push_back(i);
    }
  }
  std::vector<Surface> result;
  for (std::size_t i = 0; i < n; ++i) {
    if (around[i].size() % 2 != 0) continue;
    std::vector<char> take(shell.size());
    std::transform(shell.begin(), shell.end(), take.begin(), [&](std::size_t s) {
      return s == i || std::find(cavities[i].begin(), cavities[i].end(), s) != cavities[i].end();
    });
    result.push_back(select(surface, take));
  }
  return result;
}

void check_extent(const Eigen::Matrix3Xd& points, const std::string& body, const std::string& file) {
  const std::string place = "body '" + body + "': " + file;
  if (points.cols() == 0) throw core::MeshError(place, "no points", "a body");
  const double extent = (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).maxCoeff();
  if (extent >= 0.001 && extent <= 50.0) return;
  throw core::MeshError(place, fmt::format("a largest extent of {:.4g} m; the unit may be wrong", extent),
                        "0.001 m .. 50 m (key unit = \"mm\", \"m\" or \"in\" of the body in machine.toml)");
}

void check_surface(const Surface& surface, const std::string& body, const std::string& file) {
  check_triangles(surface, body);
  check_extent(surface.points, body, file);
  check_edges(surface, body);
  check_self_intersection(surface, body);
  (void)pieces(surface, body);  // inside and outside have a meaning only now
}

}  // namespace thermotwin::mesh
