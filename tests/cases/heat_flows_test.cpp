// SPDX-License-Identifier: GPL-3.0-or-later
// heat.csv of `simulate` and `campaign`: what sources give, what coolants and surroundings carry off.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <numbers>
#include <string>

#include "core/table.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Works for a day, then the coolant is switched off; a sensor tells the coolant's return.
void cool(const Toy& toy, const std::string& time = "") {
  toy.edit("machine.toml", "[tcp]\n", "[[sensor]]\nid = \"R\"\nreturn_of = \"main\"\n\n[tcp]\n");
  toy.write("loads/day.toml",
            "schema = 1\ntitle = \"a day at 9000 rpm, then without coolant\"\ninitial_C = 20\ntime_step_s = "
            "300\noutput_s = 1800\n" +
                time +
                "[[phase]]\nname = \"work\"\nduration_h = 24\nair_C = 20\nspindle_rpm = 9000\ncoolant = true\n"
                "[[phase]]\nname = \"coolant off\"\nduration_h = 2\ncoolant = false\n");
}

core::Table heat_of(const Toy& toy, const std::string& verb) {
  const Result result = toy.run({verb, toy.path(), "--load", "day", "--json"});
  EXPECT_EQ(result.status, 0) << result.err;
  return core::read_csv(toy.result(verb + "/day/heat.csv"));
}

/// Stored less what came in, over what flowed, of the worst row.
double imbalance(const core::Table& heat) {
  double worst = 0.0;
  for (Index i = 1; i < heat.rows(); ++i) {
    double in = 0.0, flowed = 0.0;
    for (std::size_t c = 2; c < heat.columns.size(); ++c) {
      const std::string& name = heat.columns[c];
      const double power = heat.values(i, c);
      if (name == "coolant.main.cooling_power_W")
        in -= power;
      else if (name.starts_with("coolant."))
        continue;  // segments: parts of it
      else
        in += power;
      flowed += std::abs(power);
    }
    worst = std::max(worst, std::abs(heat.values(i, 1) - in) / flowed);
  }
  return worst;
}

class HeatFlows : public ::testing::TestWithParam<const char*> {};

TEST_P(HeatFlows, ACoolantCarriesOffItsFlowTimesItsRise) {
  const Toy toy;
  cool(toy, GetParam());
  const core::Table heat = heat_of(toy, "simulate");
  ASSERT_EQ(heat.rows(), 53);
  EXPECT_EQ(heat.columns[1], "stored_W");
  EXPECT_LT(imbalance(heat), 1e-6);
  const VectorXd cooling = heat.column("coolant.main.cooling_power_W"),
                 stator = heat.column("source.spindle.bearings.power_W");
  EXPECT_TRUE(std::isnan(cooling[0]));  // nothing has flowed yet
  // The law of machine.toml: 120 W at 6000 rpm, 300 W at 12000 rpm.
  for (Index i = 1; i < heat.rows(); ++i) EXPECT_NEAR(stator[i], 210.0, 1e-6);
  // Gebhardt (5.20): m c (outlet - inlet); the inlet follows the reading of T3.
  const core::Table sensors = core::read_csv(toy.result("simulate/day/sensors.csv"));
  const VectorXd rise = sensors.column("R_C") - sensors.column("T3_C");
  EXPECT_GT(rise[48], 0.5);
  EXPECT_NEAR(cooling[48], 0.05 * 1940.0 * rise[48], 0.005 * cooling[48]);
  // At the end of the day the fluid stores nothing more: its segments' walls give what the chiller takes.
  const double walls =
      heat.column("coolant.main.spindle.cooling_power_W")[48] + heat.column("coolant.main.column.cooling_power_W")[48];
  EXPECT_NEAR(walls, cooling[48], 0.002 * cooling[48]);
  // A coolant that is off carries nothing to its chiller; standing in its channel it still takes from one wall and
  // gives to the other.
  EXPECT_EQ(cooling[50], 0.0);
  EXPECT_EQ(cooling[52], 0.0);
}

INSTANTIATE_TEST_SUITE_P(Schemes, HeatFlows, ::testing::Values("", "[time]\ntolerance_K = 0.01\n"));

// Gebhardt (2014), Fig. 4.31: steps of a swivel axis to 90 deg and back, and the power of its drive that holds it.
TEST(HeatFlowsOfAHoldingAxis, DependOnTheSideThatItCameFrom) {
  const Toy toy;
  toy.edit("machine.toml", "[tcp]\n",
           "[[source]]\nid = \"B.hold\"\nplace = [{surface = \"swivel.skin\"}]\nlaw = [{kind = \"holding\", motion = "
           "\"B\", full_power_W = 350, linear_share = 1, friction_share = 0.14}]\n\n[tcp]\n");
  std::string load = "schema = 1\ninitial_C = 20\ntime_step_s = 30\noutput_s = 30\n";
  for (int step = 1; step <= 36; ++step) {
    load += fmt::format("[[phase]]\nduration_s = 30\n[[phase.axis]]\nid = \"B\"\nposition_deg = {}\n",
                        step <= 18 ? 5 * step : 5 * (36 - step));
  }
  toy.write("loads/day.toml", load);
  const core::Table heat = heat_of(toy, "simulate");
  const VectorXd power = heat.column("source.B.hold.power_W");
  ASSERT_EQ(power.size(), 37);
  for (int step = 1; step <= 36; ++step) {
    const double angle = (step <= 18 ? 5 * step : 5 * (36 - step)) * std::numbers::pi / 180.0;
    EXPECT_NEAR(power[step], 350.0 * std::abs(std::sin(angle) + (step <= 18 ? 0.14 : -0.14)), 1e-6) << step;
  }
}

