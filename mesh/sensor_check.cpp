// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/sensor_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "core/error.h"
#include "mesh/body/tet_locator.h"
#include "mesh/body/triangle_tree.h"

namespace thermotwin::mesh {
namespace {

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

}  // namespace thermotwin::mesh
