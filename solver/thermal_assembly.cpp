// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/progress.h"
#include "core/thread_pool.h"
#include "mesh/triangle_tree.h"
#include "solver/contact.h"
#include "solver/thermal_system.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::Vector3d;
using mesh::MachineMesh;
using mesh::TetMesh;
using Triplets = std::vector<Eigen::Triplet<double, int>>;

namespace {

SparseMatrix from_triplets(Index rows, Index columns, const Triplets& triplets) {
  SparseMatrix matrix(rows, columns);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  matrix.makeCompressed();
  return matrix;
}

/// Sums by row: place and weight of a load vector that is mostly zero.
using SparseColumn = std::vector<std::pair<int, double>>;

void put_column(Triplets& triplets, int column, const SparseColumn& values, double scale = 1.0) {
  for (const auto& [row, value] : values) triplets.emplace_back(row, column, scale * value);
}

/// Faces of a surface with their global node numbers and areas.
struct FaceSet {
  const TetMesh* body;
  const std::vector<int>* faces;
  int first_node;
  double area;

  Eigen::Vector3i nodes(int face) const { return body->faces.col(face).array() + first_node; }
};

FaceSet face_set(const MachineMesh& mesh, const std::string& id) {
  const int surface = mesh.machine.surface_index(id);
  const mesh::SurfaceSpec& spec = mesh.machine.surfaces[static_cast<std::size_t>(surface)];
  const int body = mesh.machine.body_index(spec.body);
  FaceSet set{&mesh.bodies[static_cast<std::size_t>(body)], &mesh.surfaces[static_cast<std::size_t>(surface)],
              static_cast<int>(mesh.first_node[static_cast<std::size_t>(body)]), 0.0};
  for (int face : *set.faces) set.area += set.body->face_area(face);
  if (!(set.area > 0.0))
    throw core::InputError(spec.place, "surface '" + id + "' with an area of 0", "a surface with triangles");
  return set;
}

/// Adds the integral of N N^T over the surface.
void add_surface_mass(Triplets& triplets, const FaceSet& set) {
  for (int face : *set.faces) {
    const Eigen::Vector3i nodes = set.nodes(face);
    const double a = set.body->face_area(face) / 12.0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) triplets.emplace_back(nodes[i], nodes[j], i == j ? 2 * a : a);
  }
}

/// Integral of N over the surface.
SparseColumn surface_load(const FaceSet& set) {
  SparseColumn load;
  for (int face : *set.faces) {
    const Eigen::Vector3i nodes = set.nodes(face);
    const double a = set.body->face_area(face) / 3.0;
    for (int i = 0; i < 3; ++i) load.emplace_back(nodes[i], a);
  }
  return load;
}

/// Capacity and conduction of one body, global numbers.
void add_body(const MachineMesh& mesh, std::size_t b, Triplets& capacity, Triplets& conduction) {
  const TetMesh& body = mesh.bodies[b];
  const mesh::Material& material = mesh.machine.material(mesh.machine.bodies[b].material);
  const int first = static_cast<int>(mesh.first_node[b]);
  capacity.reserve(static_cast<std::size_t>(16 * body.elements()));
  conduction.reserve(static_cast<std::size_t>(16 * body.elements()));
  for (Index e = 0; e < body.elements(); ++e) {
    Eigen::Matrix4d corners;
    corners.row(0).setOnes();
    for (int i = 0; i < 4; ++i) corners.col(i).tail<3>() = body.points.col(body.tets(i, e));
    // Columns of the inverse's transpose hold the gradients of the four shape functions.
    const Eigen::Matrix<double, 4, 3> gradients = corners.inverse().rightCols<3>();
    const double volume = body.volume(e);
    const Eigen::Matrix4d k = material.conductivity * volume * gradients * gradients.transpose();
    const double m = material.density * material.specific_heat.value * volume / 20.0;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const int row = first + body.tets(i, e), column = first + body.tets(j, e);
        capacity.emplace_back(row, column, i == j ? 2 * m : m);
        conduction.emplace_back(row, column, k(i, j));
      }
  }
}

/// One joint at one grid node: its matrix, and where frictional heat of its two sides goes.
struct JointTerm {
  SparseMatrix matrix;
  double area = 0;
  SparseColumn slave_load, master_load;  // integrals of N over the area in contact
};

