// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/machine_mesh.h"

#include <charconv>
#include <cmath>

#include "core/error.h"
#include "core/process.h"
#include "core/progress.h"
#include "core/range.h"
#include "mesh/body_check.h"
#include "mesh/import/import.h"
#include "mesh/import/mesh_cache.h"
#include "mesh/selection.h"
#include "mesh/sensor_check.h"
#include "mesh/surface_area.h"

namespace thermotwin::mesh {

namespace {

TetMesh mesh_body(const BodySpec& body, const MeshOptions& options) {
  ImportOptions import;
  import.body = body.id;
  import.unit_m = body.unit_m;
  import.element_size_m = body.element_size * options.size_factor;
  import.elements_per_turn = body.elements_per_turn;
  import.max_elements = body.max_elements;
  import.lattice = body.lattice;
  const std::string name = options.cache.empty() ? std::string() : cache_name(body.cad, import);
  if (name.empty()) return import_body(body.cad, import);
  const std::filesystem::path file = options.cache / name;
  if (auto kept = read_cached(file)) return std::move(*kept);
  TetMesh mesh = import_body(body.cad, import);
  write_cached(file, mesh);
  return mesh;
}

}  // namespace

const TetMesh& MachineMesh::body_of_surface(int surface) const {
  return bodies[machine.body_index(machine.surfaces[surface].body)];
}

double MachineMesh::surface_area(int surface) const {
  const TetMesh& mesh = body_of_surface(surface);
  double sum = 0.0;
  for (const int face : surfaces[surface]) sum += mesh.face_area(face);
  return sum;
}

void MeshOptions::validate() const { core::require_within("mesh size factor", size_factor, core::positive); }

MachineMesh build_machine_mesh(const Machine& machine, const MeshOptions& options) {
  options.validate();
  MachineMesh result;
  result.machine = machine;
  result.first_node = {0};
  if (!options.cache.empty()) core::remove_stale_parts(options.cache);
  core::Progress progress("mesh of '" + machine.name + "'", std::max<std::size_t>(1, machine.bodies.size()));
  for (const BodySpec& body : machine.bodies) {  // one after the other: Gmsh has one global state
    result.bodies.push_back(mesh_body(body, options));
    TetMesh& made = result.bodies.back();
    if (machine.order == 1 && made.order() == 2) {
      core::warn("body '" + body.id + "': " + body.cad.filename().string() +
                 ": quadratic tetrahedra are used as linear ones, without their edge nodes; order = 2 keeps them");
    }
    check_pieces(body, made, machine.path.string());
    warn_of_poor_quality(body, made);
    set_order(made, machine.order);
    result.first_node.push_back(result.first_node.back() + result.bodies.back().nodes());
    progress.advance();
  }
  check_overlaps(machine, result.bodies);
  result.surfaces = resolve_surfaces(machine, result.bodies);
  warn_of_box_areas(result, cut_areas(result));
  check_sensors(machine, result.bodies);
  check_scales(machine, result.bodies);
  check_screws(machine, result.bodies);
  check_tcp(machine, result.bodies);
  check_tool_surface(machine, result.bodies, result.surfaces);
  return result;
}

double size_factor(const Machine& machine, const std::string& word) {
  if (word == "coarse") return machine.coarse;
  if (word == "standard") return machine.standard;
  if (word == "fine") return machine.fine;
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !(value >= 0.01 && value <= 100.0))
    throw core::InputError("mesh size", "'" + word + "'", "coarse, standard, fine, or a factor from 0.01 to 100");
  return value;
}

}  // namespace thermotwin::mesh
