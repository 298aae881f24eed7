// SPDX-License-Identifier: GPL-3.0-or-later
// `nc --imprint` and locations.csv: what stays in the surface, and location errors of the axes over the program.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>

#include "core/table.h"
#include "tests/cases/nc_programs.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

using nlohmann::json;

class NcImprint : public testing::Test {
protected:
  void SetUp() override {
    if (!has_interpreter()) GTEST_SKIP() << "the program was built without LinuxCNC's interpreter";
    toy.write("control.toml", "schema = 1\n[[tool]]\nnumber = 1\n[[tool]]\nnumber = 2\n");
  }
  Result run(const std::string& text, const std::vector<std::string>& more) {
    toy.write("part.ngc", text);
    std::vector<std::string> arguments = {
        "nc", toy_model(), toy.file("part.ngc"), "--control", toy.file("control.toml"), "--start-C", "25"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return toy.run(arguments);
  }
  Toy toy;
};

TEST_F(NcImprint, IsTheErrorOfTheToolsCuts) {
  const Result result =
      run("G21 G90\nT1 M6\nG1 X50 F600\nT2 M6\nG0 X0 Z10\n#1 = 0\no1 while [#1 LT 3]\nG1 X60 F600\nY10\n#1 = [#1 + 1]\n"
          "G0 X0 Y0\no1 endwhile\nG0 Z50\nM2\n",
          {"--imprint", "2"});
  ASSERT_EQ(result.status, 0) << result.err;
  for (const char* words : {"imprint of tool 2", "smallest", "line"}) EXPECT_SAYS(result.out, words);
  const core::Table points = core::read_csv(toy.result("imprint.csv")),
                    blocks = core::read_csv(toy.result("blocks.csv"));
  const Eigen::VectorXd line = points.column("line"), time = points.column("time_s"), dz = points.column("dz_um"),
                        x = points.column("x_mm"), run_of = points.column("run");
  EXPECT_EQ(line.minCoeff(), 8) << "neither the other tool nor rapid moves";
  EXPECT_EQ(line.maxCoeff(), 9);
  EXPECT_EQ(run_of.maxCoeff(), 3);
  EXPECT_NEAR(x.maxCoeff(), 60.0, 1e-6);
  int found = 0;
  const Eigen::VectorXd block_time = blocks.column("time_s"), block_dz = blocks.column("dz_um");
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    for (Eigen::Index k = 0; k < blocks.rows(); ++k)
      if (std::abs(time[i] - block_time[k]) < 1e-3) {
        EXPECT_NEAR(dz[i], block_dz[k], 1e-3);
        ++found;
      }
  EXPECT_EQ(found, 6 + 3) << "ends of all moves of the pass, and begins behind rapid moves";
  EXPECT_SAYS(read(toy.result("report.html")), "Imprint of the finishing pass");
  const std::string picture = read(toy.result("imprint.svg"));
  for (const char* words : {"<svg xmlns", "line 8", "line 9", "</svg>"}) EXPECT_SAYS(picture, words);
}

// The table has turned by 90 deg: what is X of the workpiece is Y of the machine.
TEST_F(NcImprint, HasTheDirectionsOfTheWorkpiece) {
  const Result result = run("G21 G90\nT1 M6\nG0 C90\nG1 X30 F600\nM2\n", {"--imprint", "1"});
  ASSERT_EQ(result.status, 0) << result.err;
  const core::Table points = core::read_csv(toy.result("imprint.csv")),
                    blocks = core::read_csv(toy.result("blocks.csv"));
  const Eigen::Index point = points.rows() - 1, block = blocks.rows() - 1;
  const auto of = [](const core::Table& table, const char* name, Eigen::Index row) { return table.column(name)[row]; };
  EXPECT_NEAR(of(points, "dx_um", point), of(blocks, "dy_um", block), 1e-3);
  EXPECT_NEAR(of(points, "dy_um", point), -of(blocks, "dx_um", block), 1e-3);
  EXPECT_NEAR(of(points, "dz_um", point), of(blocks, "dz_um", block), 1e-3);
  EXPECT_GT(std::abs(of(points, "dx_um", point) - of(points, "dy_um", point)), 0.1) << "or nothing was compared";
}

TEST_F(NcImprint, AToolThatCutsNothingIsRefused) {
  const Result result = run("G21 G90\nT1 M6\nG1 X50 F600\nM2\n", {"--imprint", "2"});
  EXPECT_EQ(result.status, 3);
  for (const char* words : {"--imprint", "tool 2", "one of: 1"}) EXPECT_SAYS(result.err, words);
  const Result without = toy.run({"nc", toy.file("machine.toml"), toy.file("part.ngc"), "--imprint", "1"});
  EXPECT_EQ(without.status, 2);
  EXPECT_SAYS(without.err, "--imprint needs a reduced model");
}

// The machine is 5 K warmer than its reference: the steel table has grown by 11.5e-6 / K at its radius of 60 mm.
TEST_F(NcImprint, LocationErrorsAreThoseOfTheStateOfEachRow) {
  const Result result = run("G21 G90\nG4 P100\nM2\n", {"--row-s", "10"});
  ASSERT_EQ(result.status, 0) << result.err;
  const core::Table errors = core::read_csv(toy.result("locations.csv"));
  EXPECT_EQ(errors.rows(), 10);
  EXPECT_EQ(errors.columns[1], "X0B_um");
  EXPECT_TRUE(errors.find("A0C_um_per_m"));
  EXPECT_NEAR(errors.column("R0T_um")[0], 11.5e-6 * 5 * 60e3, 0.1);
  EXPECT_SAYS(read(toy.result("report.html")), "Location errors");
}

}  // namespace
}  // namespace thermotwin::cases