JointTerm joint_term(const MachineMesh& mesh, const mesh::JointSpec& joint, double position, Index size) {
  const mesh::Machine& machine = mesh.machine;
  mesh::Pose pose = mesh::home_pose(machine);
  if (!joint.axis.empty()) pose[machine.axis_index(joint.axis)] = position;
  const auto body_of = [&](const std::string& surface) {
    return machine.body_index(machine.surfaces[static_cast<std::size_t>(machine.surface_index(surface))].body);
  };
  const int slave = body_of(joint.slave), master = joint.master.empty() ? -1 : body_of(joint.master);
  const Eigen::Isometry3d still = Eigen::Isometry3d::Identity();
  const std::vector<ContactPoint> contact =
      find_contact(mesh, joint, mesh::body_transform(machine, slave, pose),
                   master < 0 ? still : mesh::body_transform(machine, master, pose));
  JointTerm term;
  Triplets triplets;
  triplets.reserve(36 * contact.size());
  for (const ContactPoint& c : contact) {
    int nodes[6];
    double v[6];
    const int sides = c.master_face < 0 ? 3 : 6;
    for (int i = 0; i < 3; ++i) {
      nodes[i] = static_cast<int>(mesh.first_node[static_cast<std::size_t>(slave)]) +
                 mesh.bodies[static_cast<std::size_t>(slave)].faces(i, c.slave_face);
      v[i] = c.slave_weights[i];
      term.slave_load.emplace_back(nodes[i], c.area * v[i]);
      if (sides == 3) continue;
      nodes[3 + i] = static_cast<int>(mesh.first_node[static_cast<std::size_t>(master)]) +
                     mesh.bodies[static_cast<std::size_t>(master)].faces(i, c.master_face);
      v[3 + i] = -c.master_weights[i];
      term.master_load.emplace_back(nodes[3 + i], c.area * c.master_weights[i]);
    }
    for (int i = 0; i < sides; ++i)
      for (int j = 0; j < sides; ++j) triplets.emplace_back(nodes[i], nodes[j], c.area * v[i] * v[j]);
    term.area += c.area;
  }
  term.matrix = from_triplets(size, size, triplets);
  return term;
}

/// The joints at all nodes of their grids, in parallel. @throws InputError, see assemble_thermal
std::vector<std::vector<JointTerm>> joint_terms(const MachineMesh& mesh, const Layout& layout, Index size) {
  std::vector<std::vector<JointTerm>> terms;
  std::vector<std::pair<std::size_t, std::size_t>> tasks;
  for (std::size_t j = 0; j < layout.grids.size(); ++j) {
    terms.emplace_back(layout.grids[j].positions.size());
    for (std::size_t node = 0; node < terms[j].size(); ++node) tasks.emplace_back(j, node);
  }
  core::parallel_for(0, tasks.size(), [&](std::size_t i) {
    const auto [j, node] = tasks[i];
    terms[j][node] = joint_term(mesh, mesh.machine.joints[j], layout.grids[j].positions[node], size);
  });
  for (std::size_t j = 0; j < terms.size(); ++j) {
    const mesh::JointSpec& joint = mesh.machine.joints[j];
    double largest = 0.0;
    std::size_t open = 0;
    for (const JointTerm& term : terms[j]) {
      largest = std::max(largest, term.area);
      if (term.area <= 0.0) ++open;
    }
    if (largest <= 0.0)
      throw core::InputError(mesh.machine.path.string() + " joint " + joint.id,
                             fmt::format("'{}' and '{}' touch nowhere over the travel", joint.slave, joint.master),
                             fmt::format("surfaces that face each other within reach_mm = {:.4g}", joint.reach * 1e3));
    if (open > 0)
      core::warn(fmt::format("joint {}: no contact at {} of {} positions of its axis {}", joint.id, open, terms[j].size(),
                             joint.axis));
  }
  return terms;
}

