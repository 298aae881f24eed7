// SPDX-License-Identifier: GPL-3.0-or-later
// A machine with scale and screw: rows and capacities of its parts against machines whose material data
// or stiffnesses are others.
#include "reduction/basis/parameter_parts.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mesh/machine/kinematics.h"
#include "reduction/basis/basis.h"
#include "reduction/model/output_grid.h"
#include "solver/campaign/full_model.h"
#include "solver/thermal/assembly.h"
#include "tests/machines/box_machine.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// X by the encoder of a stretched screw, Z by its scale; every body of a material of its own.
mesh::MachineMesh machine_mesh() {
  mesh::MachineMesh mesh = test::box_machine_mesh();
  mesh::Machine& machine = mesh.machine;
  machine.bodies.push_back(test::body("screw", "steel", "bed"));
  machine.bodies.back().elastic = false;
  mesh.bodies.push_back(test::box_mesh({-0.42, -0.01, -0.06}, {0.42, 0.01, -0.04}, {24, 2, 2}));
  mesh.first_node.push_back(mesh.first_node.back() + mesh.bodies.back().nodes());
  mesh::ScrewSpec screw;
  screw.axis = "X";
  screw.body = "screw";
  screw.carrier = "bed";
  screw.nut_body = "slide";
  screw.bearing = {-0.4, 0.0, -0.05};
  screw.nut = {0.05, 0.0, -0.05};
  screw.expansion = {11.5e-6, 0.0};
  screw.far_bearing = Eigen::Vector3d(0.4, 0.0, -0.05);
  screw.pretension = 8000.0;
  screw.bearing_stiffness = 4e8;
  machine.screws = {screw};
  machine.axes[0].feedback = "screw";
  for (mesh::BodySpec& body : machine.bodies) {
    mesh::Material own = machine.material("steel");
    own.id = body.id;
    machine.materials.push_back(own);
    body.material = own.id;
  }
  return mesh;
}

solver::FullModel full_model(mesh::MachineMesh mesh) {
  solver::ThermalSystem thermal = solver::assemble_thermal(mesh);
  solver::ElasticModel elastic(mesh, thermal);
  return {std::move(mesh), std::move(thermal), std::move(elastic)};
}

mesh::Material& material_of(mesh::Machine& machine, const std::string& body) {
  for (mesh::Material& material : machine.materials)
    if (material.id == body) return material;
  throw std::logic_error(body);
}

/// Smooth fields that differ in every body.
MatrixXd fields(const solver::FullModel& full) {
  MatrixXd basis = MatrixXd::Zero(full.thermal.size, 4);
  for (std::size_t b = 0; b < full.mesh.bodies.size(); ++b) {
    for (Index i = 0; i < full.mesh.bodies[b].nodes(); ++i) {
      const Eigen::Vector3d p = full.mesh.bodies[b].points.col(i);
      for (int k = 0; k < 4; ++k) {
        basis(full.mesh.first_node[b] + i, k) =
            1.0 + std::sin((3.0 + k) * p.x() + (k - 1.0) * p.y() + 2.0 * p.z() + static_cast<double>(b) * (k + 1));
      }
    }
  }
  return basis;
}

ReducedOutputs outputs_of(const solver::FullModel& full, const MatrixXd& basis) {
  const mesh::Machine& machine = full.mesh.machine;
  const auto rows = [&](const std::vector<mesh::Pose>& poses) {
    std::vector<solver::OutputRows> all;
    for (const mesh::Pose& pose : poses) {
      const solver::OutputRows at = full.elastic.output_rows(pose);
      all.push_back({at.tool * basis, at.table_axis * basis, at.table_own * basis});
    }
    return all;
  };
  const auto tool_poses = OutputGrid(machine).tool_poses(), tables = OutputGrid(machine).table_poses();
  return stored_outputs(machine, tool_poses, tables, rows(tool_poses), rows(tables));
}

MatrixXd stacked(const ReducedOutputs& outputs) {
  MatrixXd all(0, outputs.tool.front().cols());
  for (const auto* rows : {&outputs.tool, &outputs.table_axis, &outputs.table_own}) {
    for (const MatrixXd& block : *rows) {
      all.conservativeResize(all.rows() + block.rows(), Eigen::NoChange);
      all.bottomRows(block.rows()) = block;
    }
  }
  return all;
}

struct Base {
  solver::FullModel full = full_model(machine_mesh());
  MatrixXd basis = fields(full), rows = stacked(outputs_of(full, basis));
  Parts parts = make_parts(full, basis);
};
const Base& base() {
  static const Base made;
  return made;
}

/// Rows of the machine after a change.
template <class Change>
MatrixXd rows_after(const Change& change) {
  mesh::MachineMesh mesh = machine_mesh();
  change(mesh.machine);
  const solver::FullModel full = full_model(std::move(mesh));
  return stacked(outputs_of(full, base().basis));
}

TEST(Parts, RowsOfAllExpansionsAddUp) {
  MatrixXd sum = MatrixXd::Zero(base().rows.rows(), base().rows.cols());
  int taking_part = 0;
  for (const auto* list : {&base().parts.bodies, &base().parts.scales, &base().parts.screws}) {
    for (const ReducedOutputs& outputs : *list)
      if (!outputs.tool.empty()) sum += stacked(outputs), ++taking_part;
  }
  EXPECT_EQ(taking_part, 5 + 1 + 1) << "five elastic bodies, the scale of Z, the screw of X";
  EXPECT_LT((sum - base().rows).norm(), 1e-10 * base().rows.norm());
}

