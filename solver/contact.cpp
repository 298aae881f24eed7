// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/contact.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include "core/error.h"
#include "mesh/shape.h"
#include "mesh/triangle_tree.h"

namespace thermotwin::solver {

using Eigen::Vector3d;
using mesh::TetMesh;

namespace {

constexpr double opposed_cosine = -0.5;  // outward normals more than 120 deg apart
constexpr double lateral_tolerance = 1e-5;  // m beyond the rim that still counts as on the surface
constexpr double on_edge = 1e-7;  // barycentric weight below which a point lies on the edge

struct SubPoint {
  Vector3d weights;
  double share;  // of the triangle's area
};

/// The triangle cut into n^2 equal ones, each with a rule exact for the product of two shape
/// functions of this order where the whole triangle is in contact, and fine enough for the edge of
/// the contact where it is not.
std::vector<SubPoint> sub_points(int n, int order) {
  const std::vector<mesh::FacePoint>& rule = mesh::face_rule(2 * order);
  std::vector<SubPoint> points;
  points.reserve(rule.size() * static_cast<std::size_t>(n * n));
  const auto add = [&](const Vector3d& a, const Vector3d& b, const Vector3d& c) {
    for (const mesh::FacePoint& point : rule)
      points.push_back({point.at[0] * a + point.at[1] * b + point.at[2] * c, point.share / (n * n)});
  };
  const auto corner = [&](int i, int j) {
    return Vector3d(static_cast<double>(n - i - j) / n, static_cast<double>(i) / n, static_cast<double>(j) / n);
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j) {
      add(corner(i, j), corner(i + 1, j), corner(i, j + 1));
      if (i + j + 1 < n) add(corner(i + 1, j + 1), corner(i, j + 1), corner(i + 1, j));
    }
  return points;
}

double longest_edge(const TetMesh& body, int face) {
  const Vector3d a = body.points.col(body.faces(0, face)), b = body.points.col(body.faces(1, face)),
                 c = body.points.col(body.faces(2, face));
  return std::sqrt(std::max({(a - b).squaredNorm(), (b - c).squaredNorm(), (c - a).squaredNorm()}));
}

/// The master's triangles, with the rim of their set: beyond it there is nothing to touch.
class MasterSurface {
 public:
  MasterSurface(const TetMesh& body, const std::vector<int>& faces)
      : body_(body), faces_(faces), triangles_(select(body, faces)), tree_(body.points, triangles_) {
    std::map<std::pair<int, int>, int> uses;
    for (Eigen::Index t = 0; t < triangles_.cols(); ++t)
      for (int i = 0; i < 3; ++i) ++uses[edge(t, i)];
    rim_edges_.resize(faces.size());
    normals_.resize(3, triangles_.cols());
    double length = 0.0;
    for (Eigen::Index t = 0; t < triangles_.cols(); ++t) {
      const int face = faces[static_cast<std::size_t>(t)];
      normals_.col(t) = body.face_normal(face);
      length += longest_edge(body, face);
      for (int i = 0; i < 3; ++i) {
        const auto key = edge(t, i);
        const bool rim = uses[key] == 1;
        rim_edges_[static_cast<std::size_t>(t)][static_cast<std::size_t>(i)] = rim;
        if (rim) rim_nodes_.insert({key.first, key.second});
      }
    }
    mean_edge_ = faces.empty() ? 0.0 : length / static_cast<double>(faces.size());
  }

  double mean_edge() const { return mean_edge_; }

  /// @return place of the triangle touched, -1 for none
  int touch(const Vector3d& p, const Vector3d& normal, double reach, std::vector<int>& candidates,
            Vector3d& weights) const {
    const Vector3d margin = Vector3d::Constant(reach);
    tree_.find(Eigen::AlignedBox3d(p - margin, p + margin), candidates);
    int best = -1;
    double best_distance = reach;
    Vector3d best_point = p;
    for (int t : candidates) {
      if (normals_.col(t).dot(normal) >= opposed_cosine) continue;
      const Vector3d q = mesh::nearest_on_triangle(p, corner(t, 0), corner(t, 1), corner(t, 2));
      const double distance = (q - p).norm();
      // Equal distances happen on shared edges; the smaller index keeps the result unique.
      if (distance < best_distance || (distance == best_distance && (best < 0 || t < best))) {
        best = t;
        best_distance = distance;
        best_point = q;
      }
    }
    if (best < 0) return -1;
    weights = barycentric(best, best_point);
    if (on_rim(best, weights)) {
      const Vector3d gap = p - best_point, n = normals_.col(best);
      if ((gap - gap.dot(n) * n).norm() > lateral_tolerance) return -1;
    }
    return best;
  }

