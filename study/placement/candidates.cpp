// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/placement/candidates.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "core/error.h"
#include "core/text.h"

namespace thermotwin::study {
namespace {

using Eigen::Index;

bool contains(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

void require_known(const mesh::Machine& machine, const PlaceRules& rules) {
  std::vector<std::string> bodies, all;
  for (const mesh::BodySpec& body : machine.bodies) bodies.push_back(body.id);
  all = bodies;
  for (const mesh::SurfaceSpec& surface : machine.surfaces) all.push_back(surface.id);
  const auto require = [](const std::vector<std::string>& ids, const std::vector<std::string>& known,
                          const char* what) {
    for (const std::string& id : ids)
      if (!contains(known, id))
        throw core::InputError(what, "'" + id + "'",
                               core::join(known) + " (nearest: " + core::nearest(id, known) + ")");
  };
  require(rules.bodies, bodies, "body of sensors");
  require(rules.without, all, "body or surface without sensors");
}

/// Whether all of a surface of this body turns: in a film of a rotating disc, `fraction` is the share that does.
bool has_disc(const mesh::Machine& machine, const std::string& body) {
  return std::any_of(machine.films.begin(), machine.films.end(), [&](const mesh::FilmSpec& film) {
    return film.kind == mesh::FilmKind::rotating_disc && film.fraction >= 1.0 &&
           std::any_of(film.surfaces.begin(), film.surfaces.end(), [&](const std::string& id) {
             const int surface = machine.surface_index(id);
             return surface >= 0 && machine.surfaces[surface].body == body;
           });
  });
}

/// Whether the body, or one that carries it, turns with a spindle or an endless axis.
bool rotates(const mesh::Machine& machine, int body) {
  for (int at = body; at >= 0;) {
    const mesh::BodySpec& spec = machine.bodies[at];
    if (has_disc(machine, spec.id)) return true;
    if (!spec.axis.empty() && machine.axes[machine.axis_index(spec.axis)].endless) return true;
    at = spec.parent.empty() ? -1 : machine.body_index(spec.parent);
  }
  return false;
}

/// Surfaces whose triangles take no sensor.
std::vector<int> closed_surfaces(const mesh::Machine& machine, const PlaceRules& rules) {
  std::set<std::string> ids(rules.without.begin(), rules.without.end());
  if (!rules.on_contacts) {
    for (const mesh::JointSpec& joint : machine.joints) ids.insert({joint.slave, joint.master});
  }
  std::vector<int> closed;
  for (const std::string& id : ids)
    if (const int surface = machine.surface_index(id); surface >= 0) closed.push_back(surface);
  return closed;
}

/// Cells of the spacing's size with the nodes in them.
class Thinned {
public:
  explicit Thinned(double spacing) : spacing_(std::max(spacing, 1e-9)) {}
  bool take(const Eigen::Vector3d& point) {
    const Eigen::Vector3i cell = (point / spacing_).array().floor().cast<int>();
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int z = -1; z <= 1; ++z) {
          const auto found = cells_.find({cell.x() + x, cell.y() + y, cell.z() + z});
          if (found == cells_.end()) continue;
          for (const Eigen::Vector3d& other : found->second)
            if ((other - point).norm() < spacing_) return false;
        }
      }
    }
    cells_[{cell.x(), cell.y(), cell.z()}].push_back(point);
    return true;
  }

private:
  double spacing_;
  std::map<std::tuple<int, int, int>, std::vector<Eigen::Vector3d>> cells_;
};

}  // namespace

std::vector<Place> sensor_places(const mesh::MachineMesh& mesh, const PlaceRules& rules) {
  const mesh::Machine& machine = mesh.machine;
  require_known(machine, rules);
  const std::vector<int> closed = closed_surfaces(machine, rules);
  std::vector<Place> places;
  for (int b = 0; b < std::ssize(machine.bodies); ++b) {
    const mesh::BodySpec& body = machine.bodies[b];
    if (rules.bodies.empty() ? !body.elastic : !contains(rules.bodies, body.id)) continue;
    if (contains(rules.without, body.id) || (!rules.on_rotating && rotates(machine, b))) continue;
    const mesh::TetMesh& tets = mesh.bodies[b];
    std::set<int> covered, skin;
    for (const int surface : closed) {
      if (machine.surfaces[surface].body != body.id) continue;
      for (const int face : mesh.surfaces[surface])
        for (int k = 0; k < 3; ++k) covered.insert(tets.faces(k, face));
    }
    for (Index face = 0; face < tets.face_count(); ++face)
      for (int k = 0; k < 3; ++k) skin.insert(tets.faces(k, face));
    Thinned thinned(rules.spacing);
    for (const int node : skin) {
      const Eigen::Vector3d point = tets.points.col(node);
      if (!covered.contains(node) && thinned.take(point)) places.push_back({b, mesh.first_node[b] + node, point});
    }
  }
  if (places.empty())
    throw core::InputError("places of sensors", "none is left by the rules", "rules that leave a part of the skin");
  return places;
}

}  // namespace thermotwin::study
