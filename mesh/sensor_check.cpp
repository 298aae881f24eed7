// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/sensor_check.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
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
