// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Volume meshes by Gmsh, whose state is global: every call takes one lock for the whole program.
// Nothing of it reaches stdout. The same input gives the same mesh, bit by bit. Gmsh lies in a module (gmsh_module.h)
// that the first call loads. @throws SolverError if the module is not there: of every function here

#include "mesh/import/import.h"
#include "mesh/import/raw_mesh.h"
#include "mesh/surface/check.h"
#include "mesh/surface/surface.h"

namespace thermotwin::mesh {

/// How the mesher goes about one body. The settings of the first attempt are the usual ones; the later ones are for
/// geometry on which it fails (MesherError).
struct Attempt {
  enum class Patches {
    by_angle,   ///< cut along sharp edges, remeshed
    discs,      ///< cut into discs of limited curvature, remeshed
    as_in_file  ///< the file's triangles are kept
  };
  bool first = true;  ///< warnings about the file itself are given in the first attempt only
  std::string words;  ///< "body ... could only be meshed " + words
  Patches patches = Patches::by_angle;
  bool curvature = true;  ///< finer elements where CAD faces are curved
  int algorithm = 6;      ///< of Gmsh for faces: 6 frontal Delaunay, 5 Delaunay, 1 MeshAdapt
  bool join = true;       ///< CAD solids that touch share their nodes; else each is a piece of its own
  double heal = 0.0;      ///< of the extent: CAD faces and edges smaller than this are removed
};
const std::vector<Attempt>& attempts_on_cad();
const std::vector<Attempt>& attempts_on_surfaces();
/// Of tessellate_cad().
const std::vector<Attempt>& attempts_on_faces();

/// Loads the module now, so that child processes have it.
void load_gmsh();

/// STEP (its own unit counts) or BREP (unit_m counts); several solids get one conformal mesh.
/// Faces without a solid are sewn where their gaps allow. Groups: names of solids and, of a single solid, of faces.
/// @throws MeshError; MesherError where another attempt may succeed
TetMesh mesh_cad(const std::filesystem::path& path, const ImportOptions& options, const Attempt& attempt);

/// Triangles of the element size on all faces of a CAD file, in m; the normals of a solid's faces point outwards.
/// @throws MeshError; MesherError where another attempt may succeed
Surface tessellate_cad(const std::filesystem::path& path, const ImportOptions& options, const Attempt& attempt);

/// Mesh of a closed surface, possibly with cavities: it is cut along edges sharper than 40 deg,
/// the patches are remeshed to the element size, and the volume is filled. No groups.
/// @param surface  one piece, in m, checked
/// @throws MeshError; MesherError where another attempt may succeed
TetMesh mesh_closed_surface(const Surface& surface, const ImportOptions& options, const Attempt& attempt);

/// A Gmsh mesh file (.msh 4.1, 2.2); sets are its physical groups. @throws MeshError
RawMesh read_msh(const std::filesystem::path& path);

}  // namespace thermotwin::mesh
