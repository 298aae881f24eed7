// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/sensor_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "core/error.h"
#include "core/progress.h"
#include "mesh/body/tet_locator.h"
#include "mesh/body/triangle_tree.h"

namespace thermotwin::mesh {
namespace {

constexpr double far_from_body = 0.1;  // of its diagonal

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
