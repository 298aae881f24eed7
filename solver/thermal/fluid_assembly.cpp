// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/fluid_assembly.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solver/thermal/surfaces.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

/// Place along a path, from 0 to 1, of its point that is nearest to p.
double place_along(const std::vector<Vector3d>& path, const Vector3d& p) {
  double length = 0.0, best = std::numeric_limits<double>::infinity(), at = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Vector3d step = path[i] - path[i - 1];
    const double norm = step.norm();
    if (norm <= 0.0) continue;
    const double s = std::clamp((p - path[i - 1]).dot(step) / (norm * norm), 0.0, 1.0);
    if (const double off = (path[i - 1] + s * step - p).norm(); off < best) {
      best = off;
      at = length + s * norm;
    }
    length += norm;
  }
  return at / length;
}

}  // namespace

FluidNodes::FluidNodes(const mesh::Machine& machine, Index first) : machine_(machine), first_(first) {
  int next = first_;
  for (const mesh::CoolantSpec& coolant : machine.coolants) {
    networks_.push_back(mesh::flow_network(coolant, machine.path.string() + " coolant " + coolant.id));
    std::vector<int> nodes;
    for (const mesh::CoolantSegment& segment : coolant.segments) {
      nodes.push_back(next);
      next += 2 * segment.cells;
    }
    first_node_.push_back(std::move(nodes));
  }
  first_volume_ = next;
  count_ = next - first_ + std::ssize(machine.volumes);
}

int FluidNodes::node(int coolant, int segment, int cell, int end) const {
  return first_node_[coolant][segment] + 2 * cell + end;
}

std::vector<double> FluidNodes::capacities() const {
  std::vector<double> values;
  for (const mesh::CoolantSpec& coolant : machine_.coolants) {
    for (const mesh::CoolantSegment& segment : coolant.segments) {
      values.insert(values.end(), 2 * segment.cells,
                    0.5 * coolant.density * coolant.specific_heat * segment.volume / segment.cells);
    }
  }
  for (const mesh::VolumeSpec& volume : machine_.volumes) values.push_back(volume.capacity.value);
  return values;
}

void FluidNodes::add_flow(int coolant, Triplets& triplets) const {
  const std::size_t c = coolant;
  const mesh::CoolantSpec& spec = machine_.coolants[c];
  for (int s = 0; s < std::ssize(spec.segments); ++s) {
    const std::size_t i = s;
    const double flow = spec.specific_heat * networks_[c].share[i];
    for (int cell = 0; cell < spec.segments[i].cells; ++cell) {
      const int in = node(coolant, s, cell, 0), out = node(coolant, s, cell, 1);
      triplets.emplace_back(in, in, 0.5 * flow);
      triplets.emplace_back(in, out, 0.5 * flow);
      triplets.emplace_back(out, in, -0.5 * flow);
      triplets.emplace_back(out, out, 0.5 * flow);
      if (cell > 0) {
        triplets.emplace_back(in, node(coolant, s, cell - 1, 1), -flow);
        continue;
      }
      for (const auto& [before, share] : networks_[c].inflow[i]) {
        if (before >= 0)
          triplets.emplace_back(in, node(coolant, before, spec.segments[before].cells - 1, 1), -flow * share);
      }
    }
  }
}

void FluidNodes::add_wall(const mesh::MachineMesh& mesh, int coolant, int segment, Triplets& triplets) const {
  const mesh::CoolantSegment& spec = machine_.coolants[coolant].segments[segment];
  const std::size_t surface = machine_.surface_index(spec.surface);
  const std::size_t body = machine_.body_index(machine_.surfaces[surface].body);
  const mesh::TetMesh& tets = mesh.bodies[body];
  const int first = mesh.first_node[body];
  const int fluids = 2 * spec.cells, fluid = node(coolant, segment, 0, 0);
  // What a wall point sees of the fluid: one cell's two functions, or all of them where there is no path.
  Eigen::MatrixXd seen = Eigen::MatrixXd::Zero(fluids, fluids);
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(fluids);
  for (int cell = 0; cell < spec.cells; ++cell) {
    seen.block<2, 2>(2 * cell, 2 * cell) << 2.0, 1.0, 1.0, 2.0;
    mean.segment<2>(2 * cell).setConstant(0.5 / spec.cells);
  }
  seen /= 6.0 * spec.cells;
  Eigen::MatrixXd of_fluid = Eigen::MatrixXd::Zero(fluids, fluids);
  for (const int face : mesh.surfaces[surface]) {
    const mesh::FaceNodes nodes = mesh::face_nodes(tets, face).array() + first;
    const double area = tets.face_area(face);
    Eigen::MatrixXd to_nodes = Eigen::MatrixXd::Zero(nodes.size(), fluids);
    if (spec.path.empty()) {
      to_nodes = area * face_load(tets.order()) * mean.transpose();
      of_fluid += area * seen;
    } else {
      for (const mesh::FacePoint& point : mesh::face_rule(5)) {
        Vector3d p = Vector3d::Zero();
        for (int k = 0; k < 3; ++k) p += point.at[k] * tets.points.col(tets.faces(k, face));
        const double along = place_along(spec.path, p) * spec.cells;
        const int cell = std::clamp(static_cast<int>(along), 0, spec.cells - 1);
        const Eigen::Vector2d phi(1.0 - (along - cell), along - cell);
        to_nodes.middleCols<2>(2 * cell) +=
            area * point.share * mesh::face_shape(tets.order(), point.at) * phi.transpose();
        of_fluid.block<2, 2>(2 * cell, 2 * cell) += area * point.share * phi * phi.transpose();
      }
    }
    const Eigen::MatrixXd& mass = face_mass(tets.order());
    for (Index i = 0; i < nodes.size(); ++i) {
      for (Index j = 0; j < nodes.size(); ++j) triplets.emplace_back(nodes[i], nodes[j], area * mass(i, j));
      for (int a = 0; a < fluids; ++a) {
        if (to_nodes(i, a) == 0.0) continue;
        triplets.emplace_back(nodes[i], fluid + a, -to_nodes(i, a));
        triplets.emplace_back(fluid + a, nodes[i], -to_nodes(i, a));
      }
    }
  }
  for (int a = 0; a < fluids; ++a) {
    for (int b = 0; b < fluids; ++b)
      if (of_fluid(a, b) != 0.0) triplets.emplace_back(fluid + a, fluid + b, of_fluid(a, b));
  }
}

SparseColumn FluidNodes::inlet(int coolant) const {
  const std::size_t c = coolant;
  SparseColumn column;
  for (std::size_t s = 0; s < networks_[c].inflow.size(); ++s) {
    for (const auto& [before, share] : networks_[c].inflow[s]) {
      if (before < 0)
        column.emplace_back(node(coolant, s, 0, 0), machine_.coolants[c].specific_heat * networks_[c].share[s] * share);
    }
  }
  return column;
}

SparseColumn FluidNodes::outflow(int coolant) const {
  const std::size_t c = coolant;
  SparseColumn column;
  for (const auto& [segment, share] : networks_[c].to_return)
    column.emplace_back(node(coolant, segment, machine_.coolants[c].segments[segment].cells - 1, 1), share);
  return column;
}

}  // namespace thermotwin::solver
