// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/sensor_check.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/progress.h"
#include "core/toml_place.h"
#include "mesh/body/tet_locator.h"
#include "mesh/body/triangle_tree.h"

namespace thermotwin::mesh {
namespace {

constexpr double far_from_body = 0.1;  // of its diagonal
constexpr double off_body = 0.3,
                 near_body = 0.05;  // of the machine's diagonal: far from the box of a body; close to it

constexpr double off_middle = 0.1;      // of the extent of the tool's surface
constexpr double least_flatness = 0.7;  // |sum of area vectors| over the area: half a cylinder has 0.64

using Box = Eigen::AlignedBox3d;

Box box_of(const TetMesh& body) {
  return {Eigen::Vector3d(body.points.rowwise().minCoeff()), Eigen::Vector3d(body.points.rowwise().maxCoeff())};
}

double distance_to_surface(const TetMesh& body, const Eigen::Vector3d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index f = 0; f < body.face_count(); ++f) {
    const Eigen::Vector3d q = nearest_on_triangle(p, body.points.col(body.faces(0, f)),
                                                  body.points.col(body.faces(1, f)), body.points.col(body.faces(2, f)));
    least = std::min(least, (q - p).norm());
  }
  return least;
}

}  // namespace

void check_sensors(const Machine& machine, const std::vector<TetMesh>& bodies) {
  for (const SensorSpec& sensor : machine.sensors) {
    if (sensor.body.empty()) continue;
    const std::size_t index = machine.body_index(sensor.body);
    const double distance = distance_to_surface(bodies[index], sensor.point),
                 allowed = machine.bodies[index].element_size;
    if (distance <= allowed || TetLocator(bodies[index]).find(sensor.point) >= 0) continue;
    throw core::InputError(
        fmt::format("{} sensor '{}' point_mm", machine.path.string(), sensor.id),
        fmt::format("[{:.6g}, {:.6g}, {:.6g}], {:.3g} mm outside body '{}'", 1e3 * sensor.point[0],
                    1e3 * sensor.point[1], 1e3 * sensor.point[2], 1e3 * distance, sensor.body),
        fmt::format("a point in or on the body, or at most its element_size_mm = {:.3g} beside it", 1e3 * allowed));
  }
}

void check_tcp(const Machine& machine, const std::vector<TetMesh>& bodies) {
  if (!machine.has_tcp()) return;
  Box all;
  for (const TetMesh& body : bodies) all.extend(box_of(body));
  const double diagonal = all.diagonal().norm();
  const auto check = [&](const char* key, const Eigen::Vector3d& point, const std::string& id) {
    const Box own = box_of(bodies[machine.body_index(id)]);
    const Eigen::Vector3d in_metres = 1e3 * point;
    const double off = own.exteriorDistance(point), off_in_metres = own.exteriorDistance(in_metres);
    const bool metres = off > near_body * diagonal && off_in_metres <= near_body * diagonal;
    if (!metres && off <= off_body * diagonal) return;
    const auto text = [](const Eigen::Vector3d& p) {
      return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", 1e3 * p[0], 1e3 * p[1], 1e3 * p[2]);
    };
    core::warn(fmt::format(
        "{}: {} is {:.4g} mm from the box of body '{}'{}; allowed without this warning: a point at most {:.3g} "
        "mm from the body, whose box at home is {} to {} mm",
        core::toml_place(machine.text, machine.path.string(), "tcp", key), text(point), 1e3 * off, id,
        metres ? ", and in it or close to it when the numbers are metres" : "", 1e3 * off_body * diagonal,
        text(own.min()), text(own.max())));
  };
  check("tool_point_mm", machine.tcp.tool_point, machine.tcp.tool_body);
  check("table_point_mm", machine.tcp.table_point, machine.tcp.table_body);
}

