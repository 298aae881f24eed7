// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/selection.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "core/error.h"
#include "core/progress.h"
#include "core/text.h"
#include "core/units.h"

namespace thermotwin::mesh {

namespace {

using Eigen::Vector3d;

constexpr double least_plane_cosine = 0.866;  // 30 deg
constexpr double in_plane = 0.1;              // of the tolerance: a face that lies in the plane

/// One condition of a rule: how far each triangle is from fulfilling it (<= 0: it does).
struct Condition {
  std::string name;
  std::function<double(int)> miss;
  std::function<std::string(double)> describe;  ///< of the smallest miss
};

std::string same_in_lower_case(const TetMesh& mesh, const std::string& name) {
  if (mesh.groups.count(name) > 0) return name;
  for (const auto& [known, faces] : mesh.groups)
    if (core::lower(known) == core::lower(name)) return known;  // Abaqus writes names in capitals
  return {};
}

Condition plane_condition(const TetMesh& mesh, const Rule& rule) {
  return {"plane",
          [&](int face) {
            // A narrow face at right angles to the plane may lie within the tolerance, but looks along it.
            if (std::abs(rule.plane_normal->dot(mesh.face_normal(face))) < least_plane_cosine)
              return std::numeric_limits<double>::infinity();
            double corners = 0.0;
            for (int i = 0; i < 3; ++i) {
              corners = std::max(
                  corners, std::abs(rule.plane_normal->dot(mesh.points.col(mesh.faces(i, face)) - *rule.plane_point)));
            }
            return corners - rule.tolerance;
          },
          [&](double miss) {
            if (std::isinf(miss)) return std::string("no triangle looks along its normal within 30 deg");
            return fmt::format(
                "the nearest triangle that looks along its normal is {:.4g} mm from the plane (tolerance_mm = {:.4g})",
                1e3 * (miss + rule.tolerance), 1e3 * rule.tolerance);
          }};
}

Condition cylinder_condition(const TetMesh& mesh, const Rule& rule) {
  const auto radial = [&](const Vector3d& point) -> Vector3d {
    const Vector3d from = point - *rule.cylinder_point;
    return from - rule.cylinder_axis->dot(from) * *rule.cylinder_axis;
  };
  return {"cylinder",
          [&mesh, &rule, radial](int face) {
            const Vector3d centre = radial(mesh.face_centre(face));
            double corners = 0.0;
            for (int i = 0; i < 3; ++i) {
              corners = std::max(corners,
                                 std::abs(radial(mesh.points.col(mesh.faces(i, face))).norm() - rule.cylinder_radius));
            }
            const double off = std::min(corners, std::abs(centre.norm() - rule.cylinder_radius));
            // The end cap of a coarse cylinder has its corners on the rim too, but looks along the axis.
            const bool looks_out = std::abs(mesh.face_normal(face).dot(centre)) > 0.7 * centre.norm();
            return looks_out ? off - rule.tolerance : std::max(off - rule.tolerance, rule.cylinder_radius);
          },
          [&rule](double miss) {
            return fmt::format("the nearest triangle is {:.4g} mm from the cylinder (tolerance_mm = {:.4g})",
                               1e3 * (miss + rule.tolerance), 1e3 * rule.tolerance);
          }};
}

Condition box_condition(const TetMesh& mesh, const Rule& rule) {
  return {
      "box",
      [&](int face) {
        const Vector3d centre = mesh.face_centre(face);
        return std::max((*rule.box_min - centre).maxCoeff(), (centre - *rule.box_max).maxCoeff());
      },
      [](double miss) { return fmt::format("the nearest triangle centre is {:.4g} mm outside the box", 1e3 * miss); }};
}

Condition normal_condition(const TetMesh& mesh, const Rule& rule) {
  return {"normal",
          [&](int face) {
            return std::acos(std::clamp(rule.normal->dot(mesh.face_normal(face)), -1.0, 1.0)) - rule.max_angle;
          },
          [&](double miss) {
            return fmt::format("the nearest outward normal is {:.4g} deg off (max_angle_deg = {:.4g})",
                               (miss + rule.max_angle) / core::units::deg, rule.max_angle / core::units::deg);
          }};
}

Condition group_condition(const TetMesh& mesh, const Rule& rule) {
  const std::string name = same_in_lower_case(mesh, rule.group);
  if (name.empty()) {
    std::vector<std::string> known;
    for (const auto& group : mesh.groups) known.push_back(group.first);
    throw core::InputError(
        rule.place, "group '" + rule.group + "' is not in the mesh",
        known.empty() ? "no group: the CAD file has none, use a geometric rule"
                      : "one of: " + core::join(known) + " (nearest: " + core::nearest(rule.group, known) + ")");
  }
  std::vector<char> in(mesh.face_count(), 0);
  for (const int face : mesh.groups.at(name)) in[face] = 1;
  return {"group", [in](int face) { return in[face] != 0 ? 0.0 : 1.0; },
          [](double) { return std::string("the group has no boundary triangle"); }};
}

/// Of faces near a plane that look both ways, those of the nearer side, where that side lies in the plane and the other
/// does not: a rule means one side of a sheet that is thinner than its tolerance.
void keep_the_side_in_the_plane(const TetMesh& mesh, const Rule& rule, std::vector<int>& picked) {
  constexpr double none = std::numeric_limits<double>::infinity();
  double farthest[2] = {-none, -none}, nearest[2] = {none, none};  // m, of either side
  const auto side = [&](int face) { return rule.plane_normal->dot(mesh.face_normal(face)) > 0.0 ? 1 : 0; };
  for (const int face : picked) {
    for (int i = 0; i < 3; ++i) {
      const double off = std::abs(rule.plane_normal->dot(mesh.points.col(mesh.faces(i, face)) - *rule.plane_point));
      farthest[side(face)] = std::max(farthest[side(face)], off);
      nearest[side(face)] = std::min(nearest[side(face)], off);
    }
  }
  for (const int in : {0, 1}) {
    if (std::isinf(farthest[in]) || farthest[in] > in_plane * rule.tolerance) continue;
    if (std::isinf(nearest[1 - in]) || nearest[1 - in] <= in_plane * rule.tolerance) continue;
    std::erase_if(picked, [&](int face) { return side(face) != in; });
    core::warn(
        fmt::format("{}: faces that look the other way lie {:.3g} mm behind the plane, within tolerance_mm = {:.3g}; "
                    "they are left out as the other side of a sheet",
                    rule.place, 1e3 * nearest[1 - in], 1e3 * rule.tolerance));
    return;
  }
}

std::string explain(const std::vector<Condition>& conditions, int faces) {
  std::vector<std::string> words;
  for (const Condition& condition : conditions) {
    double least = std::numeric_limits<double>::infinity();
    int count = 0;
    for (int f = 0; f < faces; ++f) {
      const double miss = condition.miss(f);
      count += miss <= 0.0;
      least = std::min(least, miss);
    }
    words.push_back(condition.name + ": " +
                    (count > 0 ? fmt::format("holds for {} triangles", count) : condition.describe(least)));
  }
  std::string text =
      "no triangle (of " + std::to_string(faces) + " of the body) fulfils the rule: " + core::join(words, "; ");
  if (conditions.size() > 1) text += "; no triangle fulfils all conditions together";
  return text;
}

}  // namespace

std::vector<int> select_faces(const TetMesh& mesh, const Rule& rule) {
  std::vector<Condition> conditions;
  if (!rule.group.empty()) conditions.push_back(group_condition(mesh, rule));
  if (rule.plane_point && rule.plane_normal) conditions.push_back(plane_condition(mesh, rule));
  if (rule.cylinder_point && rule.cylinder_axis) conditions.push_back(cylinder_condition(mesh, rule));
  if (rule.box_min && rule.box_max) conditions.push_back(box_condition(mesh, rule));
  if (rule.normal) conditions.push_back(normal_condition(mesh, rule));
  const int faces = mesh.face_count();
  std::vector<int> picked;
  for (int f = 0; f < faces; ++f) {
    if (std::all_of(conditions.begin(), conditions.end(), [&](const Condition& c) { return c.miss(f) <= 0.0; }))
      picked.push_back(f);
  }
  if (rule.plane_point && rule.plane_normal) keep_the_side_in_the_plane(mesh, rule, picked);
  if (picked.empty())
    throw core::InputError(rule.place, explain(conditions, faces), "a rule that picks one or more triangles");
  return picked;
}

std::vector<std::vector<int>> resolve_surfaces(const Machine& machine, const std::vector<TetMesh>& bodies) {
  std::vector<std::vector<int>> done(machine.surfaces.size());
  // Exceptions first; reading has made sure that they do not go round in a circle.
  const std::function<void(std::size_t)> resolve = [&](std::size_t s) {
    if (!done[s].empty()) return;
    const SurfaceSpec& spec = machine.surfaces[s];
    const TetMesh& mesh = bodies[machine.body_index(spec.body)];
    std::vector<char> in(mesh.face_count(), spec.any_of.empty() ? 1 : 0);
    for (const Rule& rule : spec.any_of)
      for (const int face : select_faces(mesh, rule)) in[face] = 1;
    for (const std::string& id : spec.except) {
      const std::size_t other = machine.surface_index(id);
      resolve(other);
      for (const int face : done[other]) in[face] = 0;
    }
    for (std::size_t f = 0; f < in.size(); ++f)
      if (in[f]) done[s].push_back(f);
    if (done[s].empty()) {
      throw core::InputError(spec.place + " except", "nothing is left of surface '" + spec.id + "'",
                             "exceptions that leave one or more triangles");
    }
  };
  for (std::size_t s = 0; s < done.size(); ++s) resolve(s);
  return done;
}

}  // namespace thermotwin::mesh
