// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/lattice_mesher.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"
#include "core/progress.h"
#include "mesh/import/import_process.h"
#include "mesh/surface/lattice_fill.h"

namespace thermotwin::mesh {

namespace {

constexpr double tets_of_cube = 12.0;
constexpr double spacing_of_size = 1.2;  // so that a volume gets as many tetrahedra as from the surface mesher
constexpr double refinements[] = {1.0, 0.7, 0.5};
constexpr double largest_volume_error = 0.1;
constexpr double largest_ambiguous = 0.02;  // of the volume inside
constexpr double largest_lattice = 3e8;     // points
constexpr double probing_cubes = 16.0;      // along the extent, to know the volume first

TetMesh body_of(const LatticeFill& fill, const std::string& body) {
  TetMesh mesh;
  mesh.points = fill.points;
  mesh.tets = fill.tets;
  mesh.solids = 1;
  build_boundary(mesh, body);
  return mesh;
}

}  // namespace

TetMesh lattice_mesh(const Surface& surface, const ImportOptions& options) {
  const std::string place = "body '" + options.body + "'";
  const auto volumes = [](const LatticeFill& fill) {
    return fmt::format("{:.4g} of {:.4g} mm^3", 1e9 * fill.volume, 1e9 * fill.inside);
  };
  const double extent = (surface.points.rowwise().maxCoeff() - surface.points.rowwise().minCoeff()).maxCoeff();
  const double inside = fill_by_lattice(surface, extent / probing_cubes).inside;
  LatticeFill fill;
  for (const double refinement : refinements) {
    const double spacing = spacing_of_size * refinement * options.element_size_m;
    const double expected = tets_of_cube * inside / std::pow(spacing, 3);
    if (const double most =
            std::min(options.max_elements, largest_lattice * expected / lattice_points(surface, spacing));
        expected > most) {
      if (fill.tets.cols() > 0) break;
      throw core::MeshError(
          place,
          fmt::format("about {:.2g} tetrahedra with element_size_mm = {:.4g} (after the size factor of --size)",
                      expected, 1e3 * options.element_size_m),
          fmt::format("at most {:.2g}: element_size_mm of {:.3g} or more, or a larger max_elements of the body", most,
                      1e3 * std::cbrt(tets_of_cube * inside / most) / spacing_of_size));
    }
    limit_time_by(std::max(expected, lattice_points(surface, spacing)));
    fill = fill_by_lattice(surface, spacing);
    if (!(fill.ambiguous <= largest_ambiguous * fill.inside)) {
      throw core::MeshError(
          place,
          fmt::format("an open surface: inside and outside cannot be distinguished in {:.4g} mm^3, {:.4g} are inside",
                      1e9 * fill.ambiguous, 1e9 * fill.inside),
          "a surface that encloses a volume; small holes and shells that cut each other may stay");
    }
    if (fill.tets.cols() == 0 || std::abs(fill.volume - fill.inside) > largest_volume_error * fill.inside) continue;
    core::warn(fmt::format("{}: filled with a lattice{}, {}; edges are chamfered by up to an element{}", place,
                           refinement < 1.0 ? fmt::format(" of {:.2g} times the element size", refinement) : "",
                           volumes(fill), fill.crumbs > 0 ? fmt::format("; {} crumbs were dropped", fill.crumbs) : ""));
    return body_of(fill, options.body);
  }
  throw core::MeshError(place, "a lattice that holds " + volumes(fill) + ": walls are thinner than its elements",
                        "a difference below 10 % (a smaller element_size_mm, or a larger max_elements)");
}

}  // namespace thermotwin::mesh
