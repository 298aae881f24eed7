// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/elastic/springs.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "core/error.h"
#include "mesh/machine/kinematics.h"
#include "solver/contact/contact.h"
#include "solver/contact/grid.h"
#include "solver/elastic/drives.h"
#include "solver/operation/grid_occupancy.h"
#include "solver/operation/layout.h"

namespace thermotwin::solver {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double negligible = 1e-9;  // of a pad's largest stiffness or area

void add_weighted(Functional& functional, Eigen::Index node, const Vector3d& weight) {
  for (int i = 0; i < 3; ++i)
    if (weight[i] != 0.0) functional.emplace_back(3 * node + i, weight[i]);
}

bool nearly_equal(const Functional& a, const Functional& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i].first != b[i].first || std::abs(a[i].second - b[i].second) > 1e-12) return false;
  return true;
}

/// Mean stiffness per area of a pad, N/m^3, in the slave's home frame.
Matrix3d mean_stiffness(const mesh::TetMesh& slave, const std::vector<int>& faces, const mesh::JointSpec& joint,
                        const mesh::Axis* guided) {
  Matrix3d sum = Matrix3d::Zero();
  double area = 0.0;
  for (int face : faces) {
    const Vector3d n = slave.face_normal(face);
    Matrix3d tangent = Matrix3d::Identity() - n * n.transpose();
    if (guided) {
      const Vector3d free = guided->direction - guided->direction.dot(n) * n;
      if (free.norm() > 1e-6) tangent -= free.normalized() * free.normalized().transpose();
    }
    const double a = slave.face_area(face);
    sum += a * (joint.stiffness_normal.value * n * n.transpose() + joint.stiffness_tangential.value * tangent);
    area += a;
  }
  return sum / area;
}

/// The points of one pad at one grid node.
struct PadContact {
  double area = 0;
  Vector3d slave_point = Vector3d::Zero(), master_point = Vector3d::Zero();
  std::vector<const ContactPoint*> points;
};

/// Area and area-weighted points of each pad. @param points  must outlive the result
std::vector<PadContact> contacts_of_pads(const std::vector<ContactPoint>& points,
                                         const std::unordered_map<int, int>& pad_of_face, std::size_t pads,
                                         const mesh::TetMesh* master) {
  std::vector<PadContact> contacts(pads);
  for (const ContactPoint& point : points) {
    PadContact& contact = contacts[pad_of_face.at(point.slave_face)];
    contact.area += point.area;
    contact.slave_point += point.area * point.position;
    if (master) {
      for (int i = 0; i < 3; ++i) {
        contact.master_point +=
            point.area * point.master_weights[i] * master->points.col(master->faces(i, point.master_face));
      }
    }
    contact.points.push_back(&point);
  }
  return contacts;
}

Functional mean_motion(const mesh::TetMesh& body, const PadContact& contact, bool slave, const Vector3d& direction) {
  Functional functional;
  for (const ContactPoint* point : contact.points) {
    const int face = slave ? point->slave_face : point->master_face;
    const mesh::FaceNodes nodes = mesh::face_nodes(body, face);
    const mesh::FaceValues values =
        mesh::face_shape(body.order(), slave ? point->slave_weights : point->master_weights);
    for (Eigen::Index i = 0; i < nodes.size(); ++i)
      add_weighted(functional, nodes[i], point->area / contact.area * values[i] * direction);
  }
  tidy(functional);
  return functional;
}

}  // namespace

int body_index_of_surface(const mesh::Machine& machine, const std::string& surface) {
  const std::size_t index = machine.surface_index(surface);
  return machine.body_index(machine.surfaces[index].body);
}

int UnitFunctionals::add(int body, Functional functional) {
  auto& list = of_body_[body];
  list.push_back(std::move(functional));
  return std::ssize(list) - 1;
}

SpringSet::SpringSet(const mesh::MachineMesh& mesh, const std::vector<JointGrid>& grids, UnitFunctionals& units) {
  const mesh::Machine& machine = mesh.machine;
  for (std::size_t j = 0; j < machine.joints.size(); ++j) add_joint(mesh, j, grids[j], units);
  for (std::size_t i = 0; i < machine.scales.size(); ++i) {
    if (machine.axes[machine.axis_index(machine.scales[i].axis)].feedback != "screw")
      feedbacks_.push_back(AxisFeedback::of_scale(mesh, i, units));
  }
  for (std::size_t i = 0; i < machine.screws.size(); ++i)
    if (auto screw = AxisFeedback::of_screw(mesh, i, units)) feedbacks_.push_back(*std::move(screw));
  for (const auto& [axis, body] : unheld_axes(machine)) {
    throw core::InputError(machine.path.filename().string() + " axis " + axis,
                           "nothing holds body '" + body + "' along it", what_holds_an_axis);
  }
}

