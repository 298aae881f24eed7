// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/export/scene_file.h"

#include <cstring>
#include <string_view>
#include <system_error>

#include "core/binary.h"
#include "core/error.h"
#include "core/file.h"

namespace thermotwin::solver {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr std::string_view version = "thermotwin scene 1";

void put(core::BinaryWriter& out, const MatrixXd& values) {
  const Eigen::MatrixXf single = values.cast<float>();
  std::string bytes(single.size() * sizeof(float), '\0');
  if (!bytes.empty()) std::memcpy(bytes.data(), single.data(), bytes.size());
  out.count(single.rows());
  out.count(single.cols());
  out.text(bytes);
}

MatrixXd get(core::BinaryReader& in, const std::string& source) {
  const Index rows = in.count(), cols = in.count();
  const std::string bytes = in.text();
  if (rows < 0 || cols < 0 || bytes.size() != rows * cols * sizeof(float))
    throw core::InputError(source, "sizes that disagree", "the file as it was written");
  Eigen::MatrixXf single(rows, cols);
  if (!bytes.empty()) std::memcpy(single.data(), bytes.data(), bytes.size());
  return single.cast<double>();
}

}  // namespace

void write_scene(const std::filesystem::path& path, const MachineScene& scene, const std::string& made_from) {
  core::BinaryWriter out;
  out.text(version);
  out.text(scene.machine.hash);
  out.text(made_from);
  put(out, scene.skin.points);
  put(out, scene.skin.triangles.cast<double>());
  out.count(std::ssize(scene.skin.first));
  for (const Index first : scene.skin.first) out.count(first);
  put(out, scene.temperature);
  out.count(std::ssize(scene.displacement));
  for (const MatrixXd& field : scene.displacement) put(out, field);
  put(out, scene.turn);
  core::write_file(path, out.bytes());
}

std::optional<MachineScene> read_scene(const std::filesystem::path& path, const mesh::Machine& machine,
                                       const std::string& made_from) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return std::nullopt;
  const std::string bytes = core::read_file(path), source = path.string();
  core::BinaryReader in(bytes, source);
  if (in.text() != version || in.text() != machine.hash || in.text() != made_from) return std::nullopt;
  MachineScene scene;
  scene.machine = machine;
  scene.skin.points = get(in, source);
  scene.skin.triangles = get(in, source).cast<int>();
  scene.skin.first.resize(in.count());
  for (Index& first : scene.skin.first) first = in.count();
  scene.temperature = get(in, source);
  scene.displacement.resize(in.count());
  for (MatrixXd& field : scene.displacement) field = get(in, source);
  scene.turn = get(in, source);
  scene.poses = mesh::workspace_poses(machine);
  scene.keys = key_poses(machine, scene.poses);
  return scene;
}

}  // namespace thermotwin::solver
