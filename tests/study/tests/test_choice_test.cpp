// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/tests/test_choice.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/error.h"
#include "study/tests/stated_parameters.h"
#include "tests/machines/rods.h"

namespace thermotwin::study {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double hour = 3600.0;

class Choices : public ::testing::Test {
protected:
  static TestSetup setup() {
    TestSetup of;
    of.parameters = stated_parameters(machine(), false);
    of.sensors = {1, 3};
    of.probes = {mesh::home_pose(machine())};
    return of;
  }
  static const mesh::Machine& machine() { return model().machine; }
  static const reduction::ReducedModel& model() {
    static const reduction::ReducedModel made = lumped::model(lumped::machine(), 5);
    return made;
  }
  static std::vector<TestBlock> made_blocks() {
    BlockOptions options;
    options.probe_pose = mesh::home_pose(machine());
    return standard_blocks(machine(), options);
  }
  static MatrixXd prediction_of(const TestRun& run) {
    const solver::LoadProgram load = solver::LoadProgram::parse(
        "schema = 1\n[[phase]]\nduration_h = 3\nspindle_rpm = 9000\n[[phase.axis]]\nid = \"Z\"\nlow_mm = 0\nhigh_mm = "
        "400\nfeed_mm_min = 15000\n",
        "load.toml", machine());
    return run.prediction({load}, mesh::workspace_poses(machine()));
  }

  std::vector<TestBlock> blocks_ = made_blocks();
  TestRun run_{model(), VectorXd::Ones(std::ssize(setup().parameters)), setup()};
  MatrixXd prediction_ = prediction_of(run_);
  TestChoice choice_{run_, blocks_, prediction_};
};

TEST_F(Choices, VarianceIsThatOfTheLinearUpdate) {
  const TestOrder order{&blocks_[3], &blocks_[5], &blocks_[0]};
  const TestPath path = choice_.evaluate(order);
  // Reading after reading, in the covariance instead of the information.
  TestRun run(model(), VectorXd::Ones(std::ssize(setup().parameters)), setup());
  MatrixXd covariance = MatrixXd::Identity(setup().unknowns(), setup().unknowns());
  const Index count = prediction_.rows();
  for (std::size_t b = 0; b < order.size(); ++b) {
    run.run(*order[b], [&](const TestReadings& readings) {
      const MatrixXd gain =
          covariance * readings.rows.transpose() *
          (readings.rows * covariance * readings.rows.transpose() + MatrixXd(readings.std.cwiseAbs2().asDiagonal()))
              .inverse();
      covariance -= gain * readings.rows * covariance;
    });
    const double variance = prediction_.cwiseProduct(covariance.topLeftCorner(count, count)).sum();
    EXPECT_NEAR(path.variance_um2[b], variance, 1e-6 * variance);
    EXPECT_DOUBLE_EQ(path.hours[b], static_cast<double>(b + 1));
  }
  EXPECT_LT(path.end_um2(), 0.9 * choice_.prior_um2());
  EXPECT_LT((path.covariance - covariance.topLeftCorner(count, count)).norm(), 1e-6);
}

TEST_F(Choices, GreedyTakesTheBestNextBlockAndExchangesOnlyImprove) {
  const TestOrder one = choice_.greedy(hour);
  ASSERT_EQ(one.size(), 1U);
  const double best = choice_.evaluate(one).end_um2();
  for (const TestBlock& block : blocks_) EXPECT_GE(choice_.evaluate({&block}).end_um2(), (1.0 - 1e-9) * best);
  const TestOrder greedy = choice_.greedy(5 * hour), exchanged = choice_.exchanged(greedy, 2);
  ASSERT_EQ(greedy.size(), 5U);
  EXPECT_EQ(greedy.front(), one.front());
  EXPECT_LE(choice_.evaluate(exchanged).end_um2(), choice_.evaluate(greedy).end_um2());
  // From a bad order it finds a better one.
  const TestOrder idle(4, &blocks_.front());
  EXPECT_LT(choice_.evaluate(choice_.exchanged(idle, 2)).end_um2(), 0.7 * choice_.evaluate(idle).end_um2());
}

TEST_F(Choices, ChosenIsBelowRandomOrders) {
  const double chosen = choice_.evaluate(choice_.exchanged(choice_.greedy(6 * hour), 1)).end_um2();
  for (int seed = 1; seed <= 5; ++seed) {
    const TestOrder random = choice_.random(6 * hour, seed);
    ASSERT_EQ(random.size(), 6U);
    EXPECT_LT(chosen, choice_.evaluate(random).end_um2()) << seed;
  }
  EXPECT_NE(choice_.random(6 * hour, 1), choice_.random(6 * hour, 2));
}

TEST_F(Choices, TheOrderMatters) {
  const auto named = [&](const char* name) {
    return &*std::find_if(blocks_.begin(), blocks_.end(), [&](const TestBlock& b) { return b.name == name; });
  };
  const double warm_then_still = choice_.evaluate({named("spindle"), named("standstill")}).end_um2(),
               still_then_warm = choice_.evaluate({named("standstill"), named("spindle")}).end_um2();
  EXPECT_GT(std::abs(warm_then_still - still_then_warm), 1e-3 * still_then_warm);
}

TEST_F(Choices, NoBlockFits) { EXPECT_THROW(choice_.greedy(60.0), core::InputError); }

TEST(StatedParameters, AreAllWithADeviation) {
  const std::vector<UncertainParameter> all = stated_parameters(lumped::machine(), true);
  std::vector<std::string> names;
  for (const UncertainParameter& one : all) names.push_back(key_of(one));
  for (const char* name : {"source_power:motor", "film_coefficient:base.film", "contact_conductance:Z_guide",
                           "coolant_flow:main", "coolant_coupling:main.jacket"})
    EXPECT_TRUE(std::find(names.begin(), names.end(), name) != names.end()) << name;
  EXPECT_EQ(std::find(names.begin(), names.end(), "source_power:pump"), names.end());
  EXPECT_EQ(chosen_parameters(all, {"source_power:motor"}, lumped::machine()).size(), 1U);
  EXPECT_THROW(chosen_parameters(all, {"source_power:moto"}, lumped::machine()), core::InputError);
  EXPECT_THROW(chosen_parameters({}, {}, lumped::machine()), core::InputError);
}

// A share of the value 0 is no deviation that a test could lessen.
TEST(StatedParameters, AGradientOfNothingIsNoUncertainValue) {
  mesh::Machine machine = lumped::machine();
  machine.ambients[0].has_gradient = true;
  const auto gradients = [&](double value) {
    machine.ambients[0].gradient = {value, 50.0};
    std::vector<double> std;
    for (const UncertainParameter& found : stated_parameters(machine, true))
      if (found.parameter.kind == diagnosis::Kind::ambient_gradient) std.push_back(found.std);
    return std;
  };
  EXPECT_EQ(gradients(2.0), std::vector<double>{1.0});
  EXPECT_TRUE(gradients(0.0).empty());
}

}  // namespace
}  // namespace thermotwin::study
