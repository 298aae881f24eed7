// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/elastic/stress.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "mesh/machine/kinematics.h"
#include "solver/elastic/model.h"
#include "solver/thermal/assembly.h"
#include "solver/thermal/system.h"
#include "tests/machines/box_machine.h"

namespace thermotwin::solver {
namespace {

TEST(Stress, TurnsWithItsFrame) {
  // Pull along x; x turns to y about z, then to z about x.
  const Vector6 pull = (Vector6() << 7, 0, 0, 0, 0, 0).finished();
  const Eigen::Matrix3d about_z = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Matrix3d about_x = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  EXPECT_LT((turned(pull, about_z) - 7.0 * Vector6::Unit(1)).norm(), 1e-14);
  EXPECT_LT((turned(pull, about_x * about_z) - 7.0 * Vector6::Unit(2)).norm(), 1e-14);
  const Vector6 diagonal = turned(pull, Eigen::AngleAxisd(M_PI / 4, Eigen::Vector3d::UnitZ()).toRotationMatrix());
  EXPECT_LT((diagonal - (Vector6() << 3.5, 3.5, 0, 3.5, 0, 0).finished()).norm(), 1e-14);
  EXPECT_NEAR(von_mises(diagonal)[0], 7.0, 1e-14);
  EXPECT_NEAR(von_mises((Vector6() << 0, 0, 0, 0, 2, 0).finished())[0], 2.0 * std::sqrt(3.0), 1e-14);
  EXPECT_NEAR(von_mises((Vector6() << 5, 5, 5, 0, 0, 0).finished())[0], 0.0, 1e-14);
}

TEST(Stress, AMachineThatIsEvenlyWarmHasNone) {
  test::BoxMachineOptions options;
  options.mount_normal = options.mount_tangential = 1e4;
  for (int order : {1, 2}) {
    const mesh::MachineMesh mesh = test::with_order(test::box_machine_mesh(options), order);
    const ThermalSystem thermal = assemble_thermal(mesh);
    const ElasticModel elastic(mesh, thermal);
    const MachineStress recovery(mesh);
    const double scale = 210e9 * 11.5e-6 * 2.0;  // of a body that is held
    const mesh::Pose pose = test::box_pose(0.1, 0.02);
    const Eigen::VectorXd even = Eigen::VectorXd::Constant(thermal.size, 2.0),
                          uneven = test::uneven_temperature(mesh, thermal.size);
    EXPECT_LT(recovery.nodal(elastic.displacement(even, pose), even).cwiseAbs().maxCoeff(), 1e-4 * scale);
    EXPECT_GT(recovery.nodal(elastic.displacement(uneven, pose), uneven).cwiseAbs().maxCoeff(), 0.01 * scale);
  }
}

TEST(Stress, ABodyThatIsNotElasticHasNone) {
  mesh::MachineMesh mesh = test::box_machine_mesh();
  mesh.machine.bodies[1].elastic = false;
  const Eigen::VectorXd warm = Eigen::VectorXd::Ones(mesh.nodes());
  const Eigen::MatrixXd stress = MachineStress(mesh).nodal(Eigen::Matrix3Xd::Zero(3, mesh.nodes()), warm);
  EXPECT_EQ(stress.middleCols(mesh.first_node[1], mesh.bodies[1].nodes()).cwiseAbs().maxCoeff(), 0.0);
  // A body that is held everywhere: -E alpha T / (1 - 2 nu).
  const Eigen::MatrixXd held = stress.leftCols(mesh.bodies[0].nodes());
  EXPECT_LT((held.row(1).array() / (-210e9 * 11.5e-6 / 0.4) - 1.0).abs().maxCoeff(), 1e-12);
}

}  // namespace
}  // namespace thermotwin::solver
