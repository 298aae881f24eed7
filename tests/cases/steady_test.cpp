// SPDX-License-Identifier: GPL-3.0-or-later
// `simulate --steady`: steady states of the phases of a load program, beside long runs.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>

#include "core/table.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

/// Two phases, each so long that the machine has settled at its end.
void settle(const Toy& toy) {
  toy.write("loads/settle.toml",
            "schema = 1\ntitle = \"each phase settles\"\ninitial_C = 20\ntime_step_s = 600\noutput_s = 3600\n"
            "[time]\ntolerance_K = 0.001\n"
            "[[phase]]\nname = \"cold hall\"\nduration_h = 200\nair_C = 15\nspindle_rpm = 6000\ncoolant = true\n"
            "[[phase]]\nname = \"warm hall\"\nduration_h = 200\nair_C = 26\nspindle_rpm = 12000\n"
            "[[phase.axis]]\nid = \"X\"\nlow_mm = -80\nhigh_mm = 110\nfeed_mm_min = 25000\n");
}

TEST(Steady, EachPhaseIsWhatALongRunTendsTo) {
  const Toy toy;
  settle(toy);
  const std::vector<std::string> of_load{toy.path(), "--load", "settle", "--pose", "X=60,Z=50", "--json"};
  const auto arguments = [&](std::vector<std::string> more) {
    std::vector<std::string> all{"simulate"};
    all.insert(all.end(), of_load.begin(), of_load.end());
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  const Result steady = toy.run(arguments({"--steady"}));
  ASSERT_EQ(steady.status, 0) << steady.err;
  const nlohmann::json said = nlohmann::json::parse(steady.out);
  EXPECT_EQ(said["phases"][0]["phase"], "cold hall");
  EXPECT_LT(said["heat_gap"].get<double>(), 1e-6);
  const Result run = toy.run(arguments({"--output-times", "720000,1440000", "--fields-every", "1e9"}));
  ASSERT_EQ(run.status, 0) << run.err;
  const auto table = [&](const std::string& folder, const std::string& name) {
    return core::read_csv(toy.result(folder + "/settle/" + name));
  };
  const core::Table tcp = table("steady", "tcp.csv"), long_tcp = table("simulate", "tcp.csv");
  ASSERT_EQ(tcp.columns, long_tcp.columns);
  ASSERT_EQ(tcp.rows(), 2);
  const Eigen::Index shift = long_tcp.rows() - 2;  // before them the start may stand
  for (const char* column : {"dx_um", "dy_um", "dz_um", "ra_um_per_m", "rb_um_per_m", "rc_um_per_m"}) {
    for (Eigen::Index i = 0; i < 2; ++i)
      EXPECT_NEAR(tcp.column(column)[i], long_tcp.column(column)[shift + i], 0.05) << column << " phase " << i;
  }
  EXPECT_GT((tcp.values.row(1) - tcp.values.row(0)).tail(18).cwiseAbs().maxCoeff(), 5.0);
  const core::Table sensors = table("steady", "sensors.csv"), long_sensors = table("simulate", "sensors.csv");
  EXPECT_LT((sensors.values - long_sensors.values.bottomRows(2)).cwiseAbs().maxCoeff(), 0.01);
  const core::Table heat = table("steady", "heat.csv");
  EXPECT_NEAR(heat.column("stored_W").cwiseAbs().maxCoeff(), 0.0, 1e-9);
  EXPECT_NEAR(heat.column("source.spindle.bearings.power_W")[1], 300.0, 1e-6);
  EXPECT_TRUE(std::filesystem::exists(toy.result("steady/settle/fields.pvd")));
}

TEST(Steady, RefusesWhatBelongsToARun) {
  const Toy toy;
  for (const std::vector<std::string>& option : std::vector<std::vector<std::string>>{
           {"--resume"}, {"--output-times", "0,600"}, {"--fields-every", "60"}, {"--start-from-sensors", "s.csv"}}) {
    std::vector<std::string> arguments{"simulate", toy.path(), "--load", "warm_up", "--steady"};
    arguments.insert(arguments.end(), option.begin(), option.end());
    const Result result = toy.run(arguments);
    EXPECT_EQ(result.status, 2) << option.front();
    EXPECT_SAYS(result.err, option.front());
  }
}

}  // namespace
}  // namespace thermotwin::cases