 private:
  static Eigen::Matrix3Xi select(const TetMesh& body, const std::vector<int>& faces) {
    Eigen::Matrix3Xi triangles(3, static_cast<Eigen::Index>(faces.size()));
    for (std::size_t i = 0; i < faces.size(); ++i)
      triangles.col(static_cast<Eigen::Index>(i)) = body.faces.col(faces[i]);
    return triangles;
  }
  /// Edge opposite to corner i, nodes in rising order.
  std::pair<int, int> edge(Eigen::Index t, int i) const {
    return std::minmax(triangles_((i + 1) % 3, t), triangles_((i + 2) % 3, t));
  }
  Vector3d corner(int t, int i) const { return body_.points.col(triangles_(i, t)); }

  Vector3d barycentric(int t, const Vector3d& q) const {
    const Vector3d a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
    const Vector3d n = (b - a).cross(c - a);
    Vector3d w;
    w[0] = (b - q).cross(c - q).dot(n);
    w[1] = (c - q).cross(a - q).dot(n);
    w[2] = (a - q).cross(b - q).dot(n);
    w = w.cwiseMax(0.0);
    return w / w.sum();
  }

  bool on_rim(int t, const Vector3d& weights) const {
    int zeros = 0, last_zero = 0, corner_at = 0;
    for (int i = 0; i < 3; ++i) {
      if (weights[i] < on_edge) {
        ++zeros;
        last_zero = i;
      } else {
        corner_at = i;
      }
    }
    if (zeros == 0) return false;
    if (zeros == 1) return rim_edges_[static_cast<std::size_t>(t)][static_cast<std::size_t>(last_zero)];
    return rim_nodes_.contains(triangles_(corner_at, t));
  }

