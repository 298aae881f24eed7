// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/benchmarks/body_case.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "core/error.h"
#include "core/file.h"
#include "core/text.h"
#include "solver/elastic/assembly.h"

namespace thermotwin::bench {
namespace {

/// Surface of the body by which its parent (or the ground) holds it; any surface if there is none.
std::string foot_of(const mesh::Machine& machine, const std::string& body) {
  for (const mesh::JointSpec& joint : machine.joints) {
    const std::size_t surface = machine.surface_index(joint.slave);
    if (machine.surfaces[surface].body == body) return joint.slave;
  }
  throw core::InputError("--body " + body, "a body that no joint holds", "a body with a joint of its own");
}

std::string heated_of(const mesh::Machine& machine, const std::string& body) {
  for (const mesh::SourceSpec& source : machine.sources) {
    for (const mesh::SourcePlace& place : source.places) {
      if (!place.surface.empty() && machine.surfaces[machine.surface_index(place.surface)].body == body)
        return place.surface;
    }
  }
  return "bench.skin";
}

mesh::FilmSpec film(const std::string& id, const std::string& surface, double coefficient, const std::string& ambient) {
  mesh::FilmSpec film;
  film.id = id;
  film.surfaces = {surface};
  film.ambient = ambient;
  film.coefficient = {coefficient, 0.0};
  return film;
}

mesh::AmbientSpec ambient(const std::string& id, double temperature_C) {
  mesh::AmbientSpec ambient;
  ambient.id = id;
  ambient.default_C = {temperature_C, 0.0};
  return ambient;
}

std::string deck_mesh(const BodyCase& one) {
  const mesh::TetMesh& mesh = one.mesh.bodies[0];
  const mesh::Machine& machine = one.mesh.machine;
  const mesh::Material& material = machine.material(machine.bodies[0].material);
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "*NODE, NSET=NALL\n");
  for (Eigen::Index i = 0; i < mesh.nodes(); ++i) {
    fmt::format_to(out, "{}, {:.12e}, {:.12e}, {:.12e}\n", i + 1, mesh.points(0, i), mesh.points(1, i),
                   mesh.points(2, i));
  }
  fmt::format_to(out, "*ELEMENT, TYPE=C3D4, ELSET=EALL\n");
  for (Eigen::Index e = 0; e < mesh.elements(); ++e) {
    fmt::format_to(out, "{}, {}, {}, {}, {}\n", e + 1, mesh.tets(0, e) + 1, mesh.tets(1, e) + 1, mesh.tets(2, e) + 1,
                   mesh.tets(3, e) + 1);
  }
  fmt::format_to(out,
                 "*MATERIAL, NAME=M\n*ELASTIC\n{:.9e}, {:.9e}\n*EXPANSION, "
                 "ZERO=0.\n{:.9e}\n*CONDUCTIVITY\n{:.9e}\n*DENSITY\n{:.9e}\n*SPECIFIC HEAT\n{:.9e}\n",
                 material.young, material.poisson, material.expansion.value, material.conductivity, material.density,
                 material.specific_heat.value);
  fmt::format_to(out, "*SOLID SECTION, ELSET=EALL, MATERIAL=M\n*INITIAL CONDITIONS, TYPE=TEMPERATURE\nNALL, 0.\n");
  return fmt::to_string(text);
}

/// Number of the element's face in a deck (F1: nodes 1 2 3, F2: 1 4 2, F3: 2 4 3, F4: 3 4 1).
int deck_face(const mesh::TetMesh& mesh, int face) {
  for (int i = 0; i < 4; ++i) {
    const int node = mesh.tets(i, mesh.face_tet[face]);
    if ((mesh.faces.col(face).array() == node).any()) continue;
    constexpr int opposite[4] = {3, 4, 2, 1};
    return opposite[i];
  }
  return 0;
}

std::string deck_heat(const BodyCase& one, int steps) {
  const mesh::TetMesh& mesh = one.mesh.bodies[0];
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "*STEP, INC={}\n*HEAT TRANSFER, DIRECT\n{}, {}\n*FILM\n", 2 * steps, one.step_s,
                 one.step_s * steps);
  const auto surface = [&](const char* id) -> const std::vector<int>& {
    return one.mesh.surfaces[one.mesh.machine.surface_index(id)];
  };
  for (const int face : surface("bench.skin"))
    fmt::format_to(out, "{}, F{}, {:.6f}, {:.6e}\n", mesh.face_tet[face] + 1, deck_face(mesh, face), air_K, skin_film);
  for (const int face : surface("bench.foot")) {
    fmt::format_to(out, "{}, F{}, {:.6f}, {:.6e}\n", mesh.face_tet[face] + 1, deck_face(mesh, face), foundation_K,
                   foot_film);
  }
  const double flux = heat_W / one.mesh.surface_area(one.mesh.machine.surface_index("bench.heated"));
  fmt::format_to(out, "*DFLUX\n");
  for (const int face : surface("bench.heated"))
    fmt::format_to(out, "{}, S{}, {:.9e}\n", mesh.face_tet[face] + 1, deck_face(mesh, face), flux);
  fmt::format_to(out, "*NODE PRINT, NSET=NALL, FREQUENCY={}\nNT\n*END STEP\n", steps);
  return fmt::to_string(text);
}

}  // namespace

