// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/export/machine_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base64.h"
#include "core/html_page.h"
#include "core/page_text.h"
#include "core/thread_pool.h"
#include "core/units.h"
#include "core/view_script.h"
#include "solver/elastic/tcp.h"
#include "solver/export/machine_scene_script.h"

namespace thermotwin::solver {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index skin_vertices = 4400;
constexpr std::size_t most_key_axes = 3;

/// Numbers as 16-bit integers, column after column, each column with its own scale.
std::string packed(const MatrixXd& values) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(2 * values.size());
  std::string scales;
  for (Index c = 0; c < values.cols(); ++c) {
    const double largest = values.rows() > 0 ? values.col(c).cwiseAbs().maxCoeff() : 0.0;
    const double scale = std::isfinite(largest) && largest > 0.0 ? largest / 32767.0 : 1.0;
    scales += fmt::format("{}{:.6g}", c > 0 ? "," : "", scale);
    for (const double value : values.col(c)) {
      const long number = std::isfinite(value) ? std::lround(value / scale) : 0;
      core::put_bytes<std::uint16_t>(bytes, static_cast<std::uint16_t>(number));
    }
  }
  return fmt::format("{{\"rows\":{},\"scales\":[{}],\"data\":\"{}\"}}", values.rows(), scales, core::base64(bytes));
}

std::string numbers(const VectorXd& values) {
  std::string text;
  for (const double value : values) text += fmt::format("{}{:.6g}", text.empty() ? "" : ",", value);
  return "[" + text + "]";
}

/// Rotation and place of each body at a pose, twelve numbers a body, row by row.
std::string frames(const mesh::Machine& machine, const mesh::Pose& pose) {
  std::string text;
  for (int b = 0; b < std::ssize(machine.bodies); ++b) {
    const Eigen::Matrix<double, 3, 4> frame = mesh::body_transform(machine, b, pose).matrix().topRows<3>();
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 4; ++k) text += fmt::format("{}{:.6g}", text.empty() ? "" : ",", frame(i, k));
  }
  return "[" + text + "]";
}

std::string poses_json(const MachineScene& scene) {
  std::string text;
  for (std::size_t p = 0; p < scene.poses.size(); ++p) {
    const mesh::Pose& pose = scene.poses[p];
    text +=
        fmt::format("{}{{\"name\":{},\"tool\":{},\"frames\":{},\"weights\":{}}}", p > 0 ? "," : "",
                    core::json_text(mesh::format_pose(scene.machine, pose)), numbers(tcp_position(scene.machine, pose)),
                    frames(scene.machine, pose), numbers(scene.keys.weights.row(p).transpose()));
  }
  return text;
}

std::string loads_json(const MachineScene& scene) {
  std::string text;
  for (std::size_t l = 0; l < scene.loads.size(); ++l) {
    const SceneLoad& load = scene.loads[l];
    text += fmt::format("{}{{\"name\":{},\"hours\":{},\"errors\":{},\"coefficients\":{}}}", l > 0 ? "," : "",
                        core::json_text(load.name), numbers(load.hours), packed(load.errors_um),
                        load.coefficients.cols() > 0 ? packed(load.coefficients) : "null");
  }
  return text;
}

/// 1, 2 or 5 times a power of ten, not above the value.
double round_down(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double factor : {5.0, 2.0})
    if (factor * power <= value) return factor * power;
  return power;
}

/// The factor that makes the largest displacement of all loads a fifteenth of the machine; 0: nothing moves.
double exaggeration(const MachineScene& scene) {
  if (scene.displacement.empty() || scene.skin.vertices() == 0) return 0.0;
  const MatrixXd& field = scene.displacement.front();
  double largest = 0.0;
  for (const SceneLoad& load : scene.loads) {
    if (load.coefficients.cols() == 0) continue;
    for (Index v = 0; v < scene.skin.vertices(); v += 7) {
      const MatrixXd motion = field.middleRows<3>(3 * v) * load.coefficients.topRows(field.cols());
      largest = std::max(largest, motion.colwise().norm().maxCoeff());
    }
  }
  const double extent = (scene.skin.points.rowwise().maxCoeff() - scene.skin.points.rowwise().minCoeff()).maxCoeff();
  return largest > 1e-12 ? round_down(extent / 15.0 / largest) : 0.0;
}

