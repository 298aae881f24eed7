// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/gmsh_mesher.h"

#include <Eigen/Core>
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/file.h"
#include "core/module.h"
#include "core/progress.h"
#include "core/text.h"
#include "mesh/import/gmsh_module.h"
#include "mesh/import/import_process.h"
#include "mesh/surface/disc_patches.h"

namespace thermotwin::mesh {

namespace {

constexpr double largest_volume_error = 0.2;
constexpr double sliver = 0.02;  ///< quality below which other attempts are made: that of the warning of poor elements

const GmshModule& gmsh_module() {
  static const GmshModule& module =
      core::module_table<GmshModule>("libthermotwin_gmsh.so", "thermotwin_gmsh", "mesher");
  return module;
}

/// Tetrahedra in a volume: an upper bound for blocks of three elements across and more. Gmsh's Delaunay meshes of
/// blocks have 4.6 to 5.3 a cube of the element size from 5 elements across on, up to 6.8 with 3. Thin walls and small
/// radii give more.
void require_affordable(double volume, const ImportOptions& options, const std::string& place) {
  constexpr double per_cube = 7.0;
  const double size = options.element_size_m, expected = per_cube * volume / (size * size * size);
  if (expected <= options.max_elements) return limit_time_by(expected);
  throw core::MeshError(
      place,
      fmt::format("about {:.2g} tetrahedra with element_size_mm = {:.4g} (after the size factor of --size)", expected,
                  1e3 * size),
      fmt::format(
          "at most max_elements = {:.2g}: element_size_mm of {:.3g} or more, or a larger max_elements of the body",
          options.max_elements, 1e3 * std::cbrt(per_cube * volume / options.max_elements)));
}

/// A fault of the mesh that the mesher made is the mesher's.
TetMesh finish_meshed(const RawMesh& raw, const ImportOptions& options, double unit) {
  ImportOptions as_meshed = options;
  as_meshed.unit_m = unit;
  try {
    return finish(raw, as_meshed);
  } catch (const core::MeshError& error) {
    throw MesherError("body '" + options.body + "'",
                      std::string("the mesher returned an unusable mesh (") + error.what() + ")",
                      "another element_size_mm, or simpler geometry");
  }
}

std::string place_of(const std::filesystem::path& path, const ImportOptions& options) {
  return "body '" + options.body + "': " + path.string();
}

/// @param path, place, options, attempt  have to outlive the job
GmshJob job_of(const std::filesystem::path& path, const std::string& place, const ImportOptions& options,
               const Attempt& attempt, double unit_m) {
  const std::string type = core::lower(path.extension().string());
  return {path,
          place,
          options,
          attempt,
          unit_m,
          type == ".iges" || type == ".igs",
          core::warn,
          [&](const Eigen::Matrix3Xd& ends) { check_extent(ends, options.body, path.string()); },
          [&](double volume) { require_affordable(volume, options, place); }};
}

/// The mesh of an attempt. Where it has a sliver that no optimisation removes, faces meshed by another algorithm often
/// avoid it: the best is kept. A mesh without one is never made again.
TetMesh best_shaped(const Attempt& attempt, const std::function<TetMesh(const Attempt&)>& make) {
  TetMesh best = make(attempt);
  constexpr int delaunay = 5, mesh_adapt = 1;
  for (const int algorithm : {delaunay, mesh_adapt}) {
    const double quality_of_best = quality(best).minimum;
    if (quality_of_best >= sliver || attempt.patches == Attempt::Patches::as_in_file) break;
    Attempt other = attempt;
    other.first = false;  // its warnings are given
    other.algorithm = algorithm;
    try {
      TetMesh found = make(other);
      if (quality(found).minimum > quality_of_best) best = std::move(found);
    } catch (const core::MeshError&) {  // the first mesh stays
    }
  }
  return best;
}

/// STEP and IGES state their unit.
double unit_of(const std::filesystem::path& path, const ImportOptions& options) {
  return core::lower(path.extension().string()) == ".brep" ? options.unit_m : 1e-3;
}

}  // namespace

void load_gmsh() { gmsh_module(); }

const std::vector<Attempt>& attempts_on_cad() {
  static const std::vector<Attempt> list = [] {
    std::vector<Attempt> all(4);
    for (auto later = all.begin() + 1; later != all.end(); ++later) later->first = false;
    all[1].words = "without finer elements at curved faces";
    all[1].curvature = false;
    all[1].algorithm = 1;
    all[2].words = "by leaving its solids unconnected where they touch (no heat passes between them)";
    all[2].join = false;
    all[3].words = "after removing edges and faces below 1e-5 of the extent";
    all[3].heal = 1e-5;
    return all;
  }();
  return list;
}

const std::vector<Attempt>& attempts_on_surfaces() {
  static const std::vector<Attempt> list = [] {
    std::vector<Attempt> all(3);
    for (auto later = all.begin() + 1; later != all.end(); ++later) later->first = false;
    all[1].words =
        "by cutting its surface into small discs (elements along the cuts may be smaller; this does no harm)";
    all[1].patches = Attempt::Patches::discs;
    all[2].words = "by keeping the triangles of its file, whose shape limits the quality";
    all[2].patches = Attempt::Patches::as_in_file;
    return all;
  }();
  return list;
}

const std::vector<Attempt>& attempts_on_faces() {
  static const std::vector<Attempt> list = [] {
    std::vector<Attempt> all(4);
    for (auto later = all.begin() + 1; later != all.end(); ++later) {
      later->first = false;
      later->curvature = false;
      later->words = "from faces meshed without finer elements where they are curved";
    }
    all[2].algorithm = 5;
    all[3].algorithm = 1;
    return all;
  }();
  return list;
}

TetMesh mesh_cad(const std::filesystem::path& path, const ImportOptions& options, const Attempt& attempt) {
  const std::string place = place_of(path, options);
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored))
    throw core::InputError(place, "no such file", "a readable STEP, IGES or BREP file");
  const double unit = unit_of(path, options);
  return best_shaped(attempt, [&](const Attempt& one) {
    double volume = 0.0;
    const RawMesh raw = gmsh_module().mesh_cad(job_of(path, place, options, one, unit), volume);
    TetMesh mesh = finish_meshed(raw, options, unit);
    // Chords of 8 elements on a turn lose a tenth of a round bar; coarser ones more.
    if (const double found = mesh.total_volume(); std::abs(found - volume) > largest_volume_error * volume) {
      throw MesherError(
          place,
          fmt::format("the mesh has a volume of {:.4g} mm^3, the solid one of {:.4g} mm^3", 1e9 * found, 1e9 * volume),
          fmt::format("a difference below {:.0f} % (try a smaller element_size_mm)", 100.0 * largest_volume_error));
    }
    return mesh;
  });
}