void SpringSet::add_joint(const mesh::MachineMesh& mesh, int index, const JointGrid& grid, UnitFunctionals& units) {
  const mesh::Machine& machine = mesh.machine;
  const mesh::JointSpec& spec = machine.joints[index];
  if (spec.stiffness_normal.value <= 0.0 && spec.stiffness_tangential.value <= 0.0) return;
  Joint joint;
  joint.index = index;
  joint.slave = body_index_of_surface(machine, spec.slave);
  joint.master = spec.master.empty() ? -1 : body_index_of_surface(machine, spec.master);
  const auto elastic = [&](int body) { return machine.bodies[body].elastic; };
  if (!elastic(joint.slave) || (joint.master >= 0 && !elastic(joint.master))) return;
  joint.grid = grid;
  joint.axis = spec.axis.empty() ? -1 : machine.axis_index(spec.axis);
  const mesh::Axis* axis = joint.axis < 0 ? nullptr : &machine.axes[joint.axis];
  joint.rotary = axis && axis->kind == mesh::AxisKind::rotary;
  const mesh::Axis* guided = axis && !joint.rotary && spec.kind == "guide" ? axis : nullptr;
  joint.guide = guided != nullptr;

  const std::unordered_map<int, int> pad_of_face = add_pads(mesh, guided, joint);
  if (joint.master >= 0) {
    const auto& faces = mesh.surfaces[machine.surface_index(spec.master)];
    std::array<Functional, 6> rigid = rigid_motion(mesh.bodies[joint.master], faces, Vector3d::Zero(), spec.master);
    for (std::size_t i = 0; i < 3; ++i) joint.rotation[i] = units.add(joint.master, std::move(rigid[3 + i]));
  }
  const ContactSearch search(mesh, spec);
  for (std::size_t node = 0; node < grid.positions.size(); ++node)
    add_grid_node(mesh, search, pad_of_face, node, joint, units);
  joints_.push_back(std::move(joint));
}

std::unordered_map<int, int> SpringSet::add_pads(const mesh::MachineMesh& mesh, const mesh::Axis* guided,
                                                 Joint& joint) {
  const mesh::JointSpec& spec = mesh.machine.joints[joint.index];
  const auto& slave_faces = mesh.surfaces[mesh.machine.surface_index(spec.slave)];
  const Pads pads = find_pads(mesh, spec);
  std::unordered_map<int, int> pad_of_face;
  std::vector<std::vector<int>> faces_of_pad(pads.count);
  for (std::size_t i = 0; i < slave_faces.size(); ++i) {
    pad_of_face[slave_faces[i]] = pads.of_face[i];
    faces_of_pad[pads.of_face[i]].push_back(slave_faces[i]);
  }
  for (const auto& faces : faces_of_pad) {
    Pad pad;
    const Eigen::SelfAdjointEigenSolver<Matrix3d> principal(
        mean_stiffness(mesh.bodies[joint.slave], faces, spec, guided));
    for (int i = 0; i < 3; ++i) {  // stiffest first
      pad.directions.col(i) = principal.eigenvectors().col(2 - i);
      pad.stiffness[i] = principal.eigenvalues()[2 - i];
      if (pad.stiffness[i] > negligible * pad.stiffness[0]) pad.count = i + 1;
    }
    pad.nodes.resize(joint.grid.positions.size());
    joint.pads.push_back(std::move(pad));
  }
  return pad_of_face;
}