/// Frictional heat of one W at a joint: shares of both sides, sum 1 whatever the contact area is.
SparseColumn joint_source(const MachineMesh& mesh, const mesh::JointSpec& joint, const mesh::SourcePlace& place,
                          const JointTerm& term) {
  SparseColumn load;
  if (term.area <= 0.0) {
    const FaceSet set = face_set(mesh, joint.slave);
    load = surface_load(set);
    for (auto& [node, value] : load) value /= set.area;
    return load;
  }
  // The ground takes no heat: what would be its share stays with the slave.
  const double slave_share = joint.master.empty() ? 1.0 : place.slave_share;
  for (const auto& [node, value] : term.slave_load) load.emplace_back(node, value * slave_share / term.area);
  for (const auto& [node, value] : term.master_load) load.emplace_back(node, value * (1.0 - slave_share) / term.area);
  return load;
}

/// Interpolation weights at the point of the body that is nearest to p.
SparseColumn interpolation_at(const TetMesh& body, int first_node, const Vector3d& p) {
  SparseColumn weights;
  for (Index e = 0; e < body.elements(); ++e) {
    const Vector3d a = body.points.col(body.tets(0, e));
    Eigen::Matrix3d edges;
    double reach = 0.0;
    for (int i = 0; i < 3; ++i) {
      edges.col(i) = body.points.col(body.tets(i + 1, e)) - a;
      reach = std::max(reach, edges.col(i).cwiseAbs().maxCoeff());
    }
    if ((p - a).cwiseAbs().maxCoeff() > reach) continue;
    const Vector3d w = edges.partialPivLu().solve(p - a);
    if (w.minCoeff() < -1e-9 || w.sum() > 1.0 + 1e-9) continue;
    weights.emplace_back(first_node + body.tets(0, e), 1.0 - w.sum());
    for (int i = 0; i < 3; ++i) weights.emplace_back(first_node + body.tets(i + 1, e), w[i]);
    return weights;
  }
  double best = std::numeric_limits<double>::infinity();
  for (Index f = 0; f < body.face_count(); ++f) {
    const Vector3d a = body.points.col(body.faces(0, f)), b = body.points.col(body.faces(1, f)),
                   c = body.points.col(body.faces(2, f));
    const Vector3d q = mesh::nearest_on_triangle(p, a, b, c);
    const double distance = (q - p).norm();
    if (distance >= best) continue;
    best = distance;
    const Vector3d n = (b - a).cross(c - a);
    Vector3d w((b - q).cross(c - q).dot(n), (c - q).cross(a - q).dot(n), (a - q).cross(b - q).dot(n));
    w = w.cwiseMax(0.0) / w.cwiseMax(0.0).sum();
    weights.clear();
    for (int i = 0; i < 3; ++i) weights.emplace_back(first_node + body.faces(i, f), w[i]);
  }
  return weights;
}

SparseMatrix assemble_sensors(const MachineMesh& mesh, Index size) {
  Triplets triplets;
  const mesh::Machine& machine = mesh.machine;
  for (std::size_t s = 0; s < machine.sensors.size(); ++s) {
    const int body = machine.body_index(machine.sensors[s].body);
    const SparseColumn weights =
        interpolation_at(mesh.bodies[static_cast<std::size_t>(body)],
                         static_cast<int>(mesh.first_node[static_cast<std::size_t>(body)]), machine.sensors[s].point);
    for (const auto& [node, weight] : weights) triplets.emplace_back(static_cast<int>(s), node, weight);
  }
  return from_triplets(static_cast<Index>(machine.sensors.size()), size, triplets);
}

std::vector<JointGrid> joint_grids(const MachineMesh& mesh) {
  std::vector<JointGrid> grids;
  for (const mesh::JointSpec& joint : mesh.machine.joints) {
    JointGrid grid;
    grid.axis = joint.axis.empty() ? -1 : mesh.machine.axis_index(joint.axis);
    grid.periodic = grid.axis >= 0 && mesh.machine.axes[static_cast<std::size_t>(grid.axis)].endless;
    grid.positions = contact_grid(mesh, joint);
    grids.push_back(std::move(grid));
  }
  return grids;
}

}  // namespace