Surface tessellate_cad(const std::filesystem::path& path, const ImportOptions& options, const Attempt& attempt) {
  const std::string place = place_of(path, options);
  return gmsh_module().tessellate_cad(job_of(path, place, options, attempt, unit_of(path, options)));
}

TetMesh mesh_closed_surface(const Surface& surface, const ImportOptions& options, const Attempt& attempt) {
  const std::string place = "body '" + options.body + "'";
  const std::filesystem::path no_file;
  constexpr double unit = 1e-3;
  require_affordable(enclosed_volume(surface), options, place);
  std::vector<int> patch(surface.triangles.cols(), 0);
  if (attempt.patches == Attempt::Patches::discs) patch = disc_patches(surface);
  return best_shaped(attempt, [&](const Attempt& one) {
    return finish_meshed(gmsh_module().mesh_surface(job_of(no_file, place, options, one, unit), surface, patch),
                         options, unit);
  });
}

RawMesh read_msh(const std::filesystem::path& path) {
  // Gmsh would run a script under this name: only mesh files may pass.
  const std::string start = core::read_file(path).substr(0, 4096);
  if (start.find("$MeshFormat") == std::string::npos)
    throw core::MeshError(path.string(), "no $MeshFormat section", "a Gmsh mesh file, version 4.1 or 2.2");
  return gmsh_module().read_msh(path);
}

}  // namespace thermotwin::mesh