std::string skin_json(const Skin& skin) {
  std::vector<std::uint8_t> triangles, bodies;
  for (const int corner : skin.triangles.reshaped())
    core::put_bytes<std::uint16_t>(triangles, static_cast<std::uint16_t>(corner));
  for (std::size_t b = 0; b + 1 < skin.first.size(); ++b)
    bodies.insert(bodies.end(), skin.first[b + 1] - skin.first[b], static_cast<std::uint8_t>(b));
  return fmt::format("\"points\":{},\"triangles\":\"{}\",\"bodies\":\"{}\"", packed(skin.points.reshaped()),
                     core::base64(triangles), core::base64(bodies));
}

std::size_t first_load(const MachineScene& scene) {
  std::size_t first = 0;
  double largest = -1.0;
  for (std::size_t l = 0; l < scene.loads.size(); ++l) {
    const SceneLoad& load = scene.loads[l];
    if (load.name == scene.first_load) return l;
    const bool fields = load.coefficients.cols() > 0 || scene.temperature.cols() == 0;
    const Index vectors = load.errors_um.size() / 3;
    const double error = vectors > 0 && fields ? load.errors_um.reshaped(3, vectors).colwise().norm().maxCoeff() : 0.0;
    if (error > largest) largest = error, first = l;
  }
  return first;
}

std::string scene_json(const MachineScene& scene) {
  std::string displacement;
  for (const MatrixXd& field : scene.displacement) displacement += (displacement.empty() ? "" : ",") + packed(field);
  return fmt::format(
      "{{\"reference\":{:.4g},\"factor\":{:.4g},\"first\":{},{},\"temperature\":{},\"displacement\":[{}],\n\"poses\":[{"
      "}],\n"
      "\"loads\":[{}]}}",
      scene.machine.reference_C, exaggeration(scene), first_load(scene), skin_json(scene.skin),
      packed(scene.temperature), displacement, poses_json(scene), loads_json(scene));
}

/// Positions that an axis takes in the grid, rising.
std::vector<double> positions_of(const std::vector<mesh::Pose>& grid, Index axis) {
  std::vector<double> positions;
  for (const mesh::Pose& pose : grid) positions.push_back(pose[axis]);
  std::sort(positions.begin(), positions.end());
  positions.erase(std::unique(positions.begin(), positions.end()), positions.end());
  return positions;
}

}  // namespace

KeyPoses key_poses(const mesh::Machine& machine, const std::vector<mesh::Pose>& grid) {
  struct Range {
    Index axis;
    double low, high;
  };
  std::vector<Range> ranges;
  mesh::Pose middle = mesh::home_pose(machine);
  for (const bool linear : {true, false}) {
    for (Index a = 0; a < std::ssize(machine.axes); ++a) {
      if ((machine.axes[a].kind == mesh::AxisKind::linear) != linear) continue;
      const std::vector<double> positions = positions_of(grid, a);
      middle[a] = positions[positions.size() / 2];
      if (positions.size() > 1 && ranges.size() < most_key_axes)
        ranges.push_back({a, positions.front(), positions.back()});
    }
  }
  KeyPoses keys;
  const std::size_t corners = std::size_t{1} << ranges.size();
  keys.weights = MatrixXd::Ones(std::ssize(grid), corners);
  for (std::size_t corner = 0; corner < corners; ++corner) {
    mesh::Pose pose = middle;
    for (std::size_t r = 0; r < ranges.size(); ++r) {
      const Range& range = ranges[r];
      const bool high = (corner >> r & 1U) != 0;
      pose[range.axis] = high ? range.high : range.low;
      for (std::size_t p = 0; p < grid.size(); ++p) {
        const double share = (grid[p][range.axis] - range.low) / (range.high - range.low);
        keys.weights(p, corner) *= high ? share : 1.0 - share;
      }
    }
    keys.poses.push_back(pose);
  }
  return keys;
}

