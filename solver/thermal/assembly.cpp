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
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    for (Index column = 0; column < bodies[b].cols(); ++column) {
      *outer++ = at;
      for (SparseMatrix::InnerIterator it(bodies[b], column); it; ++it, ++at) {
        matrix.innerIndexPtr()[at] = first_node[b] + it.row();
        matrix.valuePtr()[at] = it.value();
      }
    }
  }
  for (std::size_t f = 0; f < fluids.size(); ++f, ++at) {
    *outer++ = at;
    matrix.innerIndexPtr()[at] = first_node.back() + f;
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
      for (auto& entry : weights) entry.first += mesh.first_node[body];
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

/// E and K0.
void assemble_bodies(const MachineMesh& mesh, ElementRules rules, const FluidNodes& fluids, ThermalSystem& system) {
  const mesh::Machine& machine = mesh.machine;
  std::vector<SparseMatrix> capacities(mesh.bodies.size()), conductions(mesh.bodies.size());
  core::parallel_for(0, mesh.bodies.size(), [&](std::size_t b) {
    BodyHeat heat =
        assemble_heat(mesh.bodies[b], machine.material(machine.bodies[b].material), machine.lumped_capacity, rules);
    capacities[b] = std::move(heat.capacity);
    conductions[b] = std::move(heat.conduction);
  });
  const std::vector<double> no_conduction(fluids.count(), 0.0);
  system.capacity = on_diagonal(capacities, mesh.first_node, system.size, fluids.capacities());
  system.conduction = on_diagonal(conductions, mesh.first_node, system.size, no_conduction);
}

void add_film(const MachineMesh& mesh, ElementRules rules, const FluidNodes& fluids, const mesh::FilmSpec& film,
              Triplets& triplets) {
  const int volume = mesh.machine.volume_index(film.ambient);
  for (const std::string& surface : film.surfaces) {
    const FaceSet set = face_set(mesh, surface);
    add_surface_mass(triplets, set, rules);
    if (volume >= 0) add_mixed(triplets, set, fluids.volume(volume));
  }
}

void add_exchange(const mesh::Machine& machine, const FluidNodes& fluids, const Term& term, Triplets& triplets) {
  const int one = fluids.volume(term.item);
  triplets.emplace_back(one, one, 1.0);
  const std::string& with = machine.volumes[term.item].exchanges[term.part].with;
  if (const int other = machine.volume_index(with); other >= 0) {
    const int two = fluids.volume(other);
    triplets.emplace_back(two, two, 1.0);
    triplets.emplace_back(one, two, -1.0);
    triplets.emplace_back(two, one, -1.0);
  }
}

/// K_j of all but contacts, which joint_terms() gives.
SparseMatrix assemble_term(const MachineMesh& mesh, ElementRules rules, const FluidNodes& fluids, const Term& term,
                           Index size) {
  Triplets triplets;
  switch (term.kind) {
    case TermKind::film: add_film(mesh, rules, fluids, mesh.machine.films[term.item], triplets); break;
    case TermKind::contact: break;
    case TermKind::coolant_wall: fluids.add_wall(mesh, term.item, term.part, triplets); break;
    case TermKind::coolant_flow: fluids.add_flow(term.item, triplets); break;
    case TermKind::volume_exchange: add_exchange(mesh.machine, fluids, term, triplets); break;
    case TermKind::volume_given: triplets.emplace_back(fluids.volume(term.item), fluids.volume(term.item), 1.0); break;
  }
  return from_triplets(size, size, triplets);
}

/// 1 W of a source at one of its places.
void put_source(const MachineMesh& mesh, const Input& input, int column, const FluidNodes& fluids,
                const std::vector<std::vector<JointTerm>>& joints, Triplets& inputs) {
  const mesh::Machine& machine = mesh.machine;
  const mesh::SourcePlace& place = machine.sources[input.item].places[input.place];
  if (!place.volume.empty()) {
    inputs.emplace_back(fluids.volume(machine.volume_index(place.volume)), column, 1.0);
  } else if (place.joint.empty()) {
    const FaceSet set = face_set(mesh, place.surface);
    put_column(inputs, column, surface_load(set), 1.0 / set.area);
  } else {
    const std::size_t j = machine.joint_index(place.joint);
    put_column(inputs, column, joint_source(mesh, machine.joints[j], place, joints[j][input.node]));
  }
}

/// The columns s_k.
SparseMatrix assemble_inputs(const MachineMesh& mesh, const Layout& layout, const FluidNodes& fluids,
                             const std::vector<std::vector<JointTerm>>& joints, Index size) {
  const mesh::Machine& machine = mesh.machine;
  Triplets inputs;
  int column = 0;
  for (const Input& input : layout.inputs) {
    switch (input.kind) {
      case InputKind::film_ambient:
        for (const std::string& surface : machine.films[input.item].surfaces)
          put_column(inputs, column, surface_load(face_set(mesh, surface)));
        break;
      case InputKind::contact_ambient: put_column(inputs, column, joints[input.item][input.node].slave_load); break;
      case InputKind::film_gradient: {
        const mesh::FilmSpec& film = machine.films[input.item];
        const double level = machine.ambients[machine.ambient_index(film.ambient)].height;
        for (const std::string& surface : film.surfaces)
          put_column(inputs, column, surface_height_load(face_set(mesh, surface), level));
        break;
      }
      case InputKind::coolant_inlet: put_column(inputs, column, fluids.inlet(input.item)); break;
      case InputKind::volume_ambient:
      case InputKind::volume_given: inputs.emplace_back(fluids.volume(input.item), column, 1.0); break;
      case InputKind::source: put_source(mesh, input, column, fluids, joints, inputs); break;
    }
    ++column;
  }
  return from_triplets(size, column, inputs);
}

}  // namespace

ThermalSystem assemble_thermal(const MachineMesh& mesh) { return assemble_thermal(mesh, ElementRules::consistent); }

ThermalSystem assemble_thermal(const MachineMesh& mesh, ElementRules rules) {
  ThermalSystem system;
  system.layout = make_layout(mesh.machine, joint_grids(mesh));
  system.nodes = mesh.nodes();
  const FluidNodes fluids(mesh.machine, system.nodes);
  system.size = system.nodes + fluids.count();
  assemble_bodies(mesh, rules, fluids, system);
  std::vector<std::vector<JointTerm>> joints = joint_terms(mesh, system.layout.grids, rules, system.size);
  system.terms.resize(system.layout.terms.size());
  for (std::size_t t = 0; t < system.terms.size(); ++t) {
    const Term& term = system.layout.terms[t];
    if (term.kind == TermKind::contact)
      system.terms[t] = std::move(joints[term.item][term.part].matrix);
    else
      system.terms[t] = assemble_term(mesh, rules, fluids, term, system.size);
  }
  system.inputs = assemble_inputs(mesh, system.layout, fluids, joints, system.size);
  if (auto local = std::make_shared<LocalTerms>(mesh, system.size); !local->empty()) system.local = std::move(local);
  system.sensors = assemble_sensors(mesh, system.layout, fluids, joints, system.size);
  return system;
}

}  // namespace thermotwin::solver