void SpringSet::add_grid_node(const mesh::MachineMesh& mesh, const ContactSearch& search,
                              const std::unordered_map<int, int>& pad_of_face, std::size_t node, Joint& joint,
                              UnitFunctionals& units) {
  const mesh::Machine& machine = mesh.machine;
  const mesh::TetMesh* master = joint.master < 0 ? nullptr : &mesh.bodies[joint.master];
  mesh::Pose pose = mesh::home_pose(machine);
  if (joint.axis >= 0) pose[joint.axis] = joint.grid.positions[node];
  const Eigen::Isometry3d slave_frame = mesh::body_transform(machine, joint.slave, pose);
  const Eigen::Isometry3d master_frame =
      master ? mesh::body_transform(machine, joint.master, pose) : Eigen::Isometry3d::Identity();
  const Eigen::Isometry3d master_from_slave = master_frame.inverse() * slave_frame;
  const std::vector<ContactPoint> points = search.at(slave_frame, master_frame);
  const std::vector<PadContact> contacts = contacts_of_pads(points, pad_of_face, joint.pads.size(), master);
  for (std::size_t p = 0; p < joint.pads.size(); ++p) {
    const PadContact& contact = contacts[p];
    if (!(contact.area > 0.0)) continue;
    Pad& pad = joint.pads[p];
    PadNode& place = pad.nodes[node];
    place.area = contact.area;
    place.slave_point = contact.slave_point / contact.area;
    place.master_point = contact.master_point / contact.area;
    // A pad that lies wholly on its rail has the same functional at all grid nodes.
    const PadNode* before = node > 0 && pad.nodes[node - 1].area > 0.0 ? &pad.nodes[node - 1] : nullptr;
    for (int d = 0; d < pad.count; ++d) {
      Functional motion = mean_motion(mesh.bodies[joint.slave], contact, true, pad.directions.col(d));
      if (before && nearly_equal(units.of(joint.slave)[before->slave[d]], motion))
        place.slave[d] = before->slave[d];
      else
        place.slave[d] = units.add(joint.slave, std::move(motion));
      if (master && !joint.rotary) {
        place.master[d] = units.add(
            joint.master, mean_motion(*master, contact, false, master_from_slave.linear() * pad.directions.col(d)));
      }
    }
    if (master && joint.rotary) {
      for (int d = 0; d < 3; ++d)
        place.master[d] = units.add(joint.master, mean_motion(*master, contact, false, Vector3d::Unit(d)));
    }
  }
}

void SpringSet::append(const Joint& joint, const Pad& pad, const Eigen::VectorXd& hat,
                       const Eigen::Isometry3d& master_from_slave, std::vector<Spring>& springs) const {
  double area = 0.0, largest = 0.0;
  Vector3d slave_point = Vector3d::Zero(), master_point = Vector3d::Zero();
  for (std::size_t n = 0; n < pad.nodes.size(); ++n) {
    const PadNode& node = pad.nodes[n];
    largest = std::max(largest, node.area);
    const double share = hat[n] * node.area;
    if (!(share > 0.0)) continue;
    area += share;
    slave_point += share * node.slave_point;
    master_point += share * node.master_point;
  }
  if (area <= negligible * largest) return;  // off the rail here
  const Vector3d lever = master_from_slave * Vector3d(slave_point / area) - master_point / area;
  for (int d = 0; d < pad.count; ++d) {
    const Vector3d direction = master_from_slave.linear() * pad.directions.col(d);
    Spring spring;
    spring.joint = joint.index;
    spring.flexibility = 1.0 / (pad.stiffness[d] * area);
    for (std::size_t n = 0; n < pad.nodes.size(); ++n) {
      const PadNode& node = pad.nodes[n];
      const double share = hat[n] * node.area / area;
      if (!(share > 0.0)) continue;
      spring.gap.push_back({joint.slave, node.slave[d], share});
      if (joint.master < 0) continue;
      if (joint.rotary)
        for (std::size_t i = 0; i < 3; ++i) spring.gap.push_back({joint.master, node.master[i], -share * direction[i]});
      else
        spring.gap.push_back({joint.master, node.master[d], -share});
    }
    if (joint.master >= 0) {
      const Vector3d couple = lever.cross(direction);
      for (std::size_t i = 0; i < 3; ++i) spring.gap.push_back({joint.master, joint.rotation[i], -couple[i]});
    }
    springs.push_back(std::move(spring));
  }
}

std::vector<Spring> SpringSet::at(const mesh::Machine& machine, const mesh::Pose& pose) const {
  std::vector<Spring> springs;
  for (const Joint& joint : joints_) {
    const double position = joint.grid.axis < 0 ? 0.0 : pose[joint.grid.axis];
    const Eigen::VectorXd hat = joint.grid.positions.size() == 1 ? Eigen::VectorXd::Ones(1).eval()
                                                                 : grid_weights(joint.grid, position, position);
    Eigen::Isometry3d master_from_slave = mesh::body_transform(machine, joint.slave, pose);
    if (joint.master >= 0)
      master_from_slave = mesh::body_transform(machine, joint.master, pose).inverse() * master_from_slave;
    for (const Pad& pad : joint.pads) append(joint, pad, hat, master_from_slave, springs);
  }
  for (const AxisFeedback& feedback : feedbacks_) feedback.append(machine, pose, springs);
  return springs;
}

}  // namespace thermotwin::solver
