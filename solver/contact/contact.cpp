// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/contact/contact.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

#include "mesh/body/convex_polygon.h"
#include "mesh/body/shape.h"
#include "mesh/body/triangle_tree.h"

namespace thermotwin::solver {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using mesh::Polygon;
using mesh::TetMesh;

namespace {

constexpr double opposed_cosine = -0.5;  // outward normals more than 120 deg apart
constexpr double sliver = 1e-12;         // of the slave triangle's area
constexpr double covered = 1e-9;         // of the slave triangle's area: rounding of a sum of pieces
constexpr double rounding = 1e-12;       // m, of corners: a gap of just the reach is within it
constexpr double double_cover = 1e-8;    // of the slave triangle's area: that is none yet

/// Barycentric coordinates of a triangle in the plane, corners in the columns: a row times (1, x, y) each.
Matrix3d barycentric_lines(const Eigen::Matrix<double, 2, 3>& corners) {
  Matrix3d m;
  m << Eigen::RowVector3d::Ones(), corners;
  return m.inverse();
}

Vector3d weights_at(const Matrix3d& lines, const Vector2d& at) {
  const Vector3d weights = (lines * Vector3d(1.0, at[0], at[1])).cwiseMax(0.0);  // rounding at the edges
  return weights / weights.sum();
}

/// What a slave triangle and one master triangle have in common, in the slave's plane.
struct Piece {
  int master;  // place in the master's surface
  Polygon polygon;
  double area;
  Matrix3d lines;  // of the master's barycentric coordinates
  Vector3d gap;    // times (1, x, y): m along the slave's normal
};

/// Where the slave sees several layers of the master, the nearest one counts.
void keep_nearest(std::vector<Piece>& pieces, double area_of_slave) {
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    for (std::size_t j = i + 1; j < pieces.size(); ++j) {
      if (pieces[i].polygon.empty() || pieces[j].polygon.empty()) continue;
      const Polygon both = mesh::common_part(pieces[i].polygon, pieces[j].polygon);
      if (mesh::area(both) <= double_cover * area_of_slave) continue;
      const Vector2d at = mesh::middle(both);
      const auto distance = [&](std::size_t k) { return std::abs(pieces[k].gap.dot(Vector3d(1.0, at[0], at[1]))); };
      const std::size_t farther = distance(j) < distance(i) ? i : j;
      const Piece whole = pieces[farther];
      pieces[farther].polygon.clear();
      for (Polygon& part : mesh::less(whole.polygon, both)) {
        const double area = mesh::area(part);
        if (area > sliver * area_of_slave)
          pieces.push_back({whole.master, std::move(part), area, whole.lines, whole.gap});
      }
    }
  }
  std::erase_if(pieces, [](const Piece& piece) { return piece.polygon.empty(); });
  std::stable_sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.master < b.master; });
}

/// The ground is everywhere: no pairs, one rule a triangle.
std::vector<ContactPoint> on_ground(const TetMesh& slave, const std::vector<int>& faces) {
  std::vector<ContactPoint> contact;
  for (const int face : faces) {
    const double area = slave.face_area(face);
    const Vector3d normal = slave.face_normal(face);
    const Matrix3d corners = slave.points(Eigen::all, Eigen::Vector3i(slave.faces.col(face)));
    for (const mesh::FacePoint& point : mesh::face_rule(2 * slave.order()))
      contact.push_back({face, -1, point.at, Vector3d::Zero(), area * point.share, corners * point.at, normal});
  }
  return contact;
}

}  // namespace

const std::vector<int>& faces_of(const mesh::MachineMesh& mesh, const std::string& surface) {
  return mesh.surfaces[mesh.machine.surface_index(surface)];
}

const TetMesh& body_of(const mesh::MachineMesh& mesh, const std::string& surface) {
  return mesh.body_of_surface(mesh.machine.surface_index(surface));
}

struct ContactSearch::Impl {
  /// The master's triangles with what is asked of them at every position.
  struct Master {
    Master(const TetMesh& of, const std::vector<int>& surface)
        : body(of),
          faces(surface),
          triangles(of.faces(Eigen::all, surface)),
          normals(3, triangles.cols()),
          tree(of.points, triangles) {
      for (Eigen::Index t = 0; t < triangles.cols(); ++t) normals.col(t) = of.face_normal(surface[t]);
    }
    const TetMesh& body;
    const std::vector<int>& faces;
    Eigen::Matrix3Xi triangles;
    Eigen::Matrix3Xd normals;
    mesh::TriangleTree tree;
  };

  const TetMesh& slave;
  const std::vector<int>& slave_faces;
  std::unique_ptr<const Master> master;  // none: the ground
  double reach;
  int degree = 0;  // of the product of two shape functions

