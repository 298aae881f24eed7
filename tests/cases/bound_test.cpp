// SPDX-License-Identifier: GPL-3.0-or-later
// The bound of `campaign --reduced --bound` against the full model's own tables, as `reduce` leaves both.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>

#include "core/table.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;

constexpr double file_rounding_um = 2e-4;
constexpr Eigen::Index outputs = 6;

/// Row of the table with the same time and axis positions.
Eigen::Index row_like(const core::Table& table, const Eigen::RowVectorXd& key) {
  for (Eigen::Index row = 0; row < table.rows(); ++row)
    if ((table.values.row(row).head(key.size()) - key).lpNorm<Eigen::Infinity>() < 1e-9) return row;
  ADD_FAILURE() << "no row at time " << key(0) << " s and this pose in " << table.source;
  return 0;
}

/// The toy's bed and column alone: no axes, and the column is held on mounts of its own.
void write_block(const Toy& toy) {
  toy.write("machine.toml", R"(schema = 1
name = "block"
reference_C = 20.0
[mesh]
coarse = 1.0
[[material]]
id = "iron"
density_kg_m3 = 7200
specific_heat_J_kgK = 500
conductivity_W_mK = 46
expansion_1_K = 11.0e-6
young_GPa = 120
poisson = 0.26
[[body]]
id = "bed"
material = "iron"
cad = "cad/bed.stl"
element_size_mm = 130
[[body]]
id = "column"
material = "iron"
cad = "cad/column.stl"
element_size_mm = 110
parent = "bed"
[[surface]]
id = "bed.feet"
body = "bed"
rule = {normal = [0, 0, -1]}
[[surface]]
id = "bed.top"
body = "bed"
rule = {normal = [0, 0, 1]}
[[surface]]
id = "bed.skin"
body = "bed"
except = ["bed.feet"]
[[surface]]
id = "column.foot"
body = "column"
rule = {normal = [0, 0, -1]}
[[surface]]
id = "column.top"
body = "column"
rule = {normal = [0, 0, 1]}
[[surface]]
id = "column.skin"
body = "column"
except = ["column.foot"]
[[joint]]
id = "feet"
kind = "mount"
slave = "bed.feet"
ambient = "foundation"
conductance_W_m2K = 15
stiffness_normal_N_mm3 = 20
stiffness_tangential_N_mm3 = 20
divide = [2, 2, 1]
[[joint]]
id = "column_foot"
kind = "bolted"
slave = "column.foot"
master = "bed.top"
conductance_W_m2K = 3000
stiffness_normal_N_mm3 = 500
stiffness_tangential_N_mm3 = 500
divide = [2, 2, 1]
[[ambient]]
id = "air"
default_C = 20
[[ambient]]
id = "foundation"
follows = "air"
[[film]]
id = "skin"
surfaces = ["bed.skin", "column.skin"]
film_coefficient_W_m2K = 8
[[source]]
id = "motor"
law = [{input = "machine.on", at = [0, 1], power_W = [0, 300]}]
place = [{surface = "column.top"}]
[[sensor]]
id = "T1"
body = "bed"
point_mm = [200, 0, -300]
[tcp]
tool_body = "column"
tool_surface = "column.top"
tool_point_mm = [0, 300, 250]
table_body = "bed"
table_surface = "bed.top"
table_point_mm = [0, 0, -250]
)");
  toy.write("case.toml", R"(schema = 1
machine = "machine.toml"
train = ["ambient"]
holdout = ["mixed"]
[reduction]
tolerance_um = 0.1
)");
  toy.write("loads/mixed.toml", R"(schema = 1
title = "on and off in a warmer hall"
initial_C = 20.0
time_step_s = 120
output_s = 600
[[phase]]
duration_h = 2
air_C = [20, 22]
machine_on = true
[[phase]]
duration_h = 1
machine_on = false
)");
}

/// Every number of error_bound.csv is at least the difference of the two models' tables.
/// @param keys  columns before the outputs: time and axes
void expect_bounded(const Toy& toy, Eigen::Index keys) {
  const core::Table full = core::read_csv(toy.result("campaign/mixed/tcp.csv"));
  const core::Table model = core::read_csv(toy.result("campaign_reduced/mixed/tcp.csv"));
  const core::Table bound = core::read_csv(toy.result("campaign_reduced/mixed/error_bound.csv"));
  ASSERT_EQ(bound.values.cols(), keys + outputs);
  ASSERT_GT(bound.rows(), 1);
  double least = 1e300, largest_error = 0;
  int violated = 0;
  for (Eigen::Index row = 0; row < bound.rows(); ++row) {
    const Eigen::RowVectorXd key = bound.values.row(row).head(keys);
    const Eigen::Index of_full = row_like(full, key), of_model = row_like(model, key);
    for (Eigen::Index k = keys; k < bound.values.cols(); ++k) {
      const double error = std::abs(full.values(of_full, k) - model.values(of_model, k)), limit = bound.values(row, k);
      largest_error = std::max(largest_error, error);
      if (error > limit + file_rounding_um) ++violated;
      if (error > file_rounding_um) least = std::min(least, limit / error);
    }
  }
  EXPECT_GT(largest_error, 10 * file_rounding_um) << "nothing to bound";
  EXPECT_EQ(violated, 0) << "of " << bound.rows() * outputs << " entries; least bound / error " << least;
}

