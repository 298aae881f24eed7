// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/joints.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/progress.h"
#include "core/thread_pool.h"
#include "mesh/machine/kinematics.h"
#include "solver/contact/contact.h"
#include "solver/contact/grid.h"
#include "solver/operation/layout.h"
#include "solver/thermal/surfaces.h"

namespace thermotwin::solver::assembly {

using Eigen::Index;
using mesh::MachineMesh;

namespace {

/// Sums over points of contact that share their nodes: they are added up before they take memory.
class SideBlock {
public:
  using Values = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;

  SideBlock(const MachineMesh& mesh, int body, int face)
      : body_(mesh.bodies[body]),
        nodes_(mesh::face_nodes(body_, face).array() + static_cast<int>(mesh.first_node[body])),
        mass_(Values::Zero(nodes_.size(), nodes_.size())),
        load_(mesh::FaceValues::Zero(nodes_.size())) {}

  const mesh::FaceNodes& nodes() const { return nodes_; }
  mesh::FaceValues shape(const Eigen::Vector3d& at) const { return mesh::face_shape(body_.order(), at); }
  void add(const mesh::FaceValues& values, double area) {
    mass_ += area * values * values.transpose();
    load_ += area * values;
  }
  void put(Triplets& triplets, SparseColumn& load) const {
    for (Index i = 0; i < nodes_.size(); ++i) {
      load.emplace_back(nodes_[i], load_[i]);
      for (Index j = 0; j < nodes_.size(); ++j) triplets.emplace_back(nodes_[i], nodes_[j], mass_(i, j));
    }
  }

private:
  const mesh::TetMesh& body_;
  mesh::FaceNodes nodes_;
  Values mass_;
  mesh::FaceValues load_;
};

JointTerm joint_term(const MachineMesh& mesh, const mesh::JointSpec& joint, const ContactSearch& search,
                     double position, Index size) {
  const mesh::Machine& machine = mesh.machine;
  mesh::Pose pose = mesh::home_pose(machine);
  if (!joint.axis.empty()) pose[machine.axis_index(joint.axis)] = position;
  const auto body_of = [&](const std::string& surface) {
    return machine.body_index(machine.surfaces[machine.surface_index(surface)].body);
  };
  const int slave = body_of(joint.slave), master = body_of(joint.master);
  const std::vector<ContactPoint> contact =
      search.at(mesh::body_transform(machine, slave, pose), mesh::body_transform(machine, master, pose));
  JointTerm term;
  Triplets triplets;
  for (std::size_t i = 0; i < contact.size();) {
    SideBlock of_slave(mesh, slave, contact[i].slave_face);
    for (const int slave_face = contact[i].slave_face; i < contact.size() && contact[i].slave_face == slave_face;) {
      const int master_face = contact[i].master_face;
      SideBlock of_master(mesh, master, master_face);
      SideBlock::Values mixed = SideBlock::Values::Zero(of_slave.nodes().size(), of_master.nodes().size());
      for (; i < contact.size() && contact[i].slave_face == slave_face && contact[i].master_face == master_face; ++i) {
        const double area = contact[i].area;
        const mesh::FaceValues s = of_slave.shape(contact[i].slave_weights),
                               m = of_master.shape(contact[i].master_weights);
        of_slave.add(s, area);
        of_master.add(m, area);
        mixed += area * s * m.transpose();
        term.area += area;
      }
      of_master.put(triplets, term.master_load);
      for (Index row = 0; row < mixed.rows(); ++row) {
        for (Index column = 0; column < mixed.cols(); ++column) {
          triplets.emplace_back(of_slave.nodes()[row], of_master.nodes()[column], -mixed(row, column));
          triplets.emplace_back(of_master.nodes()[column], of_slave.nodes()[row], -mixed(row, column));
        }
      }
    }
    of_slave.put(triplets, term.slave_load);
  }
  term.matrix = from_triplets(size, size, triplets);
  return term;
}

/// The ground touches the whole surface, as a film does.
JointTerm ground_term(const MachineMesh& mesh, const mesh::JointSpec& joint, ElementRules rules, Index size) {
  const FaceSet set = face_set(mesh, joint.slave);
  Triplets triplets;
  add_surface_mass(triplets, set, rules);
  JointTerm term;
  term.matrix = from_triplets(size, size, triplets);
  term.area = set.area;
  term.slave_load = surface_load(set);
  return term;
}

}  // namespace

std::vector<std::vector<JointTerm>> joint_terms(const MachineMesh& mesh, const std::vector<JointGrid>& grids,
                                                ElementRules rules, Index size) {
  std::vector<std::vector<JointTerm>> terms;
  std::vector<std::pair<std::size_t, std::size_t>> tasks;
  for (std::size_t j = 0; j < grids.size(); ++j) {
    terms.emplace_back(grids[j].positions.size());
    for (std::size_t node = 0; node < terms[j].size(); ++node) tasks.emplace_back(j, node);
  }
  std::vector<ContactSearch> searches;
  for (const mesh::JointSpec& joint : mesh.machine.joints) searches.emplace_back(mesh, joint);
  core::parallel_for(0, tasks.size(), [&](std::size_t i) {
    const auto [j, node] = tasks[i];
    const mesh::JointSpec& joint = mesh.machine.joints[j];
    terms[j][node] = joint.master.empty() ? ground_term(mesh, joint, rules, size)
                                          : joint_term(mesh, joint, searches[j], grids[j].positions[node], size);
  });
  for (std::size_t j = 0; j < terms.size(); ++j) {
    const mesh::JointSpec& joint = mesh.machine.joints[j];
    double largest = 0.0;
    std::size_t open = 0;
    for (const JointTerm& term : terms[j]) {
      largest = std::max(largest, term.area);
      if (term.area <= 0.0) ++open;
    }
    if (largest <= 0.0) {
      throw core::InputError(mesh.machine.path.string() + " joint " + joint.id,
                             fmt::format("'{}' and '{}' touch nowhere over the travel", joint.slave, joint.master),
                             fmt::format("surfaces that face each other within reach_mm = {:.4g}", joint.reach * 1e3));
    }
    if (open > 0) {
      core::warn(fmt::format("joint {}: no contact at {} of {} positions of its axis {}", joint.id, open,
                             terms[j].size(), joint.axis));
    }
  }
  return terms;
}

SparseColumn joint_source(const MachineMesh& mesh, const mesh::JointSpec& joint, const mesh::SourcePlace& place,
                          const JointTerm& term) {
  SparseColumn load;
  if (term.area <= 0.0) {
    const FaceSet set = face_set(mesh, joint.slave);
    load = surface_load(set);
    for (auto& [node, value] : load) value /= set.area;
    return load;
  }
  // The ground takes no heat: what would be its share stays with the slave.
  const double slave_share = joint.master.empty() ? 1.0 : place.slave_share;
  for (const auto& [node, value] : term.slave_load) load.emplace_back(node, value * slave_share / term.area);
  for (const auto& [node, value] : term.master_load) load.emplace_back(node, value * (1.0 - slave_share) / term.area);
  return load;
}

std::vector<JointGrid> joint_grids(const MachineMesh& mesh) {
  std::vector<JointGrid> grids;
  for (const mesh::JointSpec& joint : mesh.machine.joints) {
    JointGrid grid;
    grid.axis = joint.axis.empty() ? -1 : mesh.machine.axis_index(joint.axis);
    grid.periodic = grid.axis >= 0 && mesh.machine.axes[grid.axis].endless;
    grid.positions = contact_grid(mesh, joint);
    grids.push_back(std::move(grid));
  }
  return grids;
}

}  // namespace thermotwin::solver::assembly
