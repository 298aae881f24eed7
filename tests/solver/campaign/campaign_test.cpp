// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/campaign.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include "core/error.h"
#include "core/file.h"
#include "mesh/machine/kinematics.h"
#include "solver/campaign/case.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"
#include "solver/elastic/tcp.h"
#include "solver/thermal/assembly.h"
#include "tests/machines/box_machine.h"

namespace thermotwin::solver {
namespace {

const std::filesystem::path vmc5 = std::filesystem::path(THERMOTWIN_SOURCE_DIR) / "cases" / "vmc5";

class Campaign : public ::testing::Test {
protected:
  Campaign() : folder_(std::filesystem::temp_directory_path() / ("thermotwin_campaign_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~Campaign() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  LoadProgram program(const std::string& name, double air_C) const {
    core::write_file(folder_ / (name + ".toml"), "schema = 1\ntitle = \"" + name +
                                                     "\"\ninitial_C = 20\ntime_step_s = 120\noutput_s = 600\n"
                                                     "[[phase]]\nname = \"warm\"\nduration_s = 1800\nair_C = " +
                                                     std::to_string(air_C) + "\n");
    return LoadProgram::read(folder_ / (name + ".toml"), box_machine_);
  }
  static FullModel model() {
    mesh::MachineMesh mesh = test::box_machine_mesh();
    ThermalSystem thermal = assemble_thermal(mesh);
    ElasticModel elastic(mesh, thermal);
    return {std::move(mesh), std::move(thermal), std::move(elastic)};
  }
  std::filesystem::path folder_;
  mesh::Machine box_machine_ = test::box_machine();
};

TEST_F(Campaign, WritesTablesAndResumes) {
  const FullModel full = model();
  const std::vector<LoadProgram> loads = {program("warm", 25.0), program("cold", 15.0)};
  CampaignOptions options;
  options.out = folder_ / "out";
  options.keep_snapshots = true;
  const std::vector<LoadResult> first = run_campaign(full, loads, options);
  ASSERT_EQ(first.size(), 2U);
  const LoadResult& warm = first[0];
  EXPECT_EQ(warm.load, "warm");
  EXPECT_EQ(warm.tcp.rows(), 4 * 9);  // 0, 600, 1200, 1800 s at 3 x 3 poses
  EXPECT_EQ(warm.tcp.columns.size(), 1 + 3 + 18U);
  EXPECT_EQ(warm.snapshots.cols(), 4);
  EXPECT_DOUBLE_EQ(warm.tcp.column("time_s")[9], 600.0);
  EXPECT_NEAR(warm.inputs.column("air.T_C")[3], 25.0, 1e-12);
  EXPECT_GT(warm.tcp.column("dz_um").cwiseAbs().maxCoeff(), 0.01);
  EXPECT_EQ(warm.tcp.values.topRows(9).rightCols(18).cwiseAbs().maxCoeff(), 0.0);  // starts at the reference
  // Films are constant here, so that the answer is linear in the air's temperature.
  EXPECT_LT((warm.tcp.column("dz_um") + first[1].tcp.column("dz_um")).norm(), 1e-6 * warm.tcp.column("dz_um").norm());

  // The tables hold what the rows say about the snapshots.
  const mesh::Pose pose = test::box_pose(0.2, 0.1);
  const OutputRows rows = full.elastic.output_rows(pose);
  const Eigen::VectorXd end = warm.snapshots.col(3);
  const TcpError error =
      tcp_error(full.mesh.machine, pose, rows.tool * end, rows.table_axis * end, rows.table_own * end);
  EXPECT_NEAR(warm.tcp.column("dy_um")[4 * 9 - 1], error.error[1] * 1e6, 1e-9);

  // One load is complete, the other was stopped: only that one runs again, with the same numbers.
  std::filesystem::remove(folder_ / "out" / "cold" / "done");
  const auto written = std::filesystem::last_write_time(folder_ / "out" / "warm" / "tcp.csv");
  options.resume = true;
  const std::vector<LoadResult> second = run_campaign(full, loads, options);
  EXPECT_EQ(std::filesystem::last_write_time(folder_ / "out" / "warm" / "tcp.csv"), written);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / "cold" / "done"));
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_EQ(second[i].tcp.values.rows(), first[i].tcp.values.rows());
    EXPECT_LT((second[i].tcp.values - first[i].tcp.values).cwiseAbs().maxCoeff(), 1e-6);
    // Alone in its block, a load has another mean operator: equal to the solver's tolerance.
    EXPECT_LT((second[i].snapshots - first[i].snapshots).cwiseAbs().maxCoeff(), i == 0 ? 1e-300 : 1e-6);
  }
  // Another program of the same name is not taken for the finished one.
  const std::vector<LoadProgram> changed = {program("warm", 30.0)};
  const std::vector<LoadResult> third = run_campaign(full, changed, options);
  EXPECT_NEAR(third[0].tcp.column("dz_um")[35], 2.0 * first[0].tcp.column("dz_um")[35], 1e-6);
}

TEST_F(Campaign, ReadsTheCaseOfTheRepository) {
  const Case found = read_case(vmc5);
  EXPECT_FALSE(found.train.empty());
  EXPECT_FALSE(found.holdout.empty());
  EXPECT_EQ(found.machine.name, "vmc5");
  EXPECT_EQ(found.load(found.train.front()).name(), found.train.front());
  EXPECT_EQ(read_case(vmc5 / "case.toml").train, found.train);
}

TEST_F(Campaign, CaseErrorsNameTheLoad) {
  const auto expect_error = [&](const std::string& text, const std::string& part) {
    core::write_file(folder_ / "case.toml",
                     "schema = 1\nmachine = \"" + (vmc5 / "machine.toml").string() + "\"\n" + text);
    try {
      read_case(folder_);
      FAIL() << text;
    } catch (const core::InputError& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  };
  std::filesystem::create_directories(folder_ / "loads");
  std::filesystem::copy_file(vmc5 / "loads" / "etve.toml", folder_ / "loads" / "etve.toml");
  expect_error("train = [\"etvee\"]\n", "etvee");
  expect_error("train = [\"etve\"]\nholdout = [\"etve\"]\n", "also trains");
  expect_error("trian = [\"etve\"]\n", "train");
  expect_error("size = \"huge\"\n", "huge");
  expect_error("[check_points]\nposes = [\"Q=1\"]\n", "Q");
  core::write_file(folder_ / "case.toml",
                   "schema = 1\nmachine = \"" + (vmc5 / "machine.toml").string() + "\"\ntrain = [\"etve\"]\n");
  EXPECT_THROW(read_case(folder_).load("nothing"), core::InputError);
  EXPECT_NO_THROW(read_case(folder_).load("etve"));
}

}  // namespace
}  // namespace thermotwin::solver