TEST(Bound, HoldsInEveryEntryWithAReferenceBesideTheModel) {
  const Toy toy;
  toy.make_affine();
  const Result reduced = toy.run({"reduce", toy.path(), "--bound"});
  ASSERT_EQ(reduced.status, 0) << reduced.err;
  ASSERT_TRUE(fs::exists(toy.result("reference.rom.h5"))) << "the test is of a model with its reference";
  const auto before = files_in(toy.result("campaign"));
  const Result ran = toy.run({"campaign", toy.path(), "--reduced", "--bound", "--load", "mixed", "--json"});
  ASSERT_EQ(ran.status, 0) << ran.err;
  EXPECT_EQ(files_in(toy.result("campaign")), before) << "the full model's tables were touched";
  const auto load = nlohmann::json::parse(ran.out)["loads"][0];
  EXPECT_LE(load["estimate_at_bound_poses_um"].get<double>(), load["estimate_um"].get<double>());
  EXPECT_LE(load["estimate_at_bound_poses_um"].get<double>(), load["bound_um"].get<double>()) << "at the same pose";

  expect_bounded(toy, 6);
}

TEST(Bound, AMachineWithoutAxesHasOneTooAndNoEmptyNames) {
  const Toy toy;
  write_block(toy);
  const Result reduced = toy.run({"reduce", toy.path(), "--bound"});
  ASSERT_EQ(reduced.status, 0) << reduced.err;
  const Result ran = toy.run({"campaign", toy.path(), "--reduced", "--bound", "--load", "mixed"});
  ASSERT_EQ(ran.status, 0) << ran.err;
  EXPECT_SAYS(ran.out, "bounds at the only pose");
  EXPECT_SAYS(ran.out, "estimated at the bound's poses um");
  EXPECT_EQ(reduced.out.find("between the stored ones"), std::string::npos) << reduced.out;
  expect_bounded(toy, 1);
}

TEST(Bound, AMachineWithoutAxesAndSensorsGoesThroughValidation) {
  const Toy toy;
  write_block(toy);
  const std::string text = read(toy.file("machine.toml"));
  const auto sensor = text.find("[[sensor]]"), tcp = text.find("[tcp]");
  toy.write("machine.toml", text.substr(0, sensor) + text.substr(tcp));
  const Result reduced = toy.run({"reduce", toy.path(), "--bound"});
  ASSERT_EQ(reduced.status, 0) << reduced.err;
  EXPECT_SAYS(reduced.out, "no sensors");
  const Result ran = toy.run({"campaign", toy.path(), "--reduced", "--bound", "--load", "mixed"});
  ASSERT_EQ(ran.status, 0) << ran.err;
  expect_bounded(toy, 1);
  const Result validated = toy.run({"validate", toy.path(), "--draws", "2"});
  EXPECT_EQ(validated.status, 0) << validated.err;
  EXPECT_EQ(validated.out.find("nan"), std::string::npos) << validated.out;
}

TEST(Bound, IsRefusedBeforeAnythingIsMadeWhereTheEquationIsNotAffine) {
  const Toy toy;
  const Result result = toy.run({"reduce", toy.path(), "--bound"});
  EXPECT_EQ(result.status, 3);
  EXPECT_SAYS(result.err, "radiation = \"exact\"");
  EXPECT_SAYS(result.err, "machine.toml: [[film]] id = ");
  EXPECT_FALSE(fs::exists(toy.result("cache"))) << "a mesh was made first";
}

TEST(Bound, WhatFollowsTheMachinesOwnTemperaturesIsSaidNotToBeCovered) {
  const Toy toy;
  toy.edit("machine.toml", "radiation = \"exact\"", "radiation = \"linear\"");
  toy.edit("machine.toml", "[[joint]]\n", "[[joint]]\ntemperature_at_C = [0, 60]\ntemperature_factor = [0.8, 1.4]\n");
  const Result reduced = toy.run({"reduce", toy.path(), "--bound"});
  ASSERT_EQ(reduced.status, 0) << reduced.err;
  EXPECT_SAYS(reduced.err, "coolant 'main'");
  EXPECT_SAYS(reduced.err, "(temperature_factor)");
}

}  // namespace
}  // namespace thermotwin::cases
