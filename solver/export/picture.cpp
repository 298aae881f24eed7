// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/export/picture.h"

#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <tuple>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/file.h"
#include "core/module.h"
#include "mesh/body/shape.h"
#include "mesh/machine/kinematics.h"
#include "solver/export/vtk_picture_module.h"

namespace thermotwin::solver {
namespace {

constexpr double smallest_span_K = 1.0;  // of the colour map: an even temperature shows one colour

/// Skin of all bodies at the pose, moved by the exaggerated displacement.
void add_deformed_skin(const mesh::MachineMesh& mesh, const mesh::Pose& pose, const Eigen::VectorXd& temperature_C,
                       const Eigen::Matrix3Xd& displacement, double exaggeration, PictureScene& scene) {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3i> triangles;
  std::vector<float> temperature;
  std::vector<int> place(mesh.nodes(), -1);
  for (std::size_t b = 0; b < mesh.bodies.size(); ++b) {
    const mesh::TetMesh& body = mesh.bodies[b];
    const Eigen::Isometry3d frame = mesh::body_transform(mesh.machine, b, pose);
    for (Eigen::Index face = 0; face < body.face_count(); ++face) {
      const mesh::FaceNodes nodes = mesh::face_nodes(body, face);
      int at_node[6] = {};
      for (Eigen::Index i = 0; i < nodes.size(); ++i) {
        const Eigen::Index node = mesh.first_node[b] + nodes[i];
        int& at = place[node];
        if (at < 0) {
          at = std::ssize(points);
          points.push_back(frame * Eigen::Vector3d(body.points.col(nodes[i]) + exaggeration * displacement.col(node)));
          temperature.push_back(static_cast<float>(temperature_C[node]));
        }
        at_node[i] = at;
      }
      // A quadratic triangle is drawn as four.
      static constexpr int whole[3] = {0, 1, 2}, quarters[4][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}};
      const bool quadratic = nodes.size() == 6;
      for (int part = 0; part < (quadratic ? 4 : 1); ++part) {
        const int* corner = quadratic ? quarters[part] : whole;
        triangles.emplace_back(at_node[corner[0]], at_node[corner[1]], at_node[corner[2]]);
      }
    }
  }
  scene.points = Eigen::Map<const Eigen::Matrix3Xd>(points.front().data(), 3, std::ssize(points));
  scene.triangles = Eigen::Map<const Eigen::Matrix3Xi>(triangles.front().data(), 3, std::ssize(triangles));
  scene.temperature_C = Eigen::Map<const Eigen::VectorXf>(temperature.data(), std::ssize(temperature));
}

/// The colour map's ends for these temperatures.
std::pair<double, double> colour_range(const Eigen::Ref<const Eigen::VectorXd>& temperature_C) {
  double low = temperature_C.minCoeff();
  double high = temperature_C.maxCoeff();
  if (const double missing = smallest_span_K - (high - low); missing > 0.0) low -= 0.5 * missing, high += 0.5 * missing;
  return {low, high};
}

}  // namespace

bool has_display() {
  const char* display = std::getenv("DISPLAY");
  return display != nullptr && *display != '\0';
}

void write_picture(const std::filesystem::path& png, const mesh::MachineMesh& mesh, const mesh::Pose& pose,
                   const Eigen::VectorXd& temperature_C, const Eigen::Matrix3Xd& displacement, double exaggeration,
                   const std::string& title) {
  // VTK ends the program where it cannot open a display.
  if (!has_display()) throw core::SolverError("no display to draw pictures on; run under: xvfb-run -a");
  static const auto draw = reinterpret_cast<DrawPicture>(
      core::module_function("libthermotwin_picture.so", "thermotwin_draw", "picture", "install the program again"));
  PictureScene scene;
  add_deformed_skin(mesh, pose, temperature_C, displacement, exaggeration, scene);
  std::tie(scene.low_C, scene.high_C) = colour_range(temperature_C.head(mesh.nodes()));
  scene.title = title;
  scene.note = fmt::format("{}   displacement x {:g}", mesh::format_pose(mesh.machine, pose), exaggeration);
  std::string bytes;
  draw(scene, bytes);
  if (bytes.empty()) throw core::SolverError(png.string() + ": VTK could not make the picture (out of memory)");
  core::write_file(png, bytes);
}

}  // namespace thermotwin::solver
