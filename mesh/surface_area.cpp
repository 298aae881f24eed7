// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/surface_area.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "core/progress.h"
#include "mesh/body/convex_polygon.h"
#include "mesh/selection.h"

namespace thermotwin::mesh {

namespace {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr double face_cosine = 0.766;  // 40 deg, as the edges along which surface files are cut
constexpr double box_slack = 1e-9;     // m; a face in a side of its box belongs to it
constexpr double whole_face = 0.9;     // share in the box from which a face that is wholly taken counts whole

/// The number of each boundary triangle's face.
std::vector<int> faces_of(const TetMesh& mesh) {
  const int count = mesh.face_count();
  std::map<std::pair<int, int>, std::vector<int>> at_edge;
  std::vector<Vector3d> normals;
  for (int f = 0; f < count; ++f) {
    normals.push_back(mesh.face_normal(f));
    for (int i = 0; i < 3; ++i) {
      const int a = mesh.faces(i, f), b = mesh.faces((i + 1) % 3, f);
      at_edge[std::minmax(a, b)].push_back(f);
    }
  }
  std::vector<int> number(count, -1), open;
  int found = 0;
  for (int start = 0; start < count; ++start) {
    if (number[start] >= 0) continue;
    number[start] = found;
    open.assign(1, start);
    while (!open.empty()) {
      const int f = open.back();
      open.pop_back();
      for (int i = 0; i < 3; ++i) {
        const int a = mesh.faces(i, f), b = mesh.faces((i + 1) % 3, f);
        for (const int next : at_edge[std::minmax(a, b)]) {
          if (number[next] >= 0 || normals[f].dot(normals[next]) < face_cosine) continue;
          number[next] = found;
          open.push_back(next);
        }
      }
    }
    ++found;
  }
  return number;
}

/// A triangle's plane, in which its pieces lie.
struct Plane {
  Vector3d origin, u, v;

  Plane(const TetMesh& mesh, int face) : origin(mesh.points.col(mesh.faces(0, face))) {
    u = (mesh.points.col(mesh.faces(1, face)) - origin).normalized();
    v = mesh.face_normal(face).cross(u);
  }
  Vector2d in_plane(const Vector3d& p) const { return {u.dot(p - origin), v.dot(p - origin)}; }
  /// sign * (x_k - limit) >= 0 in the plane's coordinates
  Vector3d line(int k, double limit, double sign) const { return sign * Vector3d(origin[k] - limit, u[k], v[k]); }
};

using Pieces2d = std::vector<Polygon>;

/// What a rule without its box takes, and the box.
struct Part {
  std::vector<char> takes;
  const Rule* rule;
};

struct CutSurface {
  bool cut = false;              ///< a box takes part, its own or that of an exception
  std::vector<Part> parts;       ///< empty: the whole skin
  std::vector<int> except;       ///< surfaces
  std::vector<char> takes_face;  ///< by number of the face: one of its triangles belongs to the surface
  std::vector<char> whole;       ///< all do, and the box leaves out no more than a margin
};

class CutAreas {
public:
  explicit CutAreas(const MachineMesh& machine) : machine_(machine), surfaces_(machine.surfaces.size()) {
    for (const TetMesh& body : machine.bodies) faces_.push_back(faces_of(body));
    for (std::size_t s = 0; s < surfaces_.size(); ++s) read(s);
    for (std::size_t round = 0; round < surfaces_.size(); ++round) {  // exceptions of exceptions
      bool changed = false;
      for (CutSurface& surface : surfaces_) {
        const bool cut = surface.cut || std::any_of(surface.except.begin(), surface.except.end(),
                                                    [&](int other) { return surfaces_[other].cut; });
        changed = changed || cut != surface.cut;
        surface.cut = cut;
      }
      if (!changed) break;
    }
    std::vector<std::vector<char>> whole;
    for (std::size_t s = 0; s < surfaces_.size(); ++s) whole.push_back(whole_faces(s));
    for (std::size_t s = 0; s < surfaces_.size(); ++s) surfaces_[s].whole = std::move(whole[s]);
  }

  double of(int s) const {
    if (!surfaces_[s].cut) return std::numeric_limits<double>::quiet_NaN();
    const std::vector<double> areas = by_face(s);
    return std::accumulate(areas.begin(), areas.end(), 0.0);
  }

private:
  /// Area of the surface on each face.
  std::vector<double> by_face(int s) const {
    const int body = machine_.machine.body_index(machine_.machine.surfaces[s].body);
    const TetMesh& mesh = machine_.bodies[body];
    std::vector<double> sums(surfaces_[s].takes_face.size(), 0.0);
    for (int f = 0; f < mesh.face_count(); ++f) {
      const int number = faces_[body][f];
      if (surfaces_[s].takes_face[number] == 0) continue;
      const Plane plane(mesh, f);
      Polygon triangle;
      for (int i = 0; i < 3; ++i) triangle.push_back(plane.in_plane(mesh.points.col(mesh.faces(i, f))));
      Pieces2d inside, outside;
      split(s, f, plane, {std::move(triangle)}, inside, outside);
      for (const Polygon& piece : inside) sums[number] += area(piece);
    }
    return sums;
  }

