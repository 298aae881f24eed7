// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/lattice_mesher.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

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
constexpr double largest_lattice = 1e8;     // points
constexpr double probing_cubes = 32.0;      // along the extent, to know the volume first

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
  const double inside = volume_inside(surface, extent / probing_cubes);
  LatticeFill fill;
  for (const double refinement : refinements) {
    const double spacing = spacing_of_size * refinement * options.element_size_m;
    const double expected = tets_of_cube * inside / std::pow(spacing, 3);
    const double points = lattice_points(surface, spacing);
    if (expected > options.max_elements || points > largest_lattice) {
      if (fill.tets.cols() > 0) break;
      const double fits = std::max(std::cbrt(expected / options.max_elements), std::cbrt(points / largest_lattice));
      throw core::MeshError(
          place,
          fmt::format(
              "about {:.2g} tetrahedra, cut from {:.2g} lattice points, with element_size_mm = {:.4g} (after the "
              "size factor of --size)",
              expected, points, 1e3 * options.element_size_m),
          fmt::format("at most max_elements = {:.2g} and {:.2g} points: element_size_mm of {:.3g} or more",
                      options.max_elements, largest_lattice, 1e3 * fits * options.element_size_m));
    }
    limit_time_by(std::max(expected, points));
    fill = fill_by_lattice(surface, spacing);
    if (fill.inside == 0.0 && refinement == refinements[std::size(refinements) - 1])
      throw core::MeshError(place, "a surface that encloses no volume", "the surface of a solid");
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
