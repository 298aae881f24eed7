// SPDX-License-Identifier: GPL-3.0-or-later
// `nc` on the heat of short programs, and on what lies ahead of a series of parts.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/table.h"
#include "tests/cases/nc_programs.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

using nlohmann::json;

class NcSeries : public testing::Test {
protected:
  void SetUp() override {
    if (!has_interpreter()) GTEST_SKIP() << "the program was built without LinuxCNC's interpreter";
  }
  json run(const std::string& text, std::vector<std::string> more) {
    toy.write("part.ngc", text);
    std::vector<std::string> arguments = {"nc", toy_model(), toy.file("part.ngc"), "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Result result = toy.run(arguments);
    EXPECT_EQ(result.status, 0) << result.err;
    return result.status == 0 ? json::parse(result.out) : json();
  }
  /// (axes) mean offsets of a part, um. @param part  from 0; -1: the last one
  Eigen::Vector3d mean(Eigen::Index part) const {
    const core::Table parts = core::read_csv(toy.result("parts.csv"));
    Eigen::Vector3d values;
    for (Eigen::Index i = 0; const char* axis : {"X", "Y", "Z"}) {
      const Eigen::VectorXd column = parts.column(fmt::format("mean_offset_{}_um", axis));
      values[i++] = column[part < 0 ? column.size() - 1 : part];
    }
    return values;
  }
  double last_error_z() const {
    const core::Table blocks = core::read_csv(toy.result("blocks.csv"));
    return blocks.column("dz_um")[blocks.rows() - 1];
  }
  Toy toy;
};

// A program that is shorter than a row heats the machine as its rows of a second do.
TEST_F(NcSeries, TheLastRowHeatsTheMachine) {
  const std::string text = "G21 G90\nM3 S9000\nG0 X0 Y0 Z50\nG4 P900\nG1 X10 F1000\nG4 P90\nG1 X0\nM2\n";
  run(text, {"--row-s", "2"});
  const double fine = last_error_z();
  ASSERT_GT(std::abs(fine), 1.0) << "the program heats too little to show anything";
  for (const char* row : {"600", "3600"}) {
    run(text, {"--row-s", row});
    EXPECT_NEAR(last_error_z(), fine, 0.15 * std::abs(fine)) << row;  // one implicit step of the whole row
  }
  run("G21 G90\nM3 S9000\nG0 X0 Y0 Z50\nG1 X100 F2000\nM2\n", {});
  EXPECT_NE(last_error_z(), 0.0) << "a program of less than --row-s";
}

// The drift ahead of a short series is what a long one shows. Rows and parts are not in step, so that the means of
// parts vary by some 0.3 um.
TEST_F(NcSeries, DriftAheadIsThatOfALongSeries) {
  const std::string text =
      "G21 G90\nM3 S9000\nG0 Z50\no1 repeat [8]\nG1 X100 F20000\nX-100\no1 endrepeat\nG4 P100\nM2\n";
  const auto series = [&](const char* parts) {
    return run(text,
               {"--repeat", parts, "--pause", "60", "--tolerance", "2", "--row-s", "20", "--no-page", "--no-blocks"});
  };
  const json endless = series("1000");
  EXPECT_EQ(endless["settled"], true);
  EXPECT_LT(endless["drift_ahead_um"].get<double>(), 0.3);
  const Eigen::Vector3d end = mean(-1);
  for (const char* parts : {"2", "5", "20", "60"}) {
    const json summary = series(parts);
    const double ahead = (end - mean(-1)).cwiseAbs().maxCoeff();
    EXPECT_NEAR(summary["drift_ahead_um"].get<double>(), ahead, 0.5 + 0.05 * ahead) << parts;
    EXPECT_EQ(summary["settled"], ahead <= 2.0) << parts << " " << ahead;
  }
  EXPECT_TRUE(run(text, {"--repeat", "2", "--tolerance", "2"})["drift_ahead_um"].is_number());
}

// The page's largest error is that of all parts, not of the last one.
TEST_F(NcSeries, ThePageNamesTheLargestErrorOfAllParts) {
  run("G21 G90\nM3 S9000\nG0 Z50\nG1 X100 F20000\nX-100\nG4 P900\nM2\n",
      {"--repeat", "4", "--pause", "60", "--start-C", "32"});
  const core::Table blocks = core::read_csv(toy.result("blocks.csv"));
  double largest = 0.0;
  int part = 0;
  for (Eigen::Index i = 0; i < blocks.rows(); ++i) {
    const double error = std::hypot(blocks.column("dx_um")[i], blocks.column("dy_um")[i], blocks.column("dz_um")[i]);
    if (blocks.column("rapid")[i] != 0.0 || error <= largest) continue;
    largest = error;
    part = static_cast<int>(blocks.column("part")[i]);
  }
  EXPECT_LT(part, 4) << "the last part is the worst";
  const std::string text = read(toy.result("report.html"));
  EXPECT_SAYS(text, fmt::format("The largest TCP error of a cut is {:.1f} µm", largest));
  EXPECT_SAYS(text, fmt::format(" of part {} after", part));
}

}  // namespace
}  // namespace thermotwin::cases
