// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/elastic/outputs.h"

#include <algorithm>

#include "core/error.h"
#include "core/toml_place.h"
#include "mesh/machine/kinematics.h"

namespace thermotwin::solver {
namespace {

const std::vector<int>& faces_of(const mesh::MachineMesh& mesh, const std::string& surface) {
  return mesh.surfaces[mesh.machine.surface_index(surface)];
}

int require_elastic(const mesh::Machine& machine, const std::string& body, const std::string& key) {
  const int index = machine.body_index(body);
  if (!machine.bodies[index].elastic) {
    throw core::InputError(core::toml_place(machine.text, machine.path.string(), "tcp", key),
                           "body '" + body + "' with elastic = false",
                           "an elastic body; or no [tcp], for mesh, simulate and export only");
  }
  return index;
}

/// Triangles of the master surfaces of all bearings of the axis that sit on the carrier.
std::vector<int> seat_faces(const mesh::MachineMesh& mesh, const TableFrames& frames, std::string& name) {
  const mesh::Machine& machine = mesh.machine;
  const std::string& axis = machine.axes[frames.axis].id;
  std::vector<int> faces;
  for (const mesh::JointSpec& joint : machine.joints) {
    if (joint.kind != "bearing" || joint.axis != axis || joint.master.empty()) continue;
    if (body_index_of_surface(machine, joint.master) != frames.carrier) continue;
    const auto& more = faces_of(mesh, joint.master);
    faces.insert(faces.end(), more.begin(), more.end());
    name = joint.master;
  }
  if (faces.empty()) {
    throw core::InputError(machine.path.filename().string() + " axis " + axis,
                           "no bearing between the table and body '" + machine.bodies[frames.carrier].id + "'",
                           "a joint of kind \"bearing\" with this axis");
  }
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  return faces;
}

}  // namespace

TableFrames table_frames(const mesh::Machine& machine) {
  TableFrames frames;
  frames.table = machine.body_index(machine.tcp.table_body);
  frames.carrier = frames.table;
  int body = frames.table;
  while (machine.bodies[body].axis.empty() && !machine.bodies[body].parent.empty())
    body = machine.body_index(machine.bodies[body].parent);
  const mesh::BodySpec& moved = machine.bodies[body];
  if (moved.axis.empty() || moved.parent.empty()) return frames;
  const int axis = machine.axis_index(moved.axis);
  if (machine.axes[axis].kind != mesh::AxisKind::rotary) return frames;
  frames.axis = axis;
  frames.carrier = machine.body_index(moved.parent);
  return frames;
}

std::pair<Eigen::Vector3d, Eigen::Vector3d> growth_axis(const mesh::Machine& machine) {
  const TableFrames frames = table_frames(machine);
  if (frames.axis < 0) return {machine.tcp.table_point, Eigen::Vector3d::UnitZ()};
  const mesh::Axis& axis = machine.axes[frames.axis];
  return {axis.origin, axis.direction};
}

TcpOutputs::TcpOutputs(const mesh::MachineMesh& mesh, UnitFunctionals& units) {
  const mesh::Machine& machine = mesh.machine;
  const mesh::TcpSpec& tcp = machine.tcp;
  frames_ = table_frames(machine);
  table_radius_ = tcp.table_radius;
  tool_ = require_elastic(machine, tcp.tool_body, "tool_body");
  require_elastic(machine, tcp.table_body, "table_body");
  const auto add = [&](int body, const std::vector<int>& faces, const Eigen::Vector3d& point,
                       const std::string& surface) {
    std::array<int, 6> added{};
    auto motion = rigid_motion(mesh.bodies[body], faces, point, surface);
    for (std::size_t i = 0; i < 6; ++i) added[i] = units.add(body, std::move(motion[i]));
    return added;
  };
  tool_units_ = add(tool_, faces_of(mesh, tcp.tool_surface), tcp.tool_point, tcp.tool_surface);
  table_units_ = add(frames_.table, faces_of(mesh, tcp.table_surface), tcp.table_point, tcp.table_surface);
  const auto [origin, direction] = growth_axis(machine);
  growth_unit_ = units.add(
      frames_.table, radial_growth(mesh.bodies[frames_.table], faces_of(mesh, tcp.table_surface), origin, direction));
  if (frames_.axis >= 0) {
    const std::string& carrier = machine.bodies[frames_.carrier].id;
    require_elastic(machine, carrier, "table_body");
    std::string seat;
    const std::vector<int> faces = seat_faces(mesh, frames_, seat);
    seat_units_ = add(frames_.carrier, faces, tcp.table_point, seat);
  }
}

std::array<Combination, 19> TcpOutputs::combinations() const {
  std::array<Combination, 19> outputs;
  for (std::size_t i = 0; i < 6; ++i) {
    outputs[i] = {{tool_, tool_units_[i], 1.0}};
    if (frames_.axis < 0) {
      outputs[6 + i] = {{frames_.table, table_units_[i], 1.0}};
    } else {
      outputs[6 + i] = {{frames_.carrier, seat_units_[i], 1.0}};
      outputs[12 + i] = {{frames_.table, table_units_[i], 1.0}, {frames_.carrier, seat_units_[i], -1.0}};
    }
  }
  outputs[18] = {{frames_.table, growth_unit_, table_radius_}};
  return outputs;
}

mesh::Pose TcpOutputs::table_at_zero(const mesh::Pose& pose) const {
  mesh::Pose zero = pose;
  if (frames_.axis >= 0) zero[frames_.axis] = 0.0;
  return zero;
}

}  // namespace thermotwin::solver
