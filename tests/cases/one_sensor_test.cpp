// SPDX-License-Identifier: GPL-3.0-or-later
// `compensate` with one sensor, which is off by a constant from the first row on.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "core/table.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

/// Rows of the held-out load with readings of these sensors, the first of them off.
std::string rows_with(const std::vector<std::string>& sensors, double bias_K) {
  const auto folder = toy_run() / "campaign/mixed";
  const core::Table readings = core::read_csv(folder / "sensors.csv");
  std::istringstream inputs(read(folder / "inputs.csv"));
  std::string text, line;
  for (Eigen::Index i = -1; std::getline(inputs, line); ++i) {
    text += line;
    for (const std::string& name : sensors) {
      const double bias = name == sensors.front() ? bias_K : 0.0;
      text += i < 0 ? fmt::format(",{}_C", name) : fmt::format(",{:.3f}", readings.column(name + "_C")(i) + bias);
    }
    text += "\n";
  }
  return text;
}

struct Answer {
  double time_s = 0;
  double offset_um[3] = {}, std_um[3] = {};
  std::string status;
};

struct Answers {
  std::vector<Answer> rows;
  std::string err;
};

Answers answers(const std::vector<std::string>& sensors, double bias_K) {
  const Result result = thermotwin({"compensate", toy_model()}, rows_with(sensors, bias_K));
  EXPECT_EQ(result.status, 0) << result.err;
  Answers all{{}, result.err};
  std::istringstream out(result.out);
  std::string line;
  std::getline(out, line);
  while (std::getline(out, line)) {
    Answer row;
    std::istringstream cells(line);
    char comma = ',';
    cells >> row.time_s;
    for (double& value : row.offset_um) cells >> comma >> value;
    for (double& value : row.std_um) cells >> comma >> value;
    cells >> comma;
    std::getline(cells, row.status);
    all.rows.push_back(row);
  }
  return all;
}

TEST(OneSensor, AConstantErrorOfItIsCoveredAndNamed) {
  const Answers all = answers({"T1", "T2", "T3", "T4"}, 0.0);
  EXPECT_EQ(all.err.find("only sensor"), std::string::npos) << all.err;
  for (const double bias : {5.0, 15.0}) {
    const Answers one = answers({"T4"}, bias);
    EXPECT_SAYS(one.err, "T4_C is the only sensor: a constant error of it looks like a warm machine");
    ASSERT_EQ(one.rows.size(), all.rows.size());
    for (std::size_t i = 0; i < one.rows.size(); ++i) {
      if (one.rows[i].time_s < 900.0) continue;
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_LT(std::abs(one.rows[i].offset_um[axis] - all.rows[i].offset_um[axis]), 3.0 * one.rows[i].std_um[axis])
            << bias << " K, axis " << axis << ", row " << i;
      }
    }
    EXPECT_EQ(one.rows.back().status, "sensor_failed T4=offset");
  }
}

}  // namespace
}  // namespace thermotwin::cases
