// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/assembly.h"

#include "core/thread_pool.h"
#include "solver/operation/layout.h"
#include "solver/thermal/fluid_assembly.h"
#include "solver/thermal/joints.h"
#include "solver/thermal/surfaces.h"
#include "solver/thermal/system.h"

namespace thermotwin::solver {

using Eigen::Index;
using mesh::MachineMesh;
using namespace assembly;

namespace {

void put_column(Triplets& triplets, int column, const SparseColumn& values, double scale = 1.0) {
  for (const auto& [row, value] : values) triplets.emplace_back(row, column, scale * value);
}

/// The bodies' matrices on the diagonal, then the fluid nodes' own entries.
SparseMatrix on_diagonal(const std::vector<SparseMatrix>& bodies, const std::vector<Index>& first_node, Index size,
                         const std::vector<double>& fluids) {
  Index entries = std::ssize(fluids);
  for (const SparseMatrix& body : bodies) entries += body.nonZeros();
  SparseMatrix matrix(size, size);
  matrix.resizeNonZeros(entries);
  int* outer = matrix.outerIndexPtr();
  int at = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b)
    for (Index column = 0; column < bodies[b].cols(); ++column) {
      *outer++ = at;
      for (SparseMatrix::InnerIterator it(bodies[b], column); it; ++it, ++at) {
        matrix.innerIndexPtr()[at] = first_node[b] + it.row();
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
      const std::size_t body = machine.body_index(sensor.body);
      SparseColumn weights = interpolation_at(mesh.bodies[body], sensor.point);
      for (auto& entry : weights) entry.first += static_cast<int>(mesh.first_node[body]);
      put_row(weights);
    }
    ++row;
  }
  for (const Observed& observed : layout.observed) {
    const std::size_t item = observed.item;
    switch (observed.kind) {
      case ObservedKind::film: {
        double area = 0.0;
        for (const std::string& surface : machine.films[item].surfaces) area += face_set(mesh, surface).area;
        for (const std::string& surface : machine.films[item].surfaces)
          put_row(surface_load(face_set(mesh, surface)), 1.0 / area);
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
      case ObservedKind::coolant_return: put_row(fluids.outflow(observed.item)); break;
      case ObservedKind::volume: put_row({{fluids.volume(observed.item), 1.0}}); break;
    }
    ++row;
  }
  return from_triplets(row, size, triplets);
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
    BodyHeat heat =
        assemble_heat(mesh.bodies[b], machine.material(machine.bodies[b].material), machine.lumped_capacity, rules);
    capacities[b] = std::move(heat.capacity);
    conductions[b] = std::move(heat.conduction);
  });
  system.capacity = on_diagonal(capacities, mesh.first_node, n, fluids.capacities());
  system.conduction = on_diagonal(conductions, mesh.first_node, n, std::vector<double>(fluids.count(), 0.0));

  std::vector<std::vector<JointTerm>> joints = joint_terms(mesh, system.layout.grids, rules, n);
  Triplets inputs;
  system.terms.resize(system.layout.terms.size());
  for (std::size_t t = 0; t < system.layout.terms.size(); ++t) {
    const Term& term = system.layout.terms[t];
    const std::size_t item = term.item;
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
      case TermKind::contact: system.terms[t] = std::move(joints[item][term.part].matrix); continue;
      case TermKind::coolant_wall: fluids.add_wall(mesh, term.item, term.part, triplets); break;
      case TermKind::coolant_flow: fluids.add_flow(term.item, triplets); break;
      case TermKind::volume_exchange: {
        const int one = fluids.volume(term.item);
        triplets.emplace_back(one, one, 1.0);
        const std::string& with = machine.volumes[item].exchanges[term.part].with;
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
    const int column = k;
    const std::size_t item = input.item;
    switch (input.kind) {
      case InputKind::film_ambient:
        for (const std::string& surface : machine.films[item].surfaces)
          put_column(inputs, column, surface_load(face_set(mesh, surface)));
        break;
      case InputKind::contact_ambient: put_column(inputs, column, joints[item][input.node].slave_load); break;
      case InputKind::film_gradient: {
        const double level = machine.ambients[machine.ambient_index(machine.films[item].ambient)].height;
        for (const std::string& surface : machine.films[item].surfaces)
          put_column(inputs, column, surface_height_load(face_set(mesh, surface), level));
        break;
      }
      case InputKind::coolant_inlet: put_column(inputs, column, fluids.inlet(input.item)); break;
      case InputKind::volume_ambient:
      case InputKind::volume_given: inputs.emplace_back(fluids.volume(input.item), column, 1.0); break;
      case InputKind::source: {
        const mesh::SourcePlace& place = machine.sources[item].places[input.place];
        if (!place.volume.empty()) {
          inputs.emplace_back(fluids.volume(machine.volume_index(place.volume)), column, 1.0);
        } else if (place.joint.empty()) {
          const FaceSet set = face_set(mesh, place.surface);
          put_column(inputs, column, surface_load(set), 1.0 / set.area);
        } else {
          const std::size_t j = machine.joint_index(place.joint);
          put_column(inputs, column, joint_source(mesh, machine.joints[j], place, joints[j][input.node]));
        }
        break;
      }
    }
  }
  system.inputs = from_triplets(n, std::ssize(system.layout.inputs), inputs);
  if (auto local = std::make_shared<LocalTerms>(mesh, n); !local->empty()) system.local = std::move(local);
  system.sensors = assemble_sensors(mesh, system.layout, fluids, joints, n);
  return system;
}

}  // namespace thermotwin::solver
