// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <map>

#include "core/error.h"
#include "core/progress.h"
#include "core/thread_pool.h"
#include "solver/contact.h"
#include "solver/fluid_assembly.h"
#include "solver/thermal_elements.h"
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

void put_column(Triplets& triplets, int column, const SparseColumn& values, double scale = 1.0) {
  for (const auto& [row, value] : values) triplets.emplace_back(row, column, scale * value);
}

/// Faces of a surface with their global node numbers and areas.
struct FaceSet {
  const TetMesh* body;
  const std::vector<int>* faces;
  int first_node;
  double area;

  mesh::FaceNodes nodes(int face) const { return mesh::face_nodes(*body, face).array() + first_node; }
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
void add_surface_mass(Triplets& triplets, const FaceSet& set, ElementRules rules = ElementRules::consistent) {
  const Eigen::MatrixXd& mass = face_mass(set.body->order(), rules);
  for (int face : *set.faces) {
    const mesh::FaceNodes nodes = set.nodes(face);
    const double area = set.body->face_area(face);
    for (Index i = 0; i < nodes.size(); ++i)
      for (Index j = 0; j < nodes.size(); ++j) triplets.emplace_back(nodes[i], nodes[j], area * mass(i, j));
  }
}

/// Integral of N over the surface.
SparseColumn surface_load(const FaceSet& set) {
  SparseColumn load;
  const mesh::FaceValues shares = face_load(set.body->order());
  for (int face : *set.faces) {
    const mesh::FaceNodes nodes = set.nodes(face);
    const double area = set.body->face_area(face);
    for (Index i = 0; i < nodes.size(); ++i)
      if (shares[i] != 0.0) load.emplace_back(nodes[i], area * shares[i]);
  }
  return load;
}

/// To the integral of N N^T what makes it that of (N - 1_f)(N - 1_f)^T: one fluid node on the other side.
void add_mixed(Triplets& triplets, const FaceSet& set, int fluid) {
  for (const auto& [node, value] : surface_load(set)) {
    triplets.emplace_back(node, fluid, -value);
    triplets.emplace_back(fluid, node, -value);
  }
  triplets.emplace_back(fluid, fluid, set.area);
}

/// The bodies' matrices on the diagonal, then the fluid nodes' own entries.
SparseMatrix on_diagonal(const std::vector<SparseMatrix>& bodies, const std::vector<Index>& first_node, Index size,
                         const std::vector<double>& fluids) {
  Index entries = static_cast<Index>(fluids.size());
  for (const SparseMatrix& body : bodies) entries += body.nonZeros();
  SparseMatrix matrix(size, size);
  matrix.resizeNonZeros(entries);
  int* outer = matrix.outerIndexPtr();
  int at = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b)
    for (Index column = 0; column < bodies[b].cols(); ++column) {
      *outer++ = at;
      for (SparseMatrix::InnerIterator it(bodies[b], column); it; ++it, ++at) {
        matrix.innerIndexPtr()[at] = static_cast<int>(first_node[b] + it.row());
        matrix.valuePtr()[at] = it.value();
      }
    }
  for (std::size_t f = 0; f < fluids.size(); ++f, ++at) {
    *outer++ = at;
    matrix.innerIndexPtr()[at] = static_cast<int>(first_node.back()) + static_cast<int>(f);
    matrix.valuePtr()[at] = fluids[f];
  }
  *outer = at;
  return matrix;
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
  SparseColumn jump;  // temperature of the slave less that of the master, by nodes
  const auto add_side = [&](int body, int face, const Vector3d& at, double sign, double area, SparseColumn& load) {
    const TetMesh& side = mesh.bodies[static_cast<std::size_t>(body)];
    const auto first = static_cast<int>(mesh.first_node[static_cast<std::size_t>(body)]);
    const mesh::FaceNodes nodes = mesh::face_nodes(side, face);
    const mesh::FaceValues values = mesh::face_shape(side.order(), at);
    for (Index i = 0; i < nodes.size(); ++i) {
      jump.emplace_back(first + nodes[i], sign * values[i]);
      load.emplace_back(first + nodes[i], area * values[i]);
    }
  };
  // Points of one pair of triangles share their nodes: they are added up before they take memory.
  struct Pair {
    SparseColumn jump;
    Eigen::MatrixXd sum;
  };
  std::map<int, Pair> pairs;  // of the slave's triangle, by the master's
  for (std::size_t i = 0; i < contact.size(); ++i) {
    const ContactPoint& c = contact[i];
    jump.clear();
    add_side(slave, c.slave_face, c.slave_weights, 1.0, c.area, term.slave_load);
    if (c.master_face >= 0) add_side(master, c.master_face, c.master_weights, -1.0, c.area, term.master_load);
    Eigen::VectorXd v(static_cast<Index>(jump.size()));
    for (std::size_t k = 0; k < jump.size(); ++k) v[static_cast<Index>(k)] = jump[k].second;
    Pair& pair = pairs[c.master_face];
    if (pair.jump.empty()) pair = {jump, Eigen::MatrixXd::Zero(v.size(), v.size())};
    pair.sum += c.area * v * v.transpose();
    term.area += c.area;
    if (i + 1 < contact.size() && contact[i + 1].slave_face == c.slave_face) continue;
    for (const auto& [face, done] : pairs)
      for (std::size_t row = 0; row < done.jump.size(); ++row)
        for (std::size_t column = 0; column < done.jump.size(); ++column)
          triplets.emplace_back(done.jump[row].first, done.jump[column].first,
                                done.sum(static_cast<Index>(row), static_cast<Index>(column)));
    pairs.clear();
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

/// Integral of N times the height above a level.
SparseColumn surface_height_load(const FaceSet& set, double level) {
  SparseColumn load;
  for (int face : *set.faces) {
    const mesh::FaceNodes nodes = set.nodes(face);
    const double area = set.body->face_area(face);
    for (const mesh::FacePoint& point : mesh::face_rule(3)) {
      const mesh::FaceValues values = mesh::face_shape(set.body->order(), point.at);
      double z = -level;
      for (int k = 0; k < 3; ++k) z += point.at[k] * set.body->points(2, set.body->faces(k, face));
      for (Index i = 0; i < nodes.size(); ++i) load.emplace_back(nodes[i], area * point.share * z * values[i]);
    }
  }
  return load;
}

/// Sensors, then what the layout observes.
SparseMatrix assemble_sensors(const MachineMesh& mesh, const Layout& layout, const FluidNodes& fluids,
                              const std::vector<std::vector<JointTerm>>& joints, Index size) {
  Triplets triplets;
  const mesh::Machine& machine = mesh.machine;
  int row = 0;
  const auto put_row = [&](const SparseColumn& values, double scale = 1.0) {
    for (const auto& [node, value] : values) triplets.emplace_back(row, node, scale * value);
  };
  for (const mesh::SensorSpec& sensor : machine.sensors) {
    if (!sensor.volume.empty()) {
      put_row({{fluids.volume(machine.volume_index(sensor.volume)), 1.0}});
    } else if (!sensor.return_of.empty()) {
      put_row(fluids.outflow(machine.coolant_index(sensor.return_of)));
    } else {
      const auto body = static_cast<std::size_t>(machine.body_index(sensor.body));
      SparseColumn weights = interpolation_at(mesh.bodies[body], sensor.point);
      for (auto& entry : weights) entry.first += static_cast<int>(mesh.first_node[body]);
      put_row(weights);
    }
    ++row;
  }
  for (const Observed& observed : layout.observed) {
    const auto item = static_cast<std::size_t>(observed.item);
    switch (observed.kind) {
      case ObservedKind::film: {
        double area = 0.0;
        for (const std::string& surface : machine.films[item].surfaces) area += face_set(mesh, surface).area;
        for (const std::string& surface : machine.films[item].surfaces) put_row(surface_load(face_set(mesh, surface)), 1.0 / area);
        break;
      }
      case ObservedKind::joint: {
        // Both sides where they touch, mean over the axis.
        double area = 0.0;
        for (const JointTerm& term : joints[item]) area += term.area;
        for (const JointTerm& term : joints[item]) {
          const bool grounded = term.master_load.empty();
          put_row(term.slave_load, (grounded ? 1.0 : 0.5) / area);
          put_row(term.master_load, 0.5 / area);
        }
        break;
      }
      case ObservedKind::coolant_return:
        put_row(fluids.outflow(observed.item));
        break;
      case ObservedKind::volume:
        put_row({{fluids.volume(observed.item), 1.0}});
        break;
    }
    ++row;
  }
  return from_triplets(row, size, triplets);
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

ThermalSystem assemble_thermal(const MachineMesh& mesh) { return assemble_thermal(mesh, ElementRules::consistent); }

ThermalSystem assemble_thermal(const MachineMesh& mesh, ElementRules rules) {
  const mesh::Machine& machine = mesh.machine;
  ThermalSystem system;
  system.layout = make_layout(machine, joint_grids(mesh));
  system.nodes = mesh.nodes();
  const FluidNodes fluids(machine, system.nodes);
  system.size = system.nodes + fluids.count();
  const Index n = system.size;

  std::vector<SparseMatrix> capacities(mesh.bodies.size()), conductions(mesh.bodies.size());
  core::parallel_for(0, mesh.bodies.size(), [&](std::size_t b) {
    BodyHeat heat = assemble_heat(mesh.bodies[b], machine.material(machine.bodies[b].material), machine.lumped_capacity, rules);
    capacities[b] = std::move(heat.capacity);
    conductions[b] = std::move(heat.conduction);
  });
  system.capacity = on_diagonal(capacities, mesh.first_node, n, fluids.capacities());
  system.conduction = on_diagonal(conductions, mesh.first_node, n, std::vector<double>(static_cast<std::size_t>(fluids.count()), 0.0));

  std::vector<std::vector<JointTerm>> joints = joint_terms(mesh, system.layout, n);
  Triplets inputs;
  system.terms.resize(system.layout.terms.size());
  for (std::size_t t = 0; t < system.layout.terms.size(); ++t) {
    const Term& term = system.layout.terms[t];
    const auto item = static_cast<std::size_t>(term.item);
    Triplets triplets;
    switch (term.kind) {
      case TermKind::film:
        for (const std::string& surface : machine.films[item].surfaces) {
          const FaceSet set = face_set(mesh, surface);
          add_surface_mass(triplets, set, rules);
          if (const int volume = machine.volume_index(machine.films[item].ambient); volume >= 0)
            add_mixed(triplets, set, fluids.volume(volume));
        }
        break;
      case TermKind::contact:
        system.terms[t] = std::move(joints[item][static_cast<std::size_t>(term.part)].matrix);
        continue;
      case TermKind::coolant_wall:
        fluids.add_wall(mesh, term.item, term.part, triplets);
        break;
      case TermKind::coolant_flow:
        fluids.add_flow(term.item, triplets);
        break;
      case TermKind::volume_exchange: {
        const int one = fluids.volume(term.item);
        triplets.emplace_back(one, one, 1.0);
        const std::string& with = machine.volumes[item].exchanges[static_cast<std::size_t>(term.part)].with;
        if (const int other = machine.volume_index(with); other >= 0) {
          const int two = fluids.volume(other);
          triplets.emplace_back(two, two, 1.0);
          triplets.emplace_back(one, two, -1.0);
          triplets.emplace_back(two, one, -1.0);
        }
        break;
      }
      case TermKind::volume_given:
        triplets.emplace_back(fluids.volume(term.item), fluids.volume(term.item), 1.0);
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
      case InputKind::film_gradient: {
        const double level = machine.ambients[static_cast<std::size_t>(machine.ambient_index(machine.films[item].ambient))].height;
        for (const std::string& surface : machine.films[item].surfaces)
          put_column(inputs, column, surface_height_load(face_set(mesh, surface), level));
        break;
      }
      case InputKind::coolant_inlet:
        put_column(inputs, column, fluids.inlet(input.item));
        break;
      case InputKind::volume_ambient:
      case InputKind::volume_given:
        inputs.emplace_back(fluids.volume(input.item), column, 1.0);
        break;
      case InputKind::source: {
        const mesh::SourcePlace& place = machine.sources[item].places[static_cast<std::size_t>(input.place)];
        if (!place.volume.empty()) {
          inputs.emplace_back(fluids.volume(machine.volume_index(place.volume)), column, 1.0);
        } else if (place.joint.empty()) {
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
  if (auto local = std::make_shared<LocalTerms>(mesh, n); !local->empty()) system.local = std::move(local);
  system.sensors = assemble_sensors(mesh, system.layout, fluids, joints, n);
  return system;
}

}  // namespace thermotwin::solver
