// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/sensor_check.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <limits>

#include "core/error.h"
#include "mesh/triangle_tree.h"

namespace thermotwin::mesh {
namespace {

bool is_inside(const TetMesh& body, const Eigen::Vector3d& p) {
  for (Eigen::Index e = 0; e < body.elements(); ++e) {
    const Eigen::Vector3d a = body.points.col(body.tets(0, e));
    Eigen::Matrix3d edges;
    for (int i = 0; i < 3; ++i) edges.col(i) = body.points.col(body.tets(i + 1, e)) - a;
    if ((p - a).cwiseAbs().maxCoeff() > edges.cwiseAbs().maxCoeff()) continue;
    const Eigen::Vector3d weights = edges.partialPivLu().solve(p - a);
    if (weights.minCoeff() >= 0.0 && weights.sum() <= 1.0) return true;
  }
  return false;
}

double distance_to_surface(const TetMesh& body, const Eigen::Vector3d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index f = 0; f < body.face_count(); ++f) {
    const Eigen::Vector3d q = nearest_on_triangle(p, body.points.col(body.faces(0, f)), body.points.col(body.faces(1, f)),
                                                  body.points.col(body.faces(2, f)));
    least = std::min(least, (q - p).norm());
  }
  return least;
}

}  // namespace

void check_sensors(const Machine& machine, const std::vector<TetMesh>& bodies) {
  for (const SensorSpec& sensor : machine.sensors) {
    if (sensor.body.empty()) continue;
    const auto index = static_cast<std::size_t>(machine.body_index(sensor.body));
    const double distance = distance_to_surface(bodies[index], sensor.point), allowed = machine.bodies[index].element_size;
    if (distance <= allowed || is_inside(bodies[index], sensor.point)) continue;
    throw core::InputError(
        fmt::format("{} sensor '{}' point_mm", machine.path.string(), sensor.id),
        fmt::format("[{:.6g}, {:.6g}, {:.6g}], {:.3g} mm outside body '{}'", 1e3 * sensor.point[0], 1e3 * sensor.point[1],
                    1e3 * sensor.point[2], 1e3 * distance, sensor.body),
        fmt::format("a point in or on the body, or at most its element_size_mm = {:.3g} beside it", 1e3 * allowed));
  }
}

}  // namespace thermotwin::mesh
