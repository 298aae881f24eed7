// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/export/skin.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <iterator>
#include <queue>
#include <tuple>
#include <utility>

namespace thermotwin::solver {
namespace {

using Eigen::Index;
using Eigen::Matrix4d;
using Eigen::Vector3d;

/// Share of its squared length that an edge costs beside the quadric: on even faces the shortest edges go first.
constexpr double length_share = 0.01;
/// Cosine of the largest turn of a triangle's normal in one collapse.
constexpr double least_turn = 0.3;
constexpr Index fewest = 8;  ///< vertices of a body

/// The boundaries of all bodies as one surface whose vertices are taken out.
class Surface {
public:
  explicit Surface(const mesh::MachineMesh& mesh) : left_of_(mesh.bodies.size(), 0) {
    for (std::size_t b = 0; b < mesh.bodies.size(); ++b) add(mesh.bodies[b], mesh.first_node[b], b);
    quadrics_.assign(points_.size(), Matrix4d::Zero());
    stamps_.assign(points_.size(), 0);
    triangles_of_.resize(points_.size());
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      const Vector3d normal = normal_of(triangles_[t]).normalized();
      Eigen::Vector4d plane;
      plane << normal, -normal.dot(points_[triangles_[t][0]]);
      const Matrix4d quadric = plane * plane.transpose();
      for (const int v : triangles_[t]) {
        quadrics_[v] += quadric;
        triangles_of_[v].push_back(t);
      }
    }
  }

  void thin(Index most) {
    for (std::size_t v = 0; v < points_.size(); ++v) offer(v);
    while (left_ > most && !queue_.empty()) {
      const Collapse next = queue_.top();
      queue_.pop();
      if (next.stamps != stamps(next.from, next.into) || left_of_[body_[next.from]] <= fewest) continue;
      if (keeps_shape(next.from, next.into)) collapse(next.from, next.into);
    }
  }

  Skin skin() const {
    Skin skin;
    std::vector<int> number(points_.size(), -1);
    skin.points.resize(3, left_);
    for (std::size_t v = 0; v < points_.size(); ++v) {
      while (skin.first.size() <= body_[v]) skin.first.push_back(std::ssize(skin.nodes));
      if (triangles_of_[v].empty()) continue;
      number[v] = std::ssize(skin.nodes);
      skin.points.col(number[v]) = points_[v];
      skin.nodes.push_back(nodes_[v]);
    }
    while (skin.first.size() <= left_of_.size()) skin.first.push_back(std::ssize(skin.nodes));
    std::vector<Eigen::Vector3i> kept;
    for (const auto& [a, b, c] : triangles_)
      if (a >= 0) kept.emplace_back(number[a], number[b], number[c]);
    skin.triangles.resize(3, std::ssize(kept));
    for (std::size_t t = 0; t < kept.size(); ++t) skin.triangles.col(t) = kept[t];
    return skin;
  }

private:
  using Triangle = std::array<int, 3>;
  struct Collapse {
    double cost = 0;
    int from = 0, into = 0;
    std::pair<int, int> stamps;
    /// The cheapest first; equal ones by their vertices, so the order is that of no queue.
    bool operator<(const Collapse& other) const {
      return std::tie(other.cost, other.from, other.into) < std::tie(cost, from, into);
    }
  };

  void add(const mesh::TetMesh& body, Index first_node, std::size_t b) {
    std::vector<int> vertex(body.nodes(), -1);
    for (const int node : body.faces.reshaped()) vertex[node] = 0;
    for (int n = 0; n < body.nodes(); ++n) {
      if (vertex[n] < 0) continue;
      vertex[n] = std::ssize(points_);
      points_.emplace_back(body.points.col(n));
      nodes_.push_back(first_node + n);
      body_.push_back(b);
      ++left_of_[b];
    }
    for (const auto face : body.faces.colwise())
      triangles_.push_back({vertex[face[0]], vertex[face[1]], vertex[face[2]]});
    left_ = std::ssize(points_);
  }

  Vector3d normal_of(const Triangle& t) const {
    return (points_[t[1]] - points_[t[0]]).cross(points_[t[2]] - points_[t[0]]);
  }
  std::pair<int, int> stamps(int from, int into) const { return {stamps_[from], stamps_[into]}; }

  std::vector<int> neighbours(int v) const {
    std::vector<int> all;
    for (const std::size_t t : triangles_of_[v])
      for (const int other : triangles_[t])
        if (other != v) all.push_back(other);
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
  }

  double cost(int from, int into) const {
    const Eigen::Vector4d point = points_[into].homogeneous();
    return std::max(point.dot((quadrics_[from] + quadrics_[into]) * point), 0.0) +
           length_share * (points_[from] - points_[into]).squaredNorm();
  }

  /// Both ways of each edge of a vertex.
  void offer(int v) {
    for (const int other : neighbours(v)) {
      queue_.push({cost(v, other), v, other, stamps(v, other)});
      queue_.push({cost(other, v), other, v, stamps(other, v)});
    }
  }

  /// No triangle turns over, and the surface stays one without a crease of its own: the two ends of the edge have the
  /// tips of its two triangles in common and nothing else.
  bool keeps_shape(int from, int into) const {
    Index shared = 0;
    for (const std::size_t t : triangles_of_[from]) {
      Triangle triangle = triangles_[t];
      if (std::find(triangle.begin(), triangle.end(), into) != triangle.end()) {
        ++shared;
        continue;
      }
      const Vector3d before = normal_of(triangle);
      std::replace(triangle.begin(), triangle.end(), from, into);
      const Vector3d after = normal_of(triangle);
      if (before.dot(after) <= least_turn * before.norm() * after.norm()) return false;
    }
    const std::vector<int> one = neighbours(from), other = neighbours(into);
    std::vector<int> common;
    std::set_intersection(one.begin(), one.end(), other.begin(), other.end(), std::back_inserter(common));
    return shared == 2 && std::ssize(common) == 2;
  }

  void collapse(int from, int into) {
    for (const std::size_t t : triangles_of_[from]) {
      Triangle& triangle = triangles_[t];
      if (std::find(triangle.begin(), triangle.end(), into) != triangle.end()) {
        for (const int v : triangle)
          if (v != from) std::erase(triangles_of_[v], t);
        triangle.fill(-1);
      } else {
        std::replace(triangle.begin(), triangle.end(), from, into);
        triangles_of_[into].push_back(t);
      }
    }
    triangles_of_[from].clear();
    quadrics_[into] += quadrics_[from];
    ++stamps_[from];
    ++stamps_[into];
    --left_;
    --left_of_[body_[from]];
    offer(into);
  }

  std::vector<Vector3d> points_;
  std::vector<Index> nodes_;         ///< of the machine mesh
  std::vector<std::size_t> body_;    ///< of each vertex
  std::vector<Triangle> triangles_;  ///< -1: gone
  std::vector<std::vector<std::size_t>> triangles_of_;
  std::vector<Matrix4d> quadrics_;
  std::vector<int> stamps_;  ///< change with the vertex: older offers no longer hold
  std::priority_queue<Collapse> queue_;
  std::vector<Index> left_of_;  ///< vertices of each body
  Index left_ = 0;
};

}  // namespace

Skin make_skin(const mesh::MachineMesh& mesh, Index most) {
  Surface surface(mesh);
  surface.thin(most);
  return surface.skin();
}

}  // namespace thermotwin::solver