// What the other axes do to the table's side is in the tool's stored rows: their sum is right.
TEST(Parts, StoredRowsAreTheMachineItselfAtEveryStoredPose) {
  const solver::FullModel& full = base().full;
  const mesh::Machine& machine = full.mesh.machine;
  const ReducedOutputs outputs = outputs_of(full, base().basis);
  double off = 0, size = 0, taken_over = 0;
  for (std::size_t i = 0; i < outputs.tool_poses.size(); ++i) {
    const mesh::Pose& pose = outputs.tool_poses[i];
    const solver::OutputRows rows = full.elastic.output_rows(pose);
    const MatrixXd tool = rows.tool * base().basis, axis = rows.table_axis * base().basis,
                   own = rows.table_own * base().basis;
    const MatrixXd stored = side_rows(machine, outputs, pose);
    taken_over = std::max(taken_over, (tool - outputs.tool[i]).norm());
    for (Index k = 0; k < tool.cols(); ++k) {
      const solver::Vector6 here = solver::tcp_error(machine, pose, tool.col(k), axis.col(k), own.col(k)).error;
      const solver::Vector6 there = solver::tcp_error(machine, pose, stored.col(k).head<6>(),
                                                      stored.col(k).segment<6>(6), stored.col(k).tail<7>())
                                        .error;
      off = std::max(off, (there - here).norm());
      size = std::max(size, here.norm());
    }
  }
  EXPECT_LT(off, 1e-11 * size);
  EXPECT_GT(taken_over, 1e-7 * size) << "nothing to take over: the test sees nothing";
}

TEST(Parts, EachExpansionChangesItsOwnRows) {
  const Parts& parts = base().parts;
  const auto expect = [&](const char* what, const ReducedOutputs& part, double by, const MatrixXd& after) {
    const MatrixXd change = after - base().rows;
    ASSERT_GT(change.norm(), 1e-3 * base().rows.norm()) << what;
    EXPECT_LT((change - by * stacked(part)).norm(), 1e-8 * change.norm()) << what;
  };
  expect("column", parts.bodies[3], 0.3,
         rows_after([](mesh::Machine& m) { material_of(m, "column").expansion.value *= 1.3; }));
  expect("slide", parts.bodies[1], -0.4,
         rows_after([](mesh::Machine& m) { material_of(m, "slide").expansion.value *= 0.6; }));
  expect("scale", parts.scales[1], -0.5, rows_after([](mesh::Machine& m) { m.scales[1].expansion.value *= 0.5; }));
  expect("screw", parts.screws[0], 0.25, rows_after([](mesh::Machine& m) { m.screws[0].expansion.value *= 1.25; }));
  EXPECT_TRUE(parts.scales[0].tool.empty()) << "X is held by its screw";
  EXPECT_TRUE(parts.bodies[5].tool.empty()) << "the screw's own body is not elastic";
}

TEST(Parts, StiffnessChangesAsCentralDifferencesSay) {
  constexpr double h = 1e-3;
  const mesh::Machine& machine = base().full.mesh.machine;
  for (const std::size_t joint : {0, 1, 3}) {
    const auto scaled = [&](double ln) {
      return rows_after([&](mesh::Machine& m) {
        m.joints[joint].stiffness_normal.value *= std::exp(ln);
        m.joints[joint].stiffness_tangential.value *= std::exp(ln);
      });
    };
    const MatrixXd central = (scaled(h) - scaled(-h)) / (2.0 * h), exact = stacked(base().parts.stiffness[joint]);
    ASSERT_GT(central.norm(), 1e-4 * base().rows.norm()) << machine.joints[joint].id;
    EXPECT_LT((exact - central).norm(), 1e-5 * central.norm()) << machine.joints[joint].id;
  }
}

TEST(Parts, AStiffnessFarFromItsOwnIsFollowedByAPower) {
  // Soft mounts give as their compliance says.
  const double ln = std::log(0.4);
  const MatrixXd change = rows_after([&](mesh::Machine&m) {
                            m.joints[0].stiffness_normal.value *= 0.4;
                            m.joints[0].stiffness_tangential.value *= 0.4;
                          }) -
                          base().rows,
                 slope = stacked(base().parts.stiffness[0]);
  const double off = (change - base().parts.stiffness_amount(0, ln) * slope).norm(),
               by_logarithm = (change - ln * slope).norm();
  std::printf("exponent %.2f: off by %.1f %% of the change, by the logarithm %.1f %%\n",
              base().parts.stiffness_exponent[0], 100 * off / change.norm(), 100 * by_logarithm / change.norm());
  EXPECT_LT(off, 0.15 * change.norm());
  EXPECT_LT(off, 0.7 * by_logarithm);
}

TEST(Parts, CapacitiesAddUpAndFollowTheMaterial) {
  const MatrixXd whole = project(base().full.thermal.capacity, RowMajorMatrix(base().basis));
  MatrixXd sum = MatrixXd::Zero(whole.rows(), whole.cols());
  for (const MatrixXd& capacity : base().parts.capacity) sum += capacity;
  EXPECT_LT((sum - whole).norm(), 1e-12 * whole.norm()) << "no fluid in this machine";
  mesh::MachineMesh mesh = machine_mesh();
  material_of(mesh.machine, "head").specific_heat.value *= 1.7;
  const MatrixXd changed = project(solver::assemble_thermal(mesh).capacity, RowMajorMatrix(base().basis));
  EXPECT_LT((changed - whole - 0.7 * base().parts.capacity[4]).norm(), 1e-12 * whole.norm());
}

TEST(Parts, AreCutWithTheModel) {
  const Parts small = truncated(base().parts, 2);
  EXPECT_EQ(small.capacity[2], base().parts.capacity[2].topLeftCorner(2, 2));
  EXPECT_EQ(stacked(small.screws[0]), stacked(base().parts.screws[0]).leftCols(2));
}

}  // namespace
}  // namespace thermotwin::reduction
