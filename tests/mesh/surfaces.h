// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Cubes as surfaces and as files, whole and spoiled.

#include <array>
#include <sstream>
#include <string>
#include <vector>

#include "mesh/import/import.h"
#include "mesh/surface/surface.h"

namespace samples {

/// The twelve triangles of a box from low to high, outward; part = side (0: -x, 1: +x, 2: -y, ...).
inline thermotwin::mesh::Surface box_surface(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  thermotwin::mesh::Surface s;
  s.points.resize(3, 8);
  for (int i = 0; i < 8; ++i)
    s.points.col(i) << (i & 1 ? high : low).x(), (i & 2 ? high : low).y(), (i & 4 ? high : low).z();
  s.triangles.resize(3, 12);
  s.triangles << 0, 0, 1, 1, 0, 0, 2, 2, 0, 0, 4, 4,  //
      4, 6, 3, 7, 1, 5, 6, 7, 2, 3, 5, 7,             //
      6, 2, 7, 5, 5, 4, 7, 3, 3, 1, 7, 6;
  s.part = {0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5};
  s.part_names = {"x_low", "x_high", "y_low", "y_high", "z_low", "z_high"};
  return s;
}

/// Both surfaces in one.
inline thermotwin::mesh::Surface together(const thermotwin::mesh::Surface& a, const thermotwin::mesh::Surface& b) {
  thermotwin::mesh::Surface s = a;
  s.points.conservativeResize(3, a.points.cols() + b.points.cols());
  s.points.rightCols(b.points.cols()) = b.points;
  s.triangles.conservativeResize(3, a.triangles.cols() + b.triangles.cols());
  s.triangles.rightCols(b.triangles.cols()) = b.triangles.array() + static_cast<int>(a.points.cols());
  s.part.insert(s.part.end(), b.part.begin(), b.part.end());
  return s;
}

inline void turn_over(thermotwin::mesh::Surface& s) { s.triangles.row(1).swap(s.triangles.row(2)); }

/// ASCII STL with one solid a part.
inline std::string stl_text(const thermotwin::mesh::Surface& s) {
  std::ostringstream out;
  out.precision(9);
  for (std::size_t p = 0; p < s.part_names.size(); ++p) {
    out << "solid " << s.part_names[p] << "\n";
    for (Eigen::Index t = 0; t < s.triangles.cols(); ++t) {
      if (s.part[t] != static_cast<int>(p)) continue;
      out << "facet normal 0 0 0\nouter loop\n";
      for (int i = 0; i < 3; ++i) out << "vertex " << s.points.col(s.triangles(i, t)).transpose() << "\n";
      out << "endloop\nendfacet\n";
    }
    out << "endsolid " << s.part_names[p] << "\n";
  }
  return out.str();
}

inline std::string obj_text(const thermotwin::mesh::Surface& s) {
  std::ostringstream out;
  out << "o cube\n";
  for (Eigen::Index i = 0; i < s.points.cols(); ++i) out << "v " << s.points.col(i).transpose() << "\n";
  for (Eigen::Index t = 0; t < s.triangles.cols(); ++t)
    out << "f " << (s.triangles.col(t).array() + 1).transpose() << "\n";
  return out.str();
}

inline std::string ply_text(const thermotwin::mesh::Surface& s) {
  std::ostringstream out;
  out << "ply\nformat ascii 1.0\nelement vertex " << s.points.cols()
      << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << s.triangles.cols()
      << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (Eigen::Index i = 0; i < s.points.cols(); ++i) out << s.points.col(i).transpose() << "\n";
  for (Eigen::Index t = 0; t < s.triangles.cols(); ++t) out << "3 " << s.triangles.col(t).transpose() << "\n";
  return out.str();
}

/// A mesh in Abaqus format; numbers start at 1. The elements are set "Everything".
inline std::string inp_text(const thermotwin::mesh::TetMesh& mesh) {
  std::ostringstream out;
  out.precision(12);
  out << "** a comment\n*Heading\n any text, 1, 2\n*NODE, NSET=Nall\n";
  for (Eigen::Index i = 0; i < mesh.nodes(); ++i)
    out << i + 1 << ", " << mesh.points(0, i) << ", " << mesh.points(1, i) << ", " << mesh.points(2, i) << "\n";
  out << "*Element, type=c3d4, ELSET=Everything\n";
  for (Eigen::Index e = 0; e < mesh.elements(); ++e) {
    out << e + 1;
    for (int i = 0; i < 4; ++i) out << ", " << mesh.tets(i, e) + 1;
    out << "\n";
  }
  return out.str();
}

}  // namespace samples
