// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/import.h"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>

#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "core/range.h"
#include "core/text.h"
#include "mesh/body/triangle_tree.h"
#include "mesh/import/assimp_reader.h"
#include "mesh/import/gmsh_mesher.h"
#include "mesh/import/import_process.h"
#include "mesh/import/inp_reader.h"
#include "mesh/import/lattice_mesher.h"
#include "mesh/import/raw_mesh.h"
#include "mesh/import/vtk_grid.h"
#include "mesh/import/vtk_mesh_io.h"
#include "mesh/surface/check.h"
#include "mesh/surface/healing.h"
#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

namespace {

/// What a user can do about a surface that cannot be meshed as it is.
constexpr const char* way_out = " (or key mesher = \"lattice\" of the body, which chamfers edges)";

std::string extension(const std::filesystem::path& path) { return core::lower(path.extension().string()); }

bool is_one_of(const std::string& word, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(), [&](const char* w) { return word == w; });
}

TetMesh merged(const std::vector<TetMesh>& meshes, const std::string& body) {
  TetMesh all;
  int nodes = 0, elements = 0;
  for (const TetMesh& mesh : meshes) nodes += mesh.nodes(), elements += mesh.elements();
  all.points.resize(3, nodes);
  all.tets.resize(4, elements);
  nodes = elements = 0;
  for (const TetMesh& mesh : meshes) {
    all.points.middleCols(nodes, mesh.nodes()) = mesh.points;
    all.tets.middleCols(elements, mesh.elements()) = mesh.tets.array() + nodes;
    nodes += mesh.nodes(), elements += mesh.elements();
  }
  build_boundary(all, body);
  return all;
}

/// The remeshed faces take the name of the part that they lie on: of the nearest triangle of the
/// file that looks the same way.
void name_parts(TetMesh& mesh, const Surface& surface) {
  if (surface.part_names.size() == 1) {
    if (surface.part_names[0].empty()) return;
    auto& all = mesh.groups[surface.part_names[0]];
    for (int f = 0; f < mesh.face_count(); ++f) all.push_back(f);
    return;
  }
  // One tree a part: the distance to each part tells the nearest even where parts meet.
  struct Named {
    Eigen::Matrix3Xi triangles;
    std::unique_ptr<TriangleTree> tree;
  };
  std::vector<Named> named(surface.part_names.size());
  for (int p = 0; p < std::ssize(named); ++p) {
    const auto count = std::count(surface.part.begin(), surface.part.end(), p);
    named[p].triangles.resize(3, count);
    Eigen::Index next = 0;
    for (std::size_t t = 0; t < surface.part.size(); ++t)
      if (surface.part[t] == p) named[p].triangles.col(next++) = surface.triangles.col(t);
    named[p].tree = std::make_unique<TriangleTree>(surface.points, named[p].triangles);
  }
  for (int f = 0; f < mesh.face_count(); ++f) {
    const Eigen::Vector3d centre = mesh.face_centre(f), normal = mesh.face_normal(f);
    double best = std::numeric_limits<double>::infinity();
    std::size_t owner = 0;
    for (std::size_t p = 0; p < named.size(); ++p) {
      const TriangleTree::Nearest near = named[p].tree->nearest(centre);
      if (near.triangle < 0) continue;
      const Eigen::Vector3i corner = named[p].triangles.col(near.triangle);
      const Eigen::Vector3d a = surface.points.col(corner[0]), b = surface.points.col(corner[1]),
                            c = surface.points.col(corner[2]);
      const double facing = (b - a).cross(c - a).normalized().dot(normal);
      const double cost = near.distance + (facing > 0.5 ? 0.0 : 0.1 * (a - b).norm());
      if (cost < best) best = cost, owner = p;
    }
    mesh.groups[surface.part_names[owner]].push_back(f);
  }
}

Surface read_repaired(const std::filesystem::path& path, const ImportOptions& options, bool warn) {
  options.validate();
  Surface surface = read_triangles(path, options.body);
  surface.points *= options.unit_m;
  if (!surface.points.allFinite())
    throw core::MeshError("body '" + options.body + "'", "a corner with a coordinate that is not a number",
                          "finite coordinates");
  if (const int dropped = weld(surface); dropped > 0 && warn)
    core::warn(fmt::format("body '{}': {} triangles without area were dropped", options.body, dropped));
  if (const Healing healed = heal(surface); healed.any() && warn)
    core::warn(fmt::format("body '{}': the surface was repaired: {}", options.body, healed.brief()));
  return surface;
}

TetMesh mesh_by_lattice(const std::filesystem::path& path, const ImportOptions& options, bool cad,
                        const Attempt& attempt) {
  const Surface surface = cad ? tessellate_cad(path, options, attempt) : read_repaired(path, options, true);
  check_extent(surface.points, options.body, path.string());
  TetMesh mesh = lattice_mesh(surface, options);
  if (!cad) name_parts(mesh, surface);
  return mesh;
}

