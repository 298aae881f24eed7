// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/place.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/units.h"

namespace thermotwin::diagnosis {

using Eigen::Vector3d;

namespace {

constexpr double outer_third = 1.0 / 3.0;  ///< of a body's half width: beyond it a place is at a side
constexpr double near_sensor_m = 0.5, near_surface_m = 0.5;
constexpr double at_surface_m = 0.005, on_rule_m = 0.005;

/// Box about the patches of a body's skin, else about its sensors; empty where it has neither.
Eigen::AlignedBox3d box_of(const std::string& body, const reduction::ReducedModel& model) {
  Eigen::AlignedBox3d box;
  for (const reduction::Patch& patch : model.patches.items)
    if (patch.surface.body == body) box.extend(patch.centre);
  for (const mesh::SensorSpec& sensor : model.machine.sensors)
    if (sensor.body == body) box.extend(sensor.point);
  return box;
}

/// "left", "right" along x, "front", "rear" along y (the operator stands on the side of negative y), "bottom", "top".
std::string side_of(const Eigen::AlignedBox3d& box, const Vector3d& at) {
  static constexpr const char* names[3][2] = {{"left", "right"}, {"front", "rear"}, {"bottom", "top"}};
  std::string side;
  for (const int axis : {2, 0, 1}) {
    const double half = 0.5 * (box.max()[axis] - box.min()[axis]);
    if (!(half > 0.0)) continue;
    const double from_middle = (at[axis] - box.center()[axis]) / half;
    if (std::abs(from_middle) > outer_third)
      side += (side.empty() ? "" : " ") + std::string(names[axis][from_middle > 0]);
  }
  return side.empty() ? "middle" : side;
}

std::string nearest_sensor(const std::string& body, const Vector3d& at, const mesh::Machine& machine) {
  std::string nearest;
  double least = near_sensor_m;
  for (const bool same_body : {true, false}) {
    for (const mesh::SensorSpec& sensor : machine.sensors) {
      if (sensor.body.empty() || (sensor.body == body) != same_body) continue;
      const double distance = (sensor.point - at).norm();
      if (distance < least) least = distance, nearest = sensor.id;
    }
    if (!nearest.empty()) break;
  }
  return nearest;
}

/// How far a point is from where all of a rule's conditions hold, at least; infinite for a group of a mesh.
double distance_to(const mesh::Rule& rule, const Vector3d& at) {
  if (!rule.group.empty()) return std::numeric_limits<double>::infinity();
  double distance = 0.0;
  if (rule.box_min && rule.box_max) distance = Eigen::AlignedBox3d(*rule.box_min, *rule.box_max).exteriorDistance(at);
  if (rule.plane_point && rule.plane_normal)
    distance = std::max(distance, std::abs(rule.plane_normal->normalized().dot(at - *rule.plane_point)));
  if (rule.cylinder_point && rule.cylinder_axis) {
    const Vector3d from_axis = rule.cylinder_axis->normalized().cross(at - *rule.cylinder_point);
    distance = std::max(distance, std::abs(from_axis.norm() - rule.cylinder_radius));
  }
  return distance;
}

/// Of a surface to a point. A rule without a box reaches as far as the body: the patches that lie on it say where.
double distance_to(const mesh::SurfaceSpec& surface, const Vector3d& at, const reduction::ReducedModel& model) {
  double least = std::numeric_limits<double>::infinity();
  for (const mesh::Rule& rule : surface.any_of) {
    const bool bounded = rule.box_min && rule.box_max;
    if (bounded) least = std::min(least, distance_to(rule, at));
    if (bounded || (!rule.plane_point && !rule.cylinder_point)) continue;
    for (const reduction::Patch& patch : model.patches.items) {
      if (patch.surface.body == surface.body && distance_to(rule, patch.centre) < on_rule_m)
        least = std::min(least, (patch.centre - at).norm());
    }
  }
  return least;
}

}  // namespace

PlaceOfCause place_of(const std::string& body, const Vector3d& at, const reduction::ReducedModel& model) {
  PlaceOfCause place;
  place.on_skin = at;
  double least = std::numeric_limits<double>::infinity();
  for (const reduction::Patch& patch : model.patches.items) {
    const double distance = (patch.centre - at).norm();
    if (patch.surface.body == body && distance < least) least = distance, place.on_skin = patch.centre;
  }
  place.surface_m = near_surface_m;
  for (const mesh::SurfaceSpec& surface : model.machine.surfaces) {
    if (surface.body != body) continue;
    const double distance = distance_to(surface, place.on_skin, model);
    if (distance < place.surface_m) place.surface = surface.id, place.surface_m = distance;
  }
  return place;
}

std::string place_in_words(const std::string& body, const Vector3d& at, const reduction::ReducedModel& model) {
  const mesh::Machine& machine = model.machine;
  const Eigen::AlignedBox3d box = box_of(body, model);
  std::string words = (box.isEmpty() ? std::string() : "the " + side_of(box, at) + " of ") + body;
  if (!machine.tcp.table_body.empty()) {
    const double height = (at[2] - machine.tcp.table_point[2]) / core::units::mm;
    words += fmt::format(", {:.0f} mm {} the table", std::abs(height), height < 0 ? "below" : "above");
  }
  if (const PlaceOfCause place = place_of(body, at, model); !place.surface.empty()) {
    words += place.surface_m < at_surface_m
                 ? ", on " + place.surface
                 : fmt::format(", {:.0f} mm from {}", place.surface_m / core::units::mm, place.surface);
  }
  const std::string sensor = nearest_sensor(body, at, machine);
  return sensor.empty() ? words : words + ", near sensor " + sensor;
}

}  // namespace thermotwin::diagnosis
