// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/export/vtk_output.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <unistd.h>

#include "core/error.h"
#include "core/file.h"
#include "mesh/import/import.h"
#include "mesh/machine/kinematics.h"
#include "solver/export/picture.h"
#include "tests/machines/box_machine.h"

namespace thermotwin::solver {
namespace {

class VtkOutput : public ::testing::Test {
protected:
  VtkOutput() : folder_(std::filesystem::temp_directory_path() / ("thermotwin_vtk_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~VtkOutput() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  static std::string head(const std::filesystem::path& path) { return core::read_file(path).substr(0, 6000); }

  std::filesystem::path folder_;
  mesh::MachineMesh mesh_ = test::box_machine_mesh();
  mesh::Pose pose_ = test::box_pose(0.1, 0.05, 0.3);
  Eigen::VectorXd temperature_ = 20.0 + test::uneven_temperature(mesh_, mesh_.nodes()).array();
};

TEST_F(VtkOutput, FieldsCanBeReadBack) {
  Eigen::Matrix3Xd motion = Eigen::Matrix3Xd::Zero(3, mesh_.nodes());
  motion.row(2) = 1e-6 * temperature_.transpose();
  const auto path = folder_ / "fields_0001.vtu";
  write_fields(path, mesh_, pose_, temperature_, motion, 300.0);
  const std::string text = head(path);
  for (const char* name :
       {"temperature_C", "displacement_um", "\"body\"", "TimeValue", "\"pose\"", "X_mm", "vtkLZ4DataCompressor"})
    EXPECT_NE(text.find(name), std::string::npos) << name;

  mesh::ImportOptions options;
  options.body = "all";
  options.unit_m = 1.0;
  const mesh::TetMesh read = mesh::read_tet_mesh(path, options);
  Eigen::Index elements = 0;
  double volume = 0.0;
  for (const mesh::TetMesh& body : mesh_.bodies) elements += body.elements(), volume += body.total_volume();
  ASSERT_EQ(read.nodes(), mesh_.nodes());
  EXPECT_EQ(read.elements(), elements);
  EXPECT_NEAR(read.total_volume(), volume, 1e-9);
  // The head stands at the pose.
  const Eigen::Index first = mesh_.first_node[4];
  EXPECT_NEAR((read.points.col(first) - mesh_.bodies[4].points.col(0) - Eigen::Vector3d(0, 0, 0.05)).norm(), 0.0, 1e-9);
}

TEST_F(VtkOutput, QuadraticCellsAndStresses) {
  const mesh::MachineMesh quadratic = test::with_order(mesh_, 2);
  Eigen::MatrixXd stress = Eigen::MatrixXd::Zero(6, quadratic.nodes());
  stress.row(0).setConstant(5e6);
  const auto path = folder_ / "quadratic.vtu";
  write_fields(path, quadratic, pose_, Eigen::VectorXd::Constant(quadratic.nodes(), 21.0),
               Eigen::Matrix3Xd::Zero(3, quadratic.nodes()), 0.0, stress);
  const std::string text = head(path);
  for (const char* name : {"stress_MPa", "von_mises_MPa"}) EXPECT_NE(text.find(name), std::string::npos) << name;
  mesh::ImportOptions options;
  options.body = "all";
  options.unit_m = 1.0;
  const mesh::TetMesh read = mesh::read_tet_mesh(path, options);
  EXPECT_EQ(read.order(), 2);
  EXPECT_EQ(read.nodes(), quadratic.nodes());
  EXPECT_TRUE(read.tet_edges.leftCols(quadratic.bodies[0].elements()) == quadratic.bodies[0].tet_edges);
}

TEST_F(VtkOutput, CollectionListsTimes) {
  write_pvd(folder_ / "fields.pvd", {{0.0, "fields_0000.vtu"}, {300.0, "fields_0001.vtu"}});
  const std::string text = core::read_file(folder_ / "fields.pvd");
  EXPECT_NE(text.find("timestep=\"300\""), std::string::npos) << text;
  EXPECT_NE(text.find("fields_0001.vtu"), std::string::npos);
}

TEST_F(VtkOutput, PosesCarryErrors) {
  TcpError error;
  error.tool << 1e-6, 2e-6, 3e-6, 0, 0, 0;
  error.table.setZero();
  error.error = error.tool;
  write_poses(folder_ / "poses.vtp", mesh_.machine, {pose_, test::box_pose(0, 0)}, {error, error});
  const std::string text = head(folder_ / "poses.vtp");
  for (const char* name : {"error_um", "error_tool_um", "error_table_um", "rotation_um_per_m", "NumberOfPoints=\"2\""})
    EXPECT_NE(text.find(name), std::string::npos) << name;
}

TEST_F(VtkOutput, AFolderThatCannotBeWrittenIsAnInputError) {
  core::write_file(folder_ / "file", "not a folder");
  EXPECT_THROW(
      write_fields(folder_ / "file" / "a.vtu", mesh_, pose_, temperature_, Eigen::Matrix3Xd::Zero(3, mesh_.nodes())),
      core::InputError);
}

TEST_F(VtkOutput, PictureIsDrawn) {
  const char* display = std::getenv("DISPLAY");
  const auto path = folder_ / "machine.png";
  const auto draw = [&] {
    write_picture(path, mesh_, pose_, temperature_, Eigen::Matrix3Xd::Zero(3, mesh_.nodes()), 1000.0, "Boxes");
  };
  if (!display || !*display) {
    EXPECT_THROW(draw(), core::SolverError);  // VTK itself would end the program
    EXPECT_FALSE(std::filesystem::exists(path));
    if (std::system("command -v xvfb-run > /dev/null 2>&1") != 0) GTEST_SKIP() << "xvfb-run is not installed";
    const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
    EXPECT_EQ(
        std::system(("xvfb-run -a '" + self + "' --gtest_filter=VtkOutput.PictureIsDrawn > /dev/null 2>&1").c_str()),
        0);
    return;
  }
  draw();
  const std::string bytes = core::read_file(path);
  ASSERT_GT(bytes.size(), 20000U);  // not one plain colour
  EXPECT_EQ(bytes.substr(1, 3), "PNG");
  EXPECT_EQ(static_cast<unsigned char>(bytes[18]) * 256 + static_cast<unsigned char>(bytes[19]), 1400);
  EXPECT_EQ(static_cast<unsigned char>(bytes[22]) * 256 + static_cast<unsigned char>(bytes[23]), 1000);
}

}  // namespace
}  // namespace thermotwin::solver
