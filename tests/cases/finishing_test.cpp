// SPDX-License-Identifier: GPL-3.0-or-later
// cases/finishing: a workpiece on the table with a temperature of its own, and what its growth does to the dimension.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>

#include "core/file.h"
#include "core/table.h"
#include "tests/cases/nc_programs.h"
#include "tests/cases/toy.h"
#include "tests/core/temporary_folder.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

fs::path finishing() { return toy_case().parent_path().parent_path().parent_path() / "cases" / "finishing"; }

class Finishing : public testing::Test {
protected:
  void SetUp() override { fs::copy(finishing(), folder.path(), fs::copy_options::recursive); }
  std::string path() const { return folder.path().string(); }
  core::TemporaryFolder folder;
  Toy toy;
};

// The workpiece takes up 40 W for half an hour and gives hardly any away; its temperature evens out. It is 110 mm high:
// its upper face rises by alpha h (T - 20), and a point beside its middle moves outwards by alpha x (T - 20).
TEST_F(Finishing, AWarmWorkpieceGrowsUnderTheTool) {
  std::string machine = read(finishing() / "machine.toml");
  const std::string vice = "conductance_W_m2K = {value = 500, std_percent = 40}";
  machine.replace(machine.find(vice), vice.size(), "conductance_W_m2K = 0.01");
  core::write_file(folder.path() / "machine.toml", machine);
  core::write_file(folder.path() / "loads" / "warm.toml",
                   "schema = 1\ntime_step_s = 60\noutput_s = 600\n[[phase]]\nduration_h = 0.5\nworkpiece_W = 40\n"
                   "[[phase]]\nduration_h = 0.1\nworkpiece_W = 0\n");
  const auto last = [&](const std::string& pose) {
    const Result result = toy.run({"simulate", path(), "--load", "warm", "--pose", pose});
    EXPECT_EQ(result.status, 0) << result.err;
    return core::read_csv(toy.result("simulate/warm/tcp.csv"));
  };
  const core::Table middle = last("X=0");
  const core::Table sensors = core::read_csv(toy.result("simulate/warm/sensors.csv"));
  const Eigen::Index end = middle.rows() - 1;
  const double warmer = sensors.column("T_workpiece_C")[sensors.rows() - 1] - 20.0, alpha_um = 23.6;
  EXPECT_GT(warmer, 4.0);
  const double rise = alpha_um * 0.110 * warmer, out = alpha_um * 0.150 * warmer;
  EXPECT_NEAR(middle.column("dz_um")[end], -rise, 0.06 * rise) << "the tool cuts too deep";
  EXPECT_NEAR(middle.column("dx_um")[end], 0.0, 0.05 * out);
  // X moves the table: at X = 150 the tool is over the workpiece's x = 150, which has moved by +x.
  EXPECT_NEAR(last("X=150").column("dx_um")[end], -out, 0.08 * out);
}

TEST_F(Finishing, ItsProgramTakesTheTimeOfThePaper) {
  if (!has_interpreter()) GTEST_SKIP() << "the program was built without LinuxCNC's interpreter";
  const Result result =
      toy.run({"nc", path() + "/machine.toml", path() + "/nc/finishing.ngc", "--process", path() + "/nc/process.toml",
               "--control", path() + "/nc/control.toml", "--row-s", "600", "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const json summary = json::parse(result.out);
  EXPECT_NEAR(summary["duration_s"].get<double>() / 3600.0, 15.5, 0.2);
  const core::Table rows = core::parse_csv(after_first_line(read(toy.result("rows.csv"))), "rows.csv");
  EXPECT_NEAR(rows.column("workpiece.power_W")[rows.rows() / 2], 0.04, 1e-9);
}

}  // namespace
}  // namespace thermotwin::cases