  /// Pieces of the slave triangle with these corners, in the master's home frame.
  void find_pieces(const Matrix3d& corners, const Matrix3d& frame, const Eigen::Matrix<double, 2, 3>& flat, double area,
                   std::vector<int>& candidates, std::vector<Piece>& pieces) const {
    const Vector3d origin = corners.col(0), normal = frame.row(2);
    Eigen::AlignedBox3d box;
    for (int i = 0; i < 3; ++i) {
      box.extend(Vector3d(corners.col(i) + reach * normal));
      box.extend(Vector3d(corners.col(i) - reach * normal));
    }
    master->tree.find(box, candidates);
    std::sort(candidates.begin(), candidates.end());
    const Vector2d low = flat.rowwise().minCoeff(), high = flat.rowwise().maxCoeff();
    pieces.clear();
    double sum = 0.0;
    Polygon polygon, spare;
    for (const int t : candidates) {
      if (master->normals.col(t).dot(normal) >= opposed_cosine) continue;
      Matrix3d local;
      for (int i = 0; i < 3; ++i) local.col(i) = frame * (master->body.points.col(master->triangles(i, t)) - origin);
      const Vector3d least = local.rowwise().minCoeff(), most = local.rowwise().maxCoeff();
      if ((least.head<2>().array() >= high.array()).any() || (most.head<2>().array() <= low.array()).any()) continue;
      if (least[2] >= reach || most[2] <= -reach) continue;
      const Matrix3d lines = barycentric_lines(local.topRows<2>());
      const Vector3d gap = lines.transpose() * local.row(2).transpose();
      polygon.assign({flat.col(0), flat.col(1), flat.col(2)});
      for (int i = 0; i < 3; ++i) mesh::cut(polygon, lines.row(i), spare);
      if (most[2] > reach) mesh::cut(polygon, Vector3d(reach, 0, 0) - gap, spare);
      if (least[2] < -reach) mesh::cut(polygon, Vector3d(reach, 0, 0) + gap, spare);
      const double common = mesh::area(polygon);
      if (common <= sliver * area) continue;
      pieces.push_back({t, polygon, common, lines, gap});
      sum += common;
    }
    if (std::abs(sum - area) > covered * area) keep_nearest(pieces, area);
  }
};

ContactSearch::ContactSearch(const mesh::MachineMesh& mesh, const mesh::JointSpec& joint)
    : impl_(new Impl{body_of(mesh, joint.slave), faces_of(mesh, joint.slave), nullptr, joint.reach + rounding}) {
  impl_->degree = 2 * impl_->slave.order();
  if (joint.master.empty()) return;
  const TetMesh& master = body_of(mesh, joint.master);
  impl_->master = std::make_unique<const Impl::Master>(master, faces_of(mesh, joint.master));
  impl_->degree = std::max(impl_->degree, 2 * master.order());
}
ContactSearch::~ContactSearch() = default;
ContactSearch::ContactSearch(ContactSearch&&) noexcept = default;

std::vector<ContactPoint> ContactSearch::at(const Eigen::Isometry3d& slave_from_home,
                                            const Eigen::Isometry3d& master_from_home) const {
  const TetMesh& slave = impl_->slave;
  if (!impl_->master) return on_ground(slave, impl_->slave_faces);
  const Eigen::Isometry3d master_from_slave = master_from_home.inverse() * slave_from_home;
  const std::vector<mesh::FacePoint>& rule = mesh::face_rule(impl_->degree);
  std::vector<ContactPoint> contact;
  std::vector<int> candidates;
  std::vector<Piece> pieces;
  for (const int face : impl_->slave_faces) {
    const Matrix3d home = slave.points(Eigen::all, Eigen::Vector3i(slave.faces.col(face)));
    const Vector3d normal = slave.face_normal(face), along = (home.col(1) - home.col(0)).normalized();
    Matrix3d frame;  // of the triangle's plane: along an edge, across it, outward
    frame << along.transpose(), normal.cross(along).transpose(), normal.transpose();
    const Eigen::Matrix<double, 2, 3> flat = frame.topRows<2>() * (home.colwise() - home.col(0));
    const double area = slave.face_area(face);
    const Matrix3d corners = (master_from_slave.linear() * home).colwise() + master_from_slave.translation();
    impl_->find_pieces(corners, frame * master_from_slave.linear().transpose(), flat, area, candidates, pieces);
    if (pieces.empty()) continue;
    const Matrix3d lines = barycentric_lines(flat);
    for (const Piece& piece : pieces) {
      for (std::size_t k = 2; k < piece.polygon.size(); ++k) {
        const Vector2d a = piece.polygon[0], b = piece.polygon[k - 1], c = piece.polygon[k];
        const double part = 0.5 * ((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0]);
        if (part <= 0.0) continue;
        for (const mesh::FacePoint& point : rule) {
          const Vector2d at = point.at[0] * a + point.at[1] * b + point.at[2] * c;
          const Vector3d weights = weights_at(lines, at);
          contact.push_back({face, impl_->master->faces[piece.master], weights, weights_at(piece.lines, at),
                             part * point.share, home * weights, normal});
        }
      }
    }
  }
  return contact;
}

std::vector<ContactPoint> find_contact(const mesh::MachineMesh& mesh, const mesh::JointSpec& joint,
                                       const Eigen::Isometry3d& slave_from_home,
                                       const Eigen::Isometry3d& master_from_home) {
  return ContactSearch(mesh, joint).at(slave_from_home, master_from_home);
}

}  // namespace thermotwin::solver