TetMesh mesh_surface_file(const std::filesystem::path& path, const ImportOptions& options, const Attempt& attempt) {
  const Surface surface = read_repaired(path, options, attempt.first);
  check_extent(surface.points, options.body, path.string());
  try {
    check_surface(surface, options.body, path.string());
  } catch (const core::MeshError& error) {  // it names the body: the file comes after that
    std::string text = error.what();
    if (const std::string body = "body '" + options.body + "': "; text.starts_with(body) && !path.empty())
      text.insert(body.size(), path.string() + ": ");
    throw core::MeshError(text + way_out);
  }
  std::vector<TetMesh> meshes;
  const double expected = enclosed_volume(surface);
  for (const Surface& piece : pieces(surface, options.body))
    meshes.push_back(mesh_closed_surface(piece, options, attempt));
  TetMesh mesh = meshes.size() == 1 ? std::move(meshes.front()) : merged(meshes, options.body);
  mesh.solids = meshes.size();
  // A patch that was parametrised wrongly, or a cavity that was filled, shows in the volume.
  if (const double found = mesh.total_volume(); std::abs(found - expected) > 0.1 * expected) {
    throw MesherError("body '" + options.body + "'",
                      fmt::format("the mesh has a volume of {:.4g} mm^3, the surface encloses {:.4g} mm^3", 1e9 * found,
                                  1e9 * expected),
                      "a difference below 10 % (try a smaller element_size_mm)");
  }
  name_parts(mesh, surface);
  return mesh;
}

}  // namespace

void ImportOptions::validate() const {
  const std::string of = "body '" + body + "': ";
  core::require_within(of + "unit (unit_m)", unit_m, core::positive);
  core::require_within(of + "element size (element_size_m)", element_size_m, core::positive);
  core::require_within(of + "smallest element size (min_element_size_m)", min_element_size_m, core::non_negative);
  core::require_within(of + "elements on a full circle (elements_per_turn)", elements_per_turn, {1.0, 1e6});
  core::require_within(of + "largest mesh (max_elements)", max_elements, core::positive);
}

TetMesh read_tet_mesh(const std::filesystem::path& path, const ImportOptions& options) {
  options.validate();
  const std::string type = extension(path);
  if (type == ".msh") return finish(read_msh(path), options);
  if (type == ".vtu") return finish(read_vtu(path), options);
  if (type == ".inp") return finish(parse_inp(core::read_file(path), path.string()), options);
  throw core::InputError("body '" + options.body + "'", "'" + path.string() + "'", "a mesh file: .msh, .vtu, .inp");
}

namespace {

bool is_cad(const std::string& type) { return is_one_of(type, {".step", ".stp", ".iges", ".igs", ".brep"}); }
bool is_surface(const std::string& type) { return is_one_of(type, {".stl", ".obj", ".ply", ".3mf", ".gltf", ".glb"}); }

TetMesh import_here(const std::filesystem::path& path, const ImportOptions& options, const Attempt& attempt) {
  const std::string type = extension(path);
  if (options.lattice && (is_cad(type) || is_surface(type)))
    return mesh_by_lattice(path, options, is_cad(type), attempt);
  if (is_cad(type)) return mesh_cad(path, options, attempt);
  if (is_surface(type)) return mesh_surface_file(path, options, attempt);
  if (is_one_of(type, {".msh", ".vtu", ".inp"})) {
    if (options.lattice)
      throw core::InputError("body '" + options.body + "': " + path.string(), "mesher = \"lattice\" for a mesh",
                             "CAD or a surface; a mesh is kept as it is");
    return read_tet_mesh(path, options);
  }
  throw core::InputError(
      "body '" + options.body + "'", "'" + path.string() + "'",
      "a file of type .step, .stp, .iges, .igs, .brep, .stl, .obj, .ply, .3mf, .gltf, .glb, .msh, .vtu, .inp");
}

}  // namespace

TetMesh import_body(const std::filesystem::path& path, const ImportOptions& options) {
  options.validate();
  const std::string type = extension(path), place = "body '" + options.body + "': " + path.string();
  const std::vector<Attempt> once(1);
  const std::vector<Attempt>& attempts = options.lattice && is_cad(type) ? attempts_on_faces()
                                         : options.lattice               ? once
                                         : is_cad(type)                  ? attempts_on_cad()
                                         : is_surface(type)              ? attempts_on_surfaces()
                                                                         : once;
  if (is_cad(type) || type == ".msh" || (is_surface(type) && !options.lattice)) load_gmsh();
  if (is_surface(type)) load_assimp();
  if (type == ".vtu") load_vtk();
  std::optional<MesherError> first;  // the one that is told if no attempt succeeds
  for (const Attempt& attempt : attempts) {
    try {
      TetMesh mesh = mesh_in_child(place, {}, [&] { return import_here(path, options, attempt); });
      if (!attempt.first) core::warn(fmt::format("body '{}': it could only be meshed {}", options.body, attempt.words));
      return mesh;
    } catch (const MesherError& error) {
      if (!first) first = error;
    }
  }
  throw MesherError(first->what() + std::string(way_out));
}

}  // namespace thermotwin::mesh
