// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The machine in 3D for the page of a diagnosis: boundary triangles of its bodies, where causes act,
// sensors. Drawn by a few lines of script on a canvas, which a drag turns; nothing is fetched.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "diagnosis/causes/hypothesis.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/judge/diagnosis.h"
#include "mesh/machine_mesh.h"

namespace thermotwin::diagnosis {

struct Scene {
  struct Body {
    std::string id;
    Eigen::Matrix3Xf points;            ///< m, home frame
    Eigen::Matrix3Xi triangles;         ///< outward
    std::vector<unsigned char> marked;  ///< (triangles) number of the cause that acts there, from 1; 0: none
  };
  struct Point {
    std::string label;
    Eigen::Vector3f at;        ///< m
    unsigned char marked = 0;  ///< number of a cause; 0: none
  };
  struct Entry {
    std::string words, colour;  ///< "#e8622c"
  };
  std::vector<Body> bodies;
  std::vector<Point> points;                                         ///< sensors, the tool's point
  std::vector<Entry> legend;                                         ///< what is marked
  std::string unmarked = "no cause is named, so nothing is marked";  ///< in place of a legend without entries

  bool empty() const { return bodies.empty(); }
  Eigen::Index triangles() const;
};

/// @param causes  what is marked, each in its colour: surfaces of sources, films and coolants, the slave's surface of
///   joints, whole bodies, sensors. Where two meet, the first is shown
Scene make_scene(const mesh::MachineMesh& mesh, const std::vector<Parameter>& causes);

/// A section of a page; empty for an empty scene. At most 2 MB: larger meshes lose triangles that are not marked.
std::string scene_html(const Scene& scene);

/// The causes that a scene marks: those named, else those that share, without those of a probability below 0.05.
std::vector<Parameter> marked_causes(const Diagnosis& diagnosis);

}  // namespace thermotwin::diagnosis