  const TetMesh& body_;
  const std::vector<int>& faces_;
  Eigen::Matrix3Xi triangles_;
  mesh::TriangleTree tree_;
  Eigen::Matrix3Xd normals_;
  std::vector<std::array<bool, 3>> rim_edges_;  // edge opposite to corner i
  std::set<int> rim_nodes_;
  double mean_edge_ = 0;
};

const std::vector<int>& faces_of(const mesh::MachineMesh& mesh, const std::string& surface) {
  return mesh.surfaces[static_cast<std::size_t>(mesh.machine.surface_index(surface))];
}

const TetMesh& body_of(const mesh::MachineMesh& mesh, const std::string& surface) {
  return mesh.body_of_surface(mesh.machine.surface_index(surface));
}

/// Shortest extent of the connected sets along a direction, m.
double shortest_extent(const TetMesh& body, const std::vector<int>& faces, const Vector3d& direction) {
  const std::vector<int> set = connected_sets(body, faces);
  std::map<int, std::pair<double, double>> extent;
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (int i = 0; i < 3; ++i) {
      const double along = direction.dot(body.points.col(body.faces(i, faces[f])));
      const auto at = extent.try_emplace(set[f], along, along).first;
      at->second.first = std::min(at->second.first, along);
      at->second.second = std::max(at->second.second, along);
    }
  double shortest = std::numeric_limits<double>::infinity();
  for (const auto& [id, range] : extent) shortest = std::min(shortest, range.second - range.first);
  return shortest;
}

/// Positions of the axis in the workspace grids.
std::vector<double> workspace_positions(const mesh::Machine& machine, const std::string& axis) {
  std::vector<double> positions;
  const auto collect = [&](const std::vector<std::string>& axes, const std::vector<std::vector<double>>& lists) {
    for (std::size_t i = 0; i < axes.size(); ++i)
      if (axes[i] == axis) positions.insert(positions.end(), lists[i].begin(), lists[i].end());
  };
  collect(machine.workspace.axes, machine.workspace.positions);
  collect(machine.workspace.table_axes, machine.workspace.table_positions);
  return positions;
}

/// Sorted corners with evenly divided gaps no longer than spacing.
std::vector<double> divide_evenly(std::vector<double> corners, double spacing, double merge) {
  std::sort(corners.begin(), corners.end());
  std::vector<double> kept;
  for (double c : corners)
    if (kept.empty() || c - kept.back() > merge) kept.push_back(c);
  std::vector<double> grid{kept.front()};
  for (std::size_t i = 1; i < kept.size(); ++i) {
    const double length = kept[i] - kept[i - 1];
    const int cells = std::max(1, static_cast<int>(std::ceil(length / spacing - 1e-9)));
    for (int k = 1; k <= cells; ++k) grid.push_back(k == cells ? kept[i] : kept[i - 1] + length * k / cells);
  }
  return grid;
}

}  // namespace

std::vector<int> connected_sets(const TetMesh& body, const std::vector<int>& faces) {
  std::vector<int> parent(faces.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto find = [&](int i) {
    while (parent[static_cast<std::size_t>(i)] != i)
      i = parent[static_cast<std::size_t>(i)] = parent[static_cast<std::size_t>(parent[static_cast<std::size_t>(i)])];
    return i;
  };
  std::map<int, int> seen;
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (int i = 0; i < 3; ++i) {
      const auto [at, fresh] = seen.try_emplace(body.faces(i, faces[f]), static_cast<int>(f));
      if (!fresh) {
        const int a = find(static_cast<int>(f)), b = find(at->second);
        parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
      }
    }
  std::map<int, int> number;
  std::vector<int> set(faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f)
    set[f] = number.try_emplace(find(static_cast<int>(f)), static_cast<int>(number.size())).first->second;
  return set;
}

std::vector<ContactPoint> find_contact(const mesh::MachineMesh& mesh, const mesh::JointSpec& joint,
                                       const Eigen::Isometry3d& slave_from_home,
                                       const Eigen::Isometry3d& master_from_home) {
  const TetMesh& slave = body_of(mesh, joint.slave);
  const std::vector<int>& slave_faces = faces_of(mesh, joint.slave);
  std::vector<ContactPoint> contact;

  if (joint.master.empty()) {
    const std::vector<SubPoint> points = sub_points(1, slave.order());
    for (int face : slave_faces) {
      const double area = slave.face_area(face);
      const Vector3d normal = slave.face_normal(face);
      const Eigen::Vector3i nodes = slave.faces.col(face);
      for (const SubPoint& s : points)
        contact.push_back({face, -1, s.weights, Vector3d::Zero(), area * s.share,
                           slave.points(Eigen::all, nodes) * s.weights, normal});
    }
    return contact;
  }

  const std::vector<int>& master_faces = faces_of(mesh, joint.master);
  const MasterSurface master(body_of(mesh, joint.master), master_faces);
  const Eigen::Isometry3d master_from_slave = master_from_home.inverse() * slave_from_home;
  const int order = std::max(slave.order(), body_of(mesh, joint.master).order());
  const std::vector<SubPoint> rules[3] = {sub_points(2, order), sub_points(3, order), sub_points(4, order)};
  const std::vector<SubPoint> fine_rule = sub_points(12, 1);
  std::vector<int> candidates;
  for (int face : slave_faces) {
    // A slave triangle that is long against the master's needs more points to see all of them.
    const double ratio = longest_edge(slave, face) / master.mean_edge();
    const std::vector<SubPoint>& rule = rules[ratio > 1.5 ? 2 : ratio > 0.75 ? 1 : 0];
    const double area = slave.face_area(face);
    const Vector3d normal = slave.face_normal(face);
    const Vector3d normal_in_master = master_from_slave.linear() * normal;
    const Eigen::Vector3i nodes = slave.faces.col(face);
    const Eigen::Matrix3d corners = slave.points(Eigen::all, nodes);
    const std::size_t before = contact.size();
    const auto touch = [&](const std::vector<SubPoint>& points) {
      for (const SubPoint& s : points) {
        const Vector3d position = corners * s.weights;
        Vector3d weights;
        const int touched =
            master.touch(master_from_slave * position, normal_in_master, joint.reach, candidates, weights);
        if (touched >= 0)
          contact.push_back({face, master_faces[static_cast<std::size_t>(touched)], s.weights, weights, area * s.share,
                             position, normal});
      }
      return contact.size() - before;
    };
    const std::size_t found = touch(rule);
    if (found == 0 || found == rule.size()) continue;
    // The rim of the contact runs through the triangle: its area wants more points.
    contact.resize(before);
    touch(fine_rule);
  }
  return contact;
}

std::vector<double> contact_grid(const mesh::MachineMesh& mesh, const mesh::JointSpec& joint) {
  if (joint.axis.empty()) return {0.0};
  const mesh::Axis& axis = mesh.machine.axes[static_cast<std::size_t>(mesh.machine.axis_index(joint.axis))];
  std::vector<double> corners = workspace_positions(mesh.machine, axis.id);
  constexpr double turn = 2.0 * std::numbers::pi;
  if (axis.kind == mesh::AxisKind::rotary) {
    constexpr double spacing = turn / 12.0;
    if (!axis.endless) {
      std::erase_if(corners, [&](double x) { return x < axis.low || x > axis.high; });
      corners.insert(corners.end(), {axis.low, axis.high});
      return divide_evenly(std::move(corners), spacing, 1e-9);
    }
    for (double& x : corners) x -= turn * std::floor(x / turn + 1e-12);
    corners.insert(corners.end(), {0.0, turn});
    std::vector<double> grid = divide_evenly(std::move(corners), spacing, 1e-9);
    grid.pop_back();  // a full turn is the first node again
    return grid;
  }
  std::erase_if(corners, [&](double x) { return x < axis.low || x > axis.high; });
  corners.insert(corners.end(), {axis.low, axis.high});
  const double extent = shortest_extent(body_of(mesh, joint.slave), faces_of(mesh, joint.slave), axis.direction);
  const double travel = axis.high - axis.low;
  // A slave surface without extent along the axis (a ring in a plane) gives no length to go by.
  const double spacing = extent > 1e-3 * travel ? 0.5 * extent : travel / 20.0;
  return divide_evenly(std::move(corners), std::isfinite(spacing) && spacing > 0 ? spacing : 1.0, 1e-7);
}

Pads find_pads(const mesh::MachineMesh& mesh, const mesh::JointSpec& joint) {
  const TetMesh& body = body_of(mesh, joint.slave);
  const std::vector<int>& faces = faces_of(mesh, joint.slave);
  const std::vector<int> set = connected_sets(body, faces);

  std::map<int, Eigen::AlignedBox3d> boxes;
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (int i = 0; i < 3; ++i) boxes[set[f]].extend(Vector3d(body.points.col(body.faces(i, faces[f]))));

  const Vector3d axis = joint.sector_axis.normalized();
  const Vector3d east = axis.unitOrthogonal(), north = axis.cross(east);
  const auto cell_of = [&](std::size_t f) {
    const Vector3d centre = body.face_centre(faces[f]);
    if (joint.sectors > 0) {
      const Vector3d r = centre - joint.sector_point;
      const double turns = std::atan2(r.dot(north), r.dot(east)) / (2.0 * std::numbers::pi);
      return std::min(joint.sectors - 1, static_cast<int>((turns - std::floor(turns)) * joint.sectors));
    }
    int cell = 0;
    for (int k = 0; k < 3; ++k) {
      const Eigen::AlignedBox3d& box = boxes.at(set[f]);
      const double length = box.sizes()[k];
      const double share = length > 0 ? (centre[k] - box.min()[k]) / length : 0.0;
      cell = cell * joint.divide[k] + std::clamp(static_cast<int>(share * joint.divide[k]), 0, joint.divide[k] - 1);
    }
    return cell;
  };

  std::map<std::pair<int, int>, int> number;
  std::vector<std::pair<int, int>> keys(faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f) number.emplace(keys[f] = {set[f], cell_of(f)}, 0);
  Pads pads;
  for (auto& [key, id] : number) id = pads.count++;
  for (const auto& key : keys) pads.of_face.push_back(number.at(key));
  return pads;
}

}  // namespace thermotwin::solver
