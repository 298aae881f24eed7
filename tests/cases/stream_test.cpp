// SPDX-License-Identifier: GPL-3.0-or-later
// `compensate` beside a control: rows in, offsets out, one for one.
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "core/table.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

std::string model() { return (toy_run() / "model.rom.h5").string(); }
std::string inputs() { return (toy_run() / "campaign/mixed/inputs.csv").string(); }

const std::string header = "time_s,spindle.speed_rpm,axis.X.position_mm,air.T_C\n";

TEST(Stream, AnswersEachRowBeforeTheNext) {
  Program program({"compensate", model(), "--quiet"});
  program.write(header);
  EXPECT_TRUE(program.read_line().starts_with("time_s,offset_x_um,offset_y_um,offset_z_um,"));
  for (int minute = 0; minute < 20; ++minute) {
    const std::string time = std::to_string(60 * minute);
    program.write(time + ",6000,10,20.5\n");
    EXPECT_TRUE(program.read_line().starts_with(time + ","));  // comes while the input is still open
  }
  const Result result = program.wait();
  EXPECT_EQ(result.status, 0);
  EXPECT_EQ(result.err, "");
}

TEST(Stream, PipesAndFilesGiveTheSameBytes) {
  const Toy toy;
  const Result piped = thermotwin({"compensate", model(), "--in", "-", "--out", "-"}, read(inputs()));
  EXPECT_EQ(piped.status, 0);
  EXPECT_SAYS(piped.err, "91 rows");
  EXPECT_EQ(thermotwin({"compensate", model(), "--in", inputs()}).out, piped.out);
  const Result filed = thermotwin({"compensate", model(), "--in", inputs(), "--out", toy.file("offsets.csv"), "--json"});
  EXPECT_EQ(filed.status, 0);
  EXPECT_SAYS(filed.out, "\"rows\":91");
  EXPECT_EQ(read(toy.file("offsets.csv")), piped.out);
}

// The offsets undo the error of the full model on the load that was held out: at X0 Y0 Z50 B0, which
// is one of the 27 poses, while the spindle heats up.
TEST(Stream, OffsetsAreTheErrorOfTheFullModelTurnedRound) {
  const Result result = thermotwin({"compensate", model(), "--in", inputs()});
  std::istringstream answers(result.out);
  const core::Table tcp = core::read_csv(toy_run() / "campaign/mixed/tcp.csv");
  const auto column = [&](const char* name) { return tcp.column(name); };
  const auto time = column("time_s"), x = column("X_mm"), y = column("Y_mm"), z = column("Z_mm"), b = column("B_deg");
  std::string line;
  std::getline(answers, line);
  ASSERT_TRUE(line.starts_with("time_s,offset_x_um,offset_y_um,offset_z_um,")) << line;
  int compared = 0;
  double largest = 0, worst = 0;
  while (std::getline(answers, line)) {
    double at = 0, offset[3] = {};
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf", &at, &offset[0], &offset[1], &offset[2]), 4) << line;
    if (at > 5400) break;
    for (Eigen::Index i = 0; i < time.size(); ++i) {
      if (time[i] != at || x[i] != 0 || y[i] != 0 || z[i] != 50 || b[i] != 0) continue;
      ++compared;
      const char* names[] = {"dx_um", "dy_um", "dz_um"};
      for (int k = 0; k < 3; ++k) {
        const double error = column(names[k])[i];
        largest = std::max(largest, std::abs(error));
        worst = std::max(worst, std::abs(error + offset[k]));
      }
    }
  }
  EXPECT_EQ(compared, 23);
  EXPECT_GT(largest, 20);
  EXPECT_LT(worst, 0.5);
}

TEST(Stream, UnknownColumnIsRefusedBeforeAnyAnswer) {
  const Result result = thermotwin({"compensate", model()}, "time_s,spindle.speed\n0,6000\n");
  EXPECT_EQ(result.status, 3);
  EXPECT_EQ(result.out, "");
  for (const char* words : {"standard input:1 column 2", "'spindle.speed'", "allowed: ", "nearest: spindle.speed_rpm"}) EXPECT_SAYS(result.err, words);
}

TEST(Stream, ABadRowEndsTheStreamAfterTheAnswersBeforeIt) {
  struct Bad {
    std::string row;
    std::vector<std::string> said;
  };
  const std::vector<Bad> all = {
      {"180,fast,10,20\n", {"standard input:5 spindle.speed_rpm", "'fast'"}},
      {"180,6000,10\n", {"standard input:5", "3 cells", "4, one for each column"}},
      {"60,6000,10,20\n", {"standard input:5", "runs backwards: 60 s after 120 s"}},
      {",6000,10,20\n", {"standard input:5", "no time_s"}},
      {"180,inf,10,20\n", {"standard input:5 spindle.speed_rpm", "'inf'"}},
  };
  const Toy toy;
  for (const Bad& bad : all) {
    const std::string rows = header + "0,6000,10,20\n60,6000,10,20\n120,6000,,nan\n" + bad.row + "240,6000,10,20\n";
    const Result result = thermotwin({"compensate", model()}, rows);
    EXPECT_EQ(result.status, 3);
    EXPECT_EQ(std::count(result.out.begin(), result.out.end(), '\n'), 4) << result.out;
    EXPECT_SAYS(result.err, "allowed: ");
    for (const std::string& words : bad.said) EXPECT_SAYS(result.err, words);

    // A file would look complete: it is not written at all.
    toy.write("offsets.csv", "earlier\n");
    EXPECT_EQ(thermotwin({"compensate", model(), "--out", toy.file("offsets.csv")}, rows).status, 3);
    EXPECT_EQ(read(toy.file("offsets.csv")), "earlier\n");
  }
}

TEST(Stream, NoRowsAtAll) {
  const Result empty = thermotwin({"compensate", model()}, "");
  EXPECT_EQ(empty.status, 3);
  EXPECT_SAYS(empty.err, "no header");
  const Result only_names = thermotwin({"compensate", model()}, "time_s\n");
  EXPECT_EQ(only_names.status, 0);
  EXPECT_EQ(std::count(only_names.out.begin(), only_names.out.end(), '\n'), 1);
}

TEST(Stream, WhatIsMissingIsSaid) {
  EXPECT_EQ(thermotwin({"compensate", model(), "--in", "/nowhere/rows.csv"}).status, 3);
  const Toy toy;
  toy.write("cut.rom.h5", read(model()).substr(0, 200000));
  const Result cut = thermotwin({"compensate", toy.file("cut.rom.h5")}, "time_s\n");
  EXPECT_EQ(cut.status, 3);
  EXPECT_SAYS(cut.err, "cut.rom.h5");
}

}  // namespace
}  // namespace thermotwin::cases
