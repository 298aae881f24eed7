// SPDX-License-Identifier: GPL-3.0-or-later
// `measure`: budgets by both methods, R-Tests to a folder that `evaluate` reads, ISO 230-3 tables, slips.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "core/file.h"
#include "core/table.h"
#include "tests/cases/texts.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

namespace fs = std::filesystem;

std::string budget(const std::string& name) { return (source_tree() / "cases/budgets" / name).string(); }

TEST(Measure, BudgetsByBothMethods) {
  const Toy toy;
  const Result result = toy.run({"measure", "uncertainty", budget("jcgm101_rectangular.toml"), "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const nlohmann::json found = nlohmann::json::parse(result.out);
  const nlohmann::json& dominated = found["quantities"][1];
  EXPECT_NEAR(dominated["gum"]["expanded"].get<double>(), 19.9, 0.1);
  EXPECT_NEAR(dominated["monte_carlo"]["interval"][1].get<double>(), 17.0, 0.05);
  EXPECT_EQ(dominated["verdict"], "disagree");
  EXPECT_EQ(found["quantities"][0]["verdict"], "agree");
  EXPECT_TRUE(fs::exists(toy.result("uncertainty.json")));
  const Result text = toy.run({"measure", "uncertainty", budget("jcgm101_rectangular.toml")});
  for (const char* words : {"dominated: GUM and Monte Carlo: disagree", "alike: GUM and Monte Carlo: agree"})
    EXPECT_SAYS(text.out, words);
}

// A length of 50 mm in nm with an uncertainty of 25 nm needs eight digits.
TEST(Measure, BudgetsHaveTheDigitsOfTheirUncertainty) {
  const Toy toy;
  toy.write("length.toml",
            "schema = 1\ninput = [{name = \"a\", unit = \"nm\", value = 50000623, std = 25}]\n"
            "quantity = [{name = \"l\", unit = \"nm\", formula = \"a + 215\"}]\n");
  const Result text = toy.run({"measure", "uncertainty", toy.file("length.toml")});
  ASSERT_EQ(text.status, 0) << text.err;
  EXPECT_SAYS(text.out, "50000838");
  EXPECT_SAYS(text.out, "50000789");
}

TEST(Measure, ArcsAreDrawn) {
  const Toy toy;
  const Result result = toy.run({"measure", "uncertainty", "--arc", "90,150", "--draws", "200", "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const nlohmann::json found = nlohmann::json::parse(result.out);
  EXPECT_NEAR(found["arcs"][0]["centre_along"]["theory"].get<double>(), 0.655, 0.01);
  EXPECT_NEAR(found["arcs"][1]["tilt_across"]["theory"].get<double>(), 0.37, 0.01);
  EXPECT_EQ(core::read_csv(toy.result("arcs.csv")).rows(), 400);
  EXPECT_TRUE(fs::exists(toy.result("arcs.svg")));
}

/// An R-Test of C at B = 0 with the errors of a table that shifts by 10 um in x, tilts by 50 um/m about x and grows by
/// 6 um at 300 mm, each an hour more.
void write_rtest(const Toy& toy, const std::string& more = "") {
  toy.write("rtest/rtest.toml",
            "schema = 1\nchain = \"V [w C' B' b Y X Z (C1) t]\"\nstd_um = 0.5\naxis = [{id = \"C\", "
            "with_letter = true}]\n" +
                more);
  std::string points = "time_s,cycle,C_deg,x_mm,y_mm,z_mm,dx_um,dy_um,dz_um\n";
  for (int cycle = 0; cycle < 3; ++cycle) {
    for (int i = 0; i < 5; ++i) {
      const double angle = 90.0 * i, c = std::cos(angle * std::numbers::pi / 180),
                   s = std::sin(angle * std::numbers::pi / 180);
      const double x = 0.2 * c, y = 0.2 * s, z = 0.05, a = 50.0 * cycle, growth = 6.0 * cycle / 0.3;
      for (const double value : {3600.0 * cycle + 10.0 * i, cycle + 1.0, angle, 1e3 * x, 1e3 * y, 1e3 * z,
                                 -(10.0 * cycle + growth * x), -(-a * z + growth * y), -(a * y)})
        points += std::to_string(value) + ",";
      points.back() = '\n';
    }
  }
  toy.write("rtest/points.csv", points);
}

TEST(Measure, RTestBecomesAFolderThatEvaluateReads) {
  const Toy toy;
  write_rtest(toy);
  std::string loads = "time_s,n,air\n";
  for (int i = 0; i < 40; ++i) loads += std::to_string(200 * i) + "," + std::to_string(i < 20 ? 3000 : 0) + ",21\n";
  toy.write("loads/data.csv", loads);
  toy.write("loads/channels.toml",
            "[[channel]]\nid = 'n'\nkind = 'speed'\nunit = 'rpm'\n[[channel]]\nid = 'air'\nkind = "
            "'temperature'\nunit = 'degC'\nuncertainty = 0.1\n");
  const Result result = toy.run({"measure", "analyse", toy.file("rtest"), "--record", toy.file("loads"), "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const nlohmann::json found = nlohmann::json::parse(result.out), errors = found["cycles"][2]["errors"];
  EXPECT_NEAR(errors["X0C"]["value"].get<double>(), 20.0, 0.01);
  EXPECT_NEAR(errors["Y0C"]["value"].get<double>(), 0.0, 0.01);
  EXPECT_NEAR(errors["A0C"]["value"].get<double>(), 100.0, 0.05);
  EXPECT_NEAR(errors["R0T"]["value"].get<double>(), 12.0, 0.01);
  const core::Table table = core::read_csv(toy.result("location_errors.csv"));
  EXPECT_NEAR(table.column("X0C_um")[1], 10.0, 0.01);
  EXPECT_GT(table.column("std_R0T_um")[1], 0.0);
  const fs::path folder = toy.result("measurement");
  EXPECT_EQ(core::read_csv(folder / "data.csv").rows(), 43);
  const Result evaluated = thermotwin({"evaluate", "--data", folder.string(), "--out", toy.result("e").string(),
                                       "--models", "static_regression", "--json", "--quiet"});
  EXPECT_EQ(evaluated.status, 0) << evaluated.err;
}

TEST(Measure, ThermalTable) {
  const Toy toy;
  std::string data = "time_s,air,z\n";
  for (int i = 0; i < 25; ++i)
    data += std::to_string(600 * i) + "," + std::to_string(20 + 0.1 * i) + "," + std::to_string(0.3 * i) + "\n";
  toy.write("etve/data.csv", data);
  toy.write("etve/channels.toml",
            "[[channel]]\nid = 'air'\nkind = 'temperature'\nunit = 'degC'\nuncertainty = "
            "0.1\n[[channel]]\nid = 'z'\nkind = 'displacement'\nunit = 'um'\nuncertainty = 0.2\n");
  const Result result = toy.run({"measure", "analyse", toy.file("etve"), "--ambient", "air", "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const nlohmann::json row = nlohmann::json::parse(result.out)["rows"][0];
  EXPECT_NEAR(row["range_first_hour"].get<double>(), 1.8, 1e-9);
  EXPECT_NEAR(row["range"].get<double>(), 7.2, 1e-9);
  EXPECT_NEAR(row["gradient_per_K"].get<double>(), 3.0, 1e-6);
}

/// A test of four hours whose displacement rises by `slope` um a row.
void write_test(const Toy& toy, const std::string& name, const std::string& channel, double slope) {
  std::string data = "time_s," + channel + "\n";
  for (int i = 0; i < 25; ++i) data += std::to_string(600 * i) + "," + std::to_string(slope * i) + "\n";
  toy.write(name + "/data.csv", data);
  toy.write(name + "/channels.toml",
            "[[channel]]\nid = '" + channel + "'\nkind = 'displacement'\nunit = 'um'\nuncertainty = 0.2\n");
}

TEST(Measure, SeveralTestsMakeOneTable) {
  const Toy toy;
  write_test(toy, "spindle", "z", 0.3);
  write_test(toy, "x_axis", "z", 1.0);
  write_test(toy, "c_axis", "x", 2.0);
  const std::vector<std::string> all{"measure", "analyse", toy.file("spindle"), toy.file("x_axis"), toy.file("c_axis")};
  const Result result = toy.run(all);
  ASSERT_EQ(result.status, 0) << result.err;
  for (const char* words : {"spindle", "x_axis", "c_axis", "1.8 / 7.2", "6 / 24", "12 / 48"})
    EXPECT_SAYS(result.out, words);
  const nlohmann::json tests = nlohmann::json::parse(core::read_file(toy.result("thermal_tests.json")))["tests"];
  ASSERT_EQ(tests.size(), 3U);
  EXPECT_EQ(tests[1]["test"], "x_axis");
  EXPECT_NEAR(tests[1]["rows"][0]["range"].get<double>(), 24.0, 1e-9);
  EXPECT_SAYS(core::read_file(toy.result("thermal_tests.csv")), "\"c_axis\",\"x\",um,25,12,48,");
  std::vector<std::string> wrong = all;
  wrong.push_back(toy.path());
  const Result refused = toy.run(wrong);
  EXPECT_EQ(refused.status, 3);
  for (const char* words : {"no channels.toml", "ISO 230-3"}) EXPECT_SAYS(refused.err, words);
  wrong = all;
  wrong.insert(wrong.end(), {"--channels", "points"});
  EXPECT_EQ(toy.run(wrong).status, 2);
}

TEST(Measure, SlipsLeaveNothingBehind) {
  const Toy toy;
  toy.write("budget.toml", "schema = 1\n[[input]]\nname = 'a'\nstd = -1\n");
  const Result negative = toy.run({"measure", "uncertainty", toy.file("budget.toml")});
  EXPECT_EQ(negative.status, 3);
  for (const char* words : {"budget.toml:4", "-1", "at least 0"}) EXPECT_SAYS(negative.err, words);
  write_rtest(toy, "errors = ['X0Q']\n");
  const Result unknown = toy.run({"measure", "analyse", toy.file("rtest")});
  EXPECT_EQ(unknown.status, 3);
  for (const char* words : {"rtest.toml", "'X0Q'", "nearest: X0"}) EXPECT_SAYS(unknown.err, words);
  EXPECT_FALSE(fs::exists(toy.result("uncertainty.json")));
  EXPECT_FALSE(fs::exists(toy.result("measurement")));
  EXPECT_EQ(toy.run({"measure", "analyse", toy.path()}).status, 3);
}

TEST(Measure, WrongUsage) {
  const Toy toy;
  EXPECT_EQ(toy.run({"measure"}).status, 2);
  EXPECT_EQ(toy.run({"measure", "uncertainty"}).status, 2);
  const Result verb = thermotwin({"measure", "analize", "x"});
  EXPECT_EQ(verb.status, 2);
  for (const char* words : {"'analize'", "nearest: analyse", "thermotwin measure --help"}) EXPECT_SAYS(verb.err, words);
  const Result option = thermotwin({"measure", "uncertainty", "--ark", "90"});
  EXPECT_EQ(option.status, 2);
  for (const char* words : {"'--ark'", "nearest: --arc", "thermotwin measure uncertainty --help"})
    EXPECT_SAYS(option.err, words);
}

// The largest double has 309 digits; nobody wants to read them.
TEST(Measure, ANumberThatIsNotPositiveIsRefusedInAShortSentence) {
  for (const char* radius : {"0", "-3", "inf", "wide"}) {
    const Result result = thermotwin({"measure", "uncertainty", "--arc", "90", "--radius", radius});
    EXPECT_EQ(result.status, 2) << radius;
    EXPECT_SAYS(result.err, fmt::format("--radius: {} is not a finite number above 0", radius));
    EXPECT_LT(result.err.size(), 200u);
  }
}

}  // namespace
}  // namespace thermotwin::cases