void check_tool_surface(const Machine& machine, const std::vector<TetMesh>& bodies,
                        const std::vector<std::vector<int>>& surfaces) {
  if (!machine.has_tcp()) return;
  const int index = machine.surface_index(machine.tcp.tool_surface);
  const TetMesh& body = bodies[machine.body_index(machine.surfaces[index].body)];
  Eigen::Vector3d middle = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
  double area = 0.0;
  for (const int face : surfaces[index]) {
    const double part = body.face_area(face);
    area += part;
    middle += part * body.face_centre(face);
    normal += part * body.face_normal(face);
  }
  middle /= area;
  // A round seat has no one direction that it faces; its middle lies on the axis of the spindle.
  if (normal.norm() < least_flatness * area) return;
  normal.normalize();
  const auto sideways = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    return p - middle - normal.dot(p - middle) * normal;
  };
  for (double& coordinate : middle) coordinate = 1e-6 * std::round(1e6 * coordinate) + 0.0;
  Box box;
  for (const int face : surfaces[index])
    for (int i = 0; i < 3; ++i) box.extend(sideways(body.points.col(body.faces(i, face))));
  const double off = sideways(machine.tcp.tool_point).norm(), extent = box.diagonal().norm();
  if (off <= off_middle * extent) return;
  core::warn(fmt::format(
      "{}: the tool point [{:.6g}, {:.6g}, {:.6g}] lies {:.4g} mm sideways of the middle of '{}', [{:.6g}, {:.6g}, "
      "{:.6g}]; allowed without this warning: {:.0f} % of the surface's extent, {:.4g} mm. The tool follows the mean "
      "motion of its surface, so growth over that distance is not in the TCP error; use the face around the spindle",
      core::toml_place(machine.text, machine.path.string(), "tcp", "tool_surface"), 1e3 * machine.tcp.tool_point[0],
      1e3 * machine.tcp.tool_point[1], 1e3 * machine.tcp.tool_point[2], 1e3 * off, machine.tcp.tool_surface,
      1e3 * middle[0], 1e3 * middle[1], 1e3 * middle[2], 100.0 * off_middle, 1e3 * off_middle * extent));
}

void check_screws(const Machine& machine, const std::vector<TetMesh>& bodies) {
  for (const ScrewSpec& screw : machine.screws) {
    const TetMesh& body = bodies[machine.body_index(screw.body)];
    Eigen::Vector3d sides = box_of(body).sizes();
    std::sort(sides.begin(), sides.end());
    const double thickness = sides[1];
    const auto check = [&](const char* key, const Eigen::Vector3d& point) {
      const double distance = TetLocator(body).find(point) >= 0 ? 0.0 : distance_to_surface(body, point);
      if (distance <= thickness) return;
      core::warn(fmt::format(
          "{} screw of axis '{}' {}: [{:.6g}, {:.6g}, {:.6g}] is {:.4g} mm from body '{}'; allowed without this "
          "warning: its thickness, {:.4g} mm. The screw's axis runs through nut and fixed bearing",
          machine.path.string(), screw.axis, key, 1e3 * point[0], 1e3 * point[1], 1e3 * point[2], 1e3 * distance,
          screw.body, 1e3 * thickness));
    };
    check("nut_mm", screw.nut);
    check("fixed_bearing_mm", screw.bearing);
    if (screw.far_bearing) check("far_bearing_mm", *screw.far_bearing);
  }
}

void check_scales(const Machine& machine, const std::vector<TetMesh>& bodies) {
  for (const ScaleSpec& scale : machine.scales) {
    const auto check = [&](const std::string& id, const char* key, const Eigen::Vector3d& point) {
      const TetMesh& body = bodies[machine.body_index(id)];
      const double diagonal = (body.points.rowwise().maxCoeff() - body.points.rowwise().minCoeff()).norm(),
                   distance = TetLocator(body).find(point) >= 0 ? 0.0 : distance_to_surface(body, point);
      if (distance <= far_from_body * diagonal) return;
      core::warn(fmt::format(
          "{} scale of axis '{}' {}: [{:.6g}, {:.6g}, {:.6g}] is {:.3g} mm from body '{}', to which it is fixed",
          machine.path.string(), scale.axis, key, 1e3 * point[0], 1e3 * point[1], 1e3 * point[2], 1e3 * distance, id));
    };
    check(scale.carrier, "start_mm", scale.start);
    check(scale.carrier, "end_mm", scale.end);
    check(scale.head_body, "head_mm", scale.head);
  }
}

}  // namespace thermotwin::mesh