  /// Boxes are often drawn around a face, or a little within it: the face is what is meant.
  std::vector<char> whole_faces(int s) const {
    const CutSurface& surface = surfaces_[s];
    std::vector<char> whole(surface.takes_face.size(), 0);
    if (!surface.cut) return whole;
    const int body = machine_.machine.body_index(machine_.machine.surfaces[s].body);
    const TetMesh& mesh = machine_.bodies[body];
    std::vector<double> all(whole.size(), 0.0), taken(whole.size(), 0.0);
    for (int f = 0; f < mesh.face_count(); ++f) all[faces_[body][f]] += mesh.face_area(f);
    for (const int f : machine_.surfaces[s]) taken[faces_[body][f]] += mesh.face_area(f);
    const std::vector<double> in_box = by_face(s);
    for (std::size_t n = 0; n < whole.size(); ++n)
      whole[n] = taken[n] > (1.0 - 1e-9) * all[n] && in_box[n] > whole_face * all[n];
    return whole;
  }

  void read(std::size_t s) {
    const SurfaceSpec& spec = machine_.machine.surfaces[s];
    const int body = machine_.machine.body_index(spec.body);
    const TetMesh& mesh = machine_.bodies[body];
    CutSurface& surface = surfaces_[s];
    for (const Rule& rule : spec.any_of) {
      Rule without = rule;
      without.box_min.reset();
      without.box_max.reset();
      Part part{std::vector<char>(mesh.face_count(), 0), &rule};
      for (const int face : select_faces(mesh, without)) part.takes[face] = 1;
      surface.cut = surface.cut || rule.box_min.has_value();
      surface.parts.push_back(std::move(part));
    }
    for (const std::string& id : spec.except) surface.except.push_back(machine_.machine.surface_index(id));
    const std::vector<int>& numbers = faces_[body];
    surface.takes_face.assign(numbers.empty() ? 0 : *std::max_element(numbers.begin(), numbers.end()) + 1, 0);
    for (const int face : machine_.surfaces[s]) surface.takes_face[numbers[face]] = 1;
  }

  /// Splits pieces of a triangle into those inside of the surface and those outside.
  void split(int s, int face, const Plane& plane, Pieces2d pieces, Pieces2d& inside, Pieces2d& outside) const {
    const CutSurface& surface = surfaces_[s];
    const int body = machine_.machine.body_index(machine_.machine.surfaces[s].body);
    if (surface.takes_face[faces_[body][face]] == 0) {
      outside.insert(outside.end(), pieces.begin(), pieces.end());
      return;
    }
    if (!surface.whole.empty() && surface.whole[faces_[body][face]] != 0) {
      inside.insert(inside.end(), pieces.begin(), pieces.end());
      return;
    }
    Pieces2d taken;
    if (surface.parts.empty()) std::swap(taken, pieces);
    for (const Part& part : surface.parts) {
      if (part.takes[face] == 0) continue;
      Pieces2d rest;
      for (Polygon& piece : pieces) cut_at_box(*part.rule, plane, std::move(piece), taken, rest);
      std::swap(pieces, rest);
    }
    outside.insert(outside.end(), pieces.begin(), pieces.end());
    for (const int other : surface.except) {
      Pieces2d excepted, left;
      split(other, face, plane, std::move(taken), excepted, left);
      outside.insert(outside.end(), excepted.begin(), excepted.end());
      taken = std::move(left);
    }
    inside.insert(inside.end(), taken.begin(), taken.end());
  }

  static void cut_at_box(const Rule& rule, const Plane& plane, Polygon piece, Pieces2d& inside, Pieces2d& outside) {
    Polygon spare;
    for (int k = 0; rule.box_min && k < 3; ++k) {
      for (const double sign : {1.0, -1.0}) {
        const double limit = (sign > 0.0 ? *rule.box_min : *rule.box_max)[k] - sign * box_slack;
        Polygon beyond = piece;
        cut(beyond, plane.line(k, limit, -sign), spare);
        cut(piece, plane.line(k, limit, sign), spare);
        if (beyond.size() > 2 && area(beyond) > 0.0) outside.push_back(std::move(beyond));
        if (piece.size() < 3) return;
      }
    }
    inside.push_back(std::move(piece));
  }

  const MachineMesh& machine_;
  std::vector<std::vector<int>> faces_;  ///< a list for each body
  std::vector<CutSurface> surfaces_;
};

}  // namespace

std::vector<double> cut_areas(const MachineMesh& machine) {
  const CutAreas areas(machine);
  std::vector<double> result;
  for (std::size_t s = 0; s < machine.surfaces.size(); ++s) result.push_back(areas.of(s));
  return result;
}

void warn_of_box_areas(const MachineMesh& machine, const std::vector<double>& cut) {
  for (std::size_t s = 0; s < cut.size(); ++s) {
    const double selected = machine.surface_area(s);
    if (std::isnan(cut[s]) || std::abs(selected - cut[s]) <= largest_area_error * cut[s]) continue;
    const SurfaceSpec& spec = machine.machine.surfaces[s];
    const BodySpec& body = machine.machine.bodies[machine.machine.body_index(spec.body)];
    core::warn(fmt::format(
        "{} '{}': its {} triangles cover {:.4g} cm2; the box of its rule cuts {:.4g} cm2 out of their faces, "
        "from which they may differ by {:.0f} % without this warning. A box takes whole triangles, by their centres, "
        "so the area depends on the mesh. Let the CAD give the surface a face of its own between sharp edges, or use "
        "a smaller element_size_mm of body '{}' ({:.4g} at size factor 1)",
        spec.place.empty() ? machine.machine.path.string() : spec.place, spec.id, machine.surfaces[s].size(),
        1e4 * selected, 1e4 * cut[s], 100.0 * largest_area_error, body.id, 1e3 * body.element_size));
  }
}

}  // namespace thermotwin::mesh