BodyCase body_case(const mesh::Machine& machine, const std::string& body, double size_factor,
                   const std::filesystem::path& cache) {
  const int index = machine.body_index(body);
  if (index < 0) {
    std::vector<std::string> ids;
    for (const mesh::BodySpec& spec : machine.bodies) ids.push_back(spec.id);
    throw core::InputError("--body", "'" + body + "'", "one of: " + core::join(ids));
  }
  mesh::Machine alone;
  alone.name = body;
  alone.path = machine.path;
  alone.reference_C = machine.reference_C;
  alone.materials = machine.materials;
  alone.bodies = {machine.bodies[index]};
  alone.bodies[0].parent = alone.bodies[0].axis = "";
  for (const mesh::SurfaceSpec& surface : machine.surfaces)
    if (surface.body == body) alone.surfaces.push_back(surface);
  const auto copy = [&](const std::string& id, const std::string& of) {
    mesh::SurfaceSpec surface;
    surface.body = body;
    if (alone.surface_index(of) >= 0) surface = alone.surfaces[alone.surface_index(of)];
    surface.id = id;
    alone.surfaces.push_back(surface);
  };
  copy("bench.foot", foot_of(machine, body));
  copy("bench.skin", "");
  alone.surfaces.back().except = {"bench.foot"};
  copy("bench.heated", heated_of(machine, body));
  alone.ambients = {ambient("air", alone.reference_C + air_K), ambient("foundation", alone.reference_C + foundation_K)};
  alone.films = {film("skin", "bench.skin", skin_film, "air"), film("foot", "bench.foot", foot_film, "foundation")};
  mesh::SourceSpec source;
  source.id = "heat";
  source.laws = {{"machine.on", {0.0, 1.0}, {0.0, heat_W}}};
  source.places.resize(1);
  source.places[0].surface = "bench.heated";
  alone.sources = {source};
  return {mesh::build_machine_mesh(alone, {size_factor, cache}), 60.0};
}

void write_plain(const std::filesystem::path& file, const BodyCase& one) {
  const mesh::TetMesh& mesh = one.mesh.bodies[0];
  const mesh::Machine& machine = one.mesh.machine;
  const mesh::Material& m = machine.material(machine.bodies[0].material);
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "{} {} {} {} {} {}\n{}\n", m.conductivity, m.density, m.specific_heat.value, m.young, m.poisson,
                 m.expansion.value, one.step_s);
  fmt::format_to(out, "{}\n", mesh.nodes());
  for (Eigen::Index i = 0; i < mesh.nodes(); ++i)
    fmt::format_to(out, "{} {} {}\n", mesh.points(0, i), mesh.points(1, i), mesh.points(2, i));
  fmt::format_to(out, "{}\n", mesh.elements());
  for (Eigen::Index e = 0; e < mesh.elements(); ++e)
    fmt::format_to(out, "{} {} {} {}\n", mesh.tets(0, e), mesh.tets(1, e), mesh.tets(2, e), mesh.tets(3, e));
  // Triangles with film, its ambient and flux.
  const auto triangles = [&](const char* id, double coefficient, double ambient_K, double power) {
    const int surface = machine.surface_index(id);
    const double flux = power / one.mesh.surface_area(surface);
    for (const int face : one.mesh.surfaces[surface]) {
      fmt::format_to(out, "{} {} {} {} {} {}\n", mesh.faces(0, face), mesh.faces(1, face), mesh.faces(2, face),
                     coefficient, ambient_K, flux);
    }
    return one.mesh.surfaces[surface].size();
  };
  std::size_t count = 0;
  for (const char* id : {"bench.skin", "bench.foot", "bench.heated"})
    count += one.mesh.surfaces[machine.surface_index(id)].size();
  fmt::format_to(out, "{}\n", count);
  triangles("bench.skin", skin_film, air_K, 0.0);
  triangles("bench.foot", foot_film, foundation_K, 0.0);
  triangles("bench.heated", 0.0, 0.0, heat_W);
  for (const Eigen::Index dof : solver::assemble_elastic(mesh, m, machine.bodies[0].id).fixed)
    fmt::format_to(out, "{} ", dof);
  fmt::format_to(out, "\n{}\n", load_nodes);
  for (int i = 0; i < load_nodes; ++i) fmt::format_to(out, "{} ", load_node(mesh.nodes(), i));
  core::write_file(file, std::string_view(text.data(), text.size()));
}

void write_decks(const std::filesystem::path& folder, const BodyCase& one, int steps) {
  const std::string start = deck_mesh(one);
  const mesh::TetMesh& mesh = one.mesh.bodies[0];
  const mesh::Machine& machine = one.mesh.machine;
  core::write_file(folder / "heat_short.inp", start + deck_heat(one, 2));
  core::write_file(folder / "heat_long.inp", start + deck_heat(one, 2 + steps));
  std::string held = "*BOUNDARY\n";
  for (const Eigen::Index dof :
       solver::assemble_elastic(mesh, machine.material(machine.bodies[0].material), machine.bodies[0].id).fixed)
    held += fmt::format("{}, {}, {}\n", dof / 3 + 1, dof % 3 + 1, dof % 3 + 1);
  std::string warm = "*TEMPERATURE\n";
  for (Eigen::Index i = 0; i < mesh.nodes(); ++i)
    warm += fmt::format("{}, {:.9e}\n", i + 1, mesh.points(2, i));  // 1 K/m upwards
  const std::string bend = "*STEP\n*STATIC\n" + warm + "*NODE PRINT, NSET=NALL\nU\n*END STEP\n";
  core::write_file(folder / "bend_short.inp", start + held + bend);
  core::write_file(folder / "bend_long.inp", start + held + bend + bend + bend);
}

}  // namespace thermotwin::bench
