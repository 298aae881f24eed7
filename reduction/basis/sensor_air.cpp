// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis/sensor_air.h"

#include <limits>

#include "mesh/body/triangle_tree.h"
#include "solver/thermal/fluid_assembly.h"

namespace thermotwin::reduction {

namespace {

/// Distance of a point to a surface, m.
double distance_to(const mesh::MachineMesh& mesh, int surface, const Eigen::Vector3d& point) {
  const mesh::TetMesh& body = mesh.body_of_surface(surface);
  double nearest = std::numeric_limits<double>::infinity();
  for (const int face : mesh.surfaces[surface]) {
    const Eigen::Vector3i corner = body.faces.col(face);
    const Eigen::Vector3d on = mesh::nearest_on_triangle(point, body.points.col(corner[0]), body.points.col(corner[1]),
                                                         body.points.col(corner[2]));
    nearest = std::min(nearest, (on - point).norm());
  }
  return nearest;
}

}  // namespace

SensorAir sensor_air(const solver::FullModel& full, const Eigen::MatrixXd& basis) {
  const mesh::Machine& machine = full.mesh.machine;
  SensorAir air;
  air.film.setConstant(std::ssize(machine.sensors), -1);
  for (std::size_t s = 0; s < machine.sensors.size(); ++s) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t f = 0; f < machine.films.size(); ++f) {
      for (const std::string& id : machine.films[f].surfaces) {
        const int surface = machine.surface_index(id);
        if (machine.surfaces[surface].body != machine.sensors[s].body) continue;
        const double distance = distance_to(full.mesh, surface, machine.sensors[s].point);
        if (distance < nearest) nearest = distance, air.film[s] = f;
      }
    }
  }
  const solver::FluidNodes fluids(machine, full.thermal.nodes);
  air.volumes.resize(std::ssize(machine.volumes), basis.cols());
  for (Eigen::Index v = 0; v < air.volumes.rows(); ++v) air.volumes.row(v) = basis.row(fluids.volume(v));
  return air;
}

}  // namespace thermotwin::reduction