ThermalSystem assemble_thermal(const MachineMesh& mesh) {
  const mesh::Machine& machine = mesh.machine;
  ThermalSystem system;
  system.layout = make_layout(machine, joint_grids(mesh));
  system.nodes = mesh.nodes();
  std::vector<int> first_fluid;  // one per coolant
  int fluid = static_cast<int>(system.nodes);
  for (const mesh::CoolantSpec& coolant : machine.coolants) {
    first_fluid.push_back(fluid);
    fluid += static_cast<int>(coolant.segments.size());
  }
  system.size = fluid;
  const Index n = system.size;

  std::vector<Triplets> capacities(mesh.bodies.size()), conductions(mesh.bodies.size());
  core::parallel_for(0, mesh.bodies.size(), [&](std::size_t b) { add_body(mesh, b, capacities[b], conductions[b]); });
  Triplets capacity, conduction;
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    capacity.insert(capacity.end(), capacities[b].begin(), capacities[b].end());
    conduction.insert(conduction.end(), conductions[b].begin(), conductions[b].end());
  }
  for (std::size_t c = 0; c < machine.coolants.size(); ++c)
    for (std::size_t s = 0; s < machine.coolants[c].segments.size(); ++s) {
      const int node = first_fluid[c] + static_cast<int>(s);
      const mesh::CoolantSpec& coolant = machine.coolants[c];
      capacity.emplace_back(node, node, coolant.density * coolant.specific_heat * coolant.segments[s].volume);
    }
  system.capacity = from_triplets(n, n, capacity);
  system.conduction = from_triplets(n, n, conduction);

  std::vector<std::vector<JointTerm>> joints = joint_terms(mesh, system.layout, n);
  Triplets inputs;
  system.terms.resize(system.layout.terms.size());
  for (std::size_t t = 0; t < system.layout.terms.size(); ++t) {
    const Term& term = system.layout.terms[t];
    const auto item = static_cast<std::size_t>(term.item);
    Triplets triplets;
    switch (term.kind) {
      case TermKind::film:
        for (const std::string& surface : machine.films[item].surfaces) add_surface_mass(triplets, face_set(mesh, surface));
        break;
      case TermKind::contact:
        system.terms[t] = std::move(joints[item][static_cast<std::size_t>(term.part)].matrix);
        continue;
      case TermKind::coolant_wall: {
        // (N - 1_f)(N - 1_f)^T over the wall of the segment
        const FaceSet wall = face_set(mesh, machine.coolants[item].segments[static_cast<std::size_t>(term.part)].surface);
        const int node = first_fluid[item] + term.part;
        add_surface_mass(triplets, wall);
        for (const auto& [row, value] : surface_load(wall)) {
          triplets.emplace_back(row, node, -value);
          triplets.emplace_back(node, row, -value);
        }
        triplets.emplace_back(node, node, wall.area);
        break;
      }
      case TermKind::coolant_flow:
        for (std::size_t s = 0; s < machine.coolants[item].segments.size(); ++s) {
          const int node = first_fluid[item] + static_cast<int>(s);
          triplets.emplace_back(node, node, machine.coolants[item].specific_heat);
          if (s > 0) triplets.emplace_back(node, node - 1, -machine.coolants[item].specific_heat);
        }
        break;
    }
    system.terms[t] = from_triplets(n, n, triplets);
  }

  for (std::size_t k = 0; k < system.layout.inputs.size(); ++k) {
    const Input& input = system.layout.inputs[k];
    const int column = static_cast<int>(k);
    const auto item = static_cast<std::size_t>(input.item);
    switch (input.kind) {
      case InputKind::film_ambient:
        for (const std::string& surface : machine.films[item].surfaces)
          put_column(inputs, column, surface_load(face_set(mesh, surface)));
        break;
      case InputKind::contact_ambient:
        put_column(inputs, column, joints[item][static_cast<std::size_t>(input.node)].slave_load);
        break;
      case InputKind::coolant_inlet:
        inputs.emplace_back(first_fluid[item], column, machine.coolants[item].specific_heat);
        break;
      case InputKind::source: {
        const mesh::SourcePlace& place = machine.sources[item].places[static_cast<std::size_t>(input.place)];
        if (place.joint.empty()) {
          const FaceSet set = face_set(mesh, place.surface);
          put_column(inputs, column, surface_load(set), 1.0 / set.area);
        } else {
          const auto j = static_cast<std::size_t>(machine.joint_index(place.joint));
          put_column(inputs, column,
                     joint_source(mesh, machine.joints[j], place, joints[j][static_cast<std::size_t>(input.node)]));
        }
        break;
      }
    }
  }
  system.inputs = from_triplets(n, static_cast<Index>(system.layout.inputs.size()), inputs);
  system.sensors = assemble_sensors(mesh, n);
  return system;
}

}  // namespace thermotwin::solver