SceneLoad scene_load(const std::string& name, const core::Table& tcp, Index poses, const MatrixXd& coefficients) {
  const Index times = tcp.rows() / std::max<Index>(poses, 1);
  const std::vector<Index> kept = thinned(times, LoadFields::most_times);
  SceneLoad load{name, VectorXd(std::ssize(kept)), coefficients, MatrixXd(3 * poses, std::ssize(kept))};
  const VectorXd time = tcp.column("time_s");
  const VectorXd columns[] = {tcp.column("dx_um"), tcp.column("dy_um"), tcp.column("dz_um")};
  for (std::size_t k = 0; k < kept.size(); ++k) {
    const Index first = kept[k] * poses;
    load.hours[k] = time[first] / core::units::hour;
    for (Index p = 0; p < poses; ++p)
      for (int c = 0; c < 3; ++c) load.errors_um(3 * p + c, k) = columns[c][first + p];
  }
  return load;
}

MachineScene make_scene(const FullModel& full, const MatrixXd& modes) {
  MachineScene scene;
  scene.machine = full.mesh.machine;
  scene.skin = make_skin(full.mesh, skin_vertices);
  scene.poses = mesh::workspace_poses(scene.machine);
  scene.keys = key_poses(scene.machine, scene.poses);
  scene.temperature = modes(scene.skin.nodes, Eigen::all);
  if (std::none_of(scene.machine.bodies.begin(), scene.machine.bodies.end(), [](const auto& b) { return b.elastic; }))
    return scene;
  const Index displaced = std::min(modes.cols(), displaced_modes);
  scene.displacement.assign(scene.keys.poses.size(), MatrixXd(3 * scene.skin.vertices(), displaced));
  core::parallel_for(0, scene.keys.poses.size() * displaced, [&](std::size_t i) {
    const std::size_t key = i / displaced;
    const Index mode = i % displaced;
    const Eigen::Matrix3Xd all = full.elastic.displacement(modes.col(mode), scene.keys.poses[key]);
    const Eigen::Matrix3Xd there = all(Eigen::all, scene.skin.nodes);
    scene.displacement[key].col(mode) = there.reshaped();
  });
  return scene;
}

std::string machine_scene_html(const MachineScene& scene) {
  const std::string controls =
      "<div class=\"controls\"><label>load <select id=\"scene-load\"></select></label><label>pose <select "
      "id=\"scene-pose\"></select></label><label>time <input type=\"range\" id=\"scene-time\" min=\"0\" value=\"0\">"
      "</label><button id=\"scene-play\" type=\"button\">play</button><span "
      "id=\"scene-hour\"></span><label>deformation "
      "<select id=\"scene-factor\"></select></label></div>\n";
  const std::string legend =
      "<div class=\"legend\" id=\"scene-legend\"><span id=\"scene-range\"></span><span><i class=\"pink\"></i>TCP "
      "error, tool against table, at the poses of the workspace; thick: chosen pose; "
      "<span id=\"scene-longest\"></span></span><span>drag turns, wheel zooms</span></div>\n";
  const std::string chart =
      "<div class=\"legend\"><span><i class=\"blue\"></i>X</span><span><i class=\"orange\"></i>Y</span><span><i "
      "class=\"green\"></i>Z</span><span id=\"scene-values\"></span></div><canvas id=\"scene-chart\" width=\"1100\" "
      "height=\"260\"></canvas>\n";
  return core::html_section("The machine", "",
                            controls + legend + "<canvas id=\"machine\" width=\"1100\" height=\"620\"></canvas>\n") +
         core::html_section("TCP error over time at the chosen pose", "a click sets the time", chart) +
         "<script type=\"application/json\" id=\"scene\">" + scene_json(scene) + "</script>\n<script>" +
         core::view_script + machine_scene_script + "</script>\n";
}

}  // namespace thermotwin::solver