TEST(HeatFlowsOfACampaign, AreThoseOfTheSimulationAndOutliveAResume) {
  const Toy toy;
  cool(toy);
  const core::Table one = heat_of(toy, "simulate"), all = heat_of(toy, "campaign");
  EXPECT_EQ(all.columns, one.columns);
  ASSERT_EQ(all.rows(), one.rows());
  EXPECT_LT((all.values - one.values).bottomRows(all.rows() - 1).cwiseAbs().maxCoeff(), 1e-9);
  const std::string before = read(toy.result("campaign/day/heat.csv"));
  const Result again = toy.run({"campaign", toy.path(), "--load", "day", "--resume"});
  EXPECT_EQ(again.status, 0) << again.err;
  EXPECT_EQ(read(toy.result("campaign/day/heat.csv")), before);
}

TEST(HeatFlowsOfASimulation, AreInItsSummary) {
  const Toy toy;
  cool(toy);
  const Result result = toy.run({"simulate", toy.path(), "--load", "day", "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  const nlohmann::json of_coolant = nlohmann::json::parse(result.out)["cooling_power_W"]["main"];
  const VectorXd cooling = core::read_csv(toy.result("simulate/day/heat.csv")).column("coolant.main.cooling_power_W");
  EXPECT_NEAR(of_coolant["largest"].get<double>(), cooling.tail(52).maxCoeff(), 1e-6);
  EXPECT_NEAR(of_coolant["mean"].get<double>(), cooling.tail(52).mean(), 1e-6);
  EXPECT_EQ(of_coolant["end"].get<double>(), 0.0);
}

TEST(HeatFlowsOfASimulation, AFilmOfAVolumeHasWhatTheVolumeGives) {
  const Toy toy;
  toy.edit("machine.toml", "[tcp]\n", R"([[volume]]
id = "tank"
content_l = 20
[[film]]
id = "of_tank"
surfaces = ["column.skin"]
ambient = "tank"
film_coefficient_W_m2K = 50
[[source]]
id = "pump"
law = [{input = "machine.on", at = [0, 1], power_W = [0, 300]}]
place = [{volume = "tank"}]
[[sensor]]
id = "tank"
volume = "tank"

[tcp]
)");
  cool(toy);
  const core::Table heat = heat_of(toy, "simulate"), sensors = core::read_csv(toy.result("simulate/day/sensors.csv"));
  const VectorXd film = heat.column("film.of_tank.power_W"), time = heat.column("time_s"),
                 tank = sensors.column("tank_C");
  EXPECT_GT(film[20], 50.0) << "into the bodies";
  for (const Index i : {Index(2), Index(10), Index(40)}) {
    const double stored = 20 * 4180.0 * (tank[i] - tank[i - 1]) / (time[i] - time[i - 1]);
    EXPECT_NEAR(film[i], 300.0 - stored, 0.01 * 300.0) << i;
  }
}

TEST(HeatFlowsOfASimulation, ACoolantThatHeatsSaysSo) {
  const Toy toy;
  toy.edit("machine.toml", "guide_sensor = \"T3\"\n", "guide_ambient = \"air\"\nguide_offset_K = 8\n");
  toy.write("loads/warm.toml",
            "schema = 1\ntitle = \"a warm coolant\"\ninitial_C = 20\ntime_step_s = 300\noutput_s = 1800\n"
            "[[phase]]\nname = \"on\"\nduration_h = 2\nair_C = 20\ncoolant = true\n");
  const Result result = toy.run({"simulate", toy.path(), "--load", "warm"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_SAYS(result.out, "coolant main heats by ");
  for (const char* contradiction : {"removes -", "heats by -", "-0.0 kJ", "W on average, -"})
    EXPECT_EQ(result.out.find(contradiction), std::string::npos) << contradiction << "\n" << result.out;
}

TEST(HeatFlowsOfASteadyState, AreNoImbalanceWhereAllIsAtOneTemperature) {
  const Toy toy;
  toy.write("loads/rest.toml",
            "schema = 1\ntitle = \"all at 27.3 degC\"\ninitial_C = 20\n[[phase]]\nname = \"rest\"\nduration_h = 1\n"
            "air_C = 27.3\nmachine_on = false\ncoolant = false\n");
  const Result result = toy.run({"simulate", toy.path(), "--load", "rest", "--steady", "--json"});
  ASSERT_EQ(result.status, 0) << result.err;
  EXPECT_LT(nlohmann::json::parse(result.out)["heat_gap"].get<double>(), 1e-6);
}

}  // namespace
}  // namespace thermotwin::cases
