// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/placement/sensor_choice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace thermotwin::study {
namespace {

using Eigen::MatrixXd;

constexpr double never = 1e12;  // s, memory of a parameter that stays

std::vector<UncertainParameter> parameters(int count, double memory = never) {
  std::vector<UncertainParameter> made(count);
  for (UncertainParameter& one : made) {
    one.std = 1.0;
    one.memory = memory;
  }
  return made;
}

/// A state that is the parameters themselves, at these times.
LoadResponses standing(int count, std::vector<double> times) {
  LoadResponses load;
  load.times = std::move(times);
  load.states.assign(load.times.size(), MatrixXd::Identity(count, count));
  return load;
}

MatrixXd row(std::initializer_list<double> values) {
  return Eigen::Map<const Eigen::RowVectorXd>(values.begin(), std::ssize(values));
}

TEST(SensorChoice, LeavesWhatTheFormulaSays) {
  MatrixXd tcp = MatrixXd::Zero(3, 1);
  tcp(0, 0) = 2.0;  // um per K
  ChoiceOptions options;
  options.noise_K = 0.3;
  options.bias_K = 0.4;
  const SensorChoice one({standing(1, {60.0})}, parameters(1), row({1.0}), tcp, options);
  EXPECT_NEAR(one.left_um({}), 2.0, 1e-12);
  // Prior 1, noise and bias together 0.5: the posterior variance is 0.25 / 1.25.
  EXPECT_NEAR(one.left_um({0}), 2.0 * std::sqrt(0.25 / 1.25), 1e-9);
  EXPECT_NEAR(one.left_after_loss_um({0}), 2.0, 1e-12);

  // Many readings average the noise; the bias stays.
  options.noise_K = 0.01;
  std::vector<double> times;
  for (int i = 1; i <= 400; ++i) times.push_back(60.0 * i);
  const SensorChoice many({standing(1, times)}, parameters(1), row({1.0}), tcp, options);
  EXPECT_NEAR(many.left_um({0}), 2.0 * std::sqrt(0.16 / 1.16), 1e-3);

  // Two poses: the mean of their squares.
  MatrixXd poses = MatrixXd::Zero(6, 1);
  poses(0, 0) = 2.0;
  poses(4, 0) = 1.0;
  const SensorChoice two({standing(1, {60.0})}, parameters(1), row({1.0}), poses, options);
  EXPECT_NEAR(two.left_um({}), std::sqrt(0.5 * (4.0 + 1.0)), 1e-12);
}

TEST(SensorChoice, ForgetsWithTheMemoryOfAParameter) {
  MatrixXd tcp = MatrixXd::Zero(3, 1);
  tcp(0, 0) = 1.0;
  ChoiceOptions options;
  options.bias_K = 0.0;
  options.noise_K = 1.0;
  // Times so far apart that each reading begins from the prior again: variance 1 / 2 each time.
  const SensorChoice choice({standing(1, {1e6, 2e6, 3e6})}, parameters(1, 10.0), row({1.0}), tcp, options);
  EXPECT_NEAR(choice.left_um({0}), std::sqrt(0.5), 1e-9);
}

// One reading of a parameter whose prior is three times as wide: variance 9 * 1 / (9 + 1).
TEST(SensorChoice, TakesThePriorOfTheLoad) {
  MatrixXd tcp = MatrixXd::Zero(3, 1);
  tcp(0, 0) = 1.0;
  ChoiceOptions options;
  options.bias_K = 0.0;
  options.noise_K = 1.0;
  LoadResponses load = standing(1, {1e6, 2e6});
  load.prior = Eigen::VectorXd::Constant(1, 3.0);
  const SensorChoice choice({load}, parameters(1, 10.0), row({1.0}), tcp, options);
  EXPECT_NEAR(choice.left_um({}), 3.0, 1e-9);
  EXPECT_NEAR(choice.left_um({0}), std::sqrt(0.9), 1e-9);
}

TEST(SensorChoice, TakesThePlaceThatTellsTheErrorAndMendsAGreedyStart) {
  // The error is theta_0 + theta_1 in x. Place 2 reads their sum weakly disturbed by theta_2 and is best alone; places
  // 0 and 1 together tell all.
  MatrixXd tcp = MatrixXd::Zero(3, 3);
  tcp(0, 0) = tcp(0, 1) = 1.0;
  MatrixXd places(4, 3);
  places << 1, 0, 0, 0, 1, 0, 1, 1, 0.6, 0, 0, 0.1;
  ChoiceOptions options;
  options.noise_K = 0.05;
  options.bias_K = 0.0;
  const SensorChoice choice({standing(3, {60.0})}, parameters(3), places, tcp, options);
  EXPECT_EQ(choice.greedy(1), std::vector<int>{2});
  const std::vector<int> greedy = choice.greedy(2), mended = choice.chosen(greedy);
  EXPECT_LT(choice.left_um(mended), choice.left_um(greedy));
  // No pair is better.
  double best = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 4; ++a)
    for (int b = a + 1; b < 4; ++b) best = std::min(best, choice.left_um({a, b}));
  EXPECT_NEAR(choice.left_um(mended), best, 1e-12);
  EXPECT_LT(choice.left_um(mended), 0.2 * choice.left_um({3}));
}

TEST(SensorChoice, SurvivesTheLossOfAnySensorWhereAsked) {
  // Places 0 to 2 read theta_0, places 3 to 5 theta_1; the error is of theta_0 for the most part.
  MatrixXd tcp = MatrixXd::Zero(3, 2);
  tcp(0, 0) = 3.0;
  tcp(1, 1) = 1.0;
  MatrixXd places(6, 2);
  places << 1, 0, 1, 0, 1, 0, 0, 1, 0, 1, 0, 1;
  ChoiceOptions options;
  options.noise_K = 0.01;
  options.bias_K = 0.1;
  const SensorChoice careless({standing(2, {60.0})}, parameters(2), places, tcp, options);
  options.any_loss = true;
  const SensorChoice careful({standing(2, {60.0})}, parameters(2), places, tcp, options);
  const std::vector<int> start{0, 3, 4};
  EXPECT_NEAR(careful.left_after_loss_um(start), 3.0, 0.2);
  EXPECT_LT(careful.left_after_loss_um(careful.exchanged(start)), 1.1);
  // With two sensors one of each is best, and the loss of one leaves all of theta_0.
  const std::vector<int> each{0, 3};
  EXPECT_NEAR(careless.left_after_loss_um(careless.exchanged(each)), 3.0, 0.2);
  EXPECT_LT(careful.left_after_loss_um(careful.exchanged(each)), 1.1);
}

/// Mesh error at the places and at the TCP, by default where no parameter moves it, without a change since the start.
ModelErrors mesh_error(const Eigen::VectorXd& places_K, double tcp_um,
                       const Eigen::Vector3d& direction = Eigen::Vector3d::UnitY()) {
  ModelErrors made;
  made.changes_K = {Eigen::VectorXd::Zero(places_K.size())};
  made.meshes.push_back({{places_K}, {tcp_um * direction}});
  return made;
}

TEST(SensorChoice, AvoidsAPlaceWhereTheMeshMisleads) {
  MatrixXd tcp = MatrixXd::Zero(3, 1);
  tcp(0, 0) = 2.0;
  ChoiceOptions options;
  options.noise_K = 1e-6;
  options.bias_K = 0.1;
  MatrixXd places(2, 1);
  places << 1.0, 0.9;  // the first tells more
  const std::vector<LoadResponses> load{standing(1, {3600.0})};
  EXPECT_EQ(SensorChoice(load, parameters(1), places, tcp, options).greedy(1), std::vector<int>{0});
  const SensorChoice choice(load, parameters(1), places, tcp, options, {mesh_error(Eigen::Vector2d(0.5, 0.0), 0.3)});
  EXPECT_EQ(choice.greedy(1), std::vector<int>{1});
  // No sensor tells the mesh error of the TCP; at the first place the filter finds a share of 0.5 K.
  EXPECT_NEAR(choice.left({}).mesh_um, 0.3, 1e-12);
  EXPECT_NEAR(choice.left({1}).mesh_um, 0.3, 1e-12);
  EXPECT_NEAR(choice.left({0}).mesh_um, std::hypot(0.3, 2.0 * 0.5 / 1.01), 1e-3);
  EXPECT_NEAR(choice.left({0}).parameters_um, 2.0 * 0.1 / std::sqrt(1.01), 1e-2);
  EXPECT_NEAR(choice.left_um({0}), std::hypot(choice.left({0}).mesh_um, choice.left({0}).parameters_um), 1e-12);
}

// The error of the TCP is what the error at the place says, or the opposite.
TEST(SensorChoice, TellsAMeshErrorThatMovesTheTcpAsTheParameterDoes) {
  MatrixXd tcp = MatrixXd::Zero(3, 1);
  tcp(0, 0) = 2.0;
  ChoiceOptions options;
  options.noise_K = 1e-6;
  options.bias_K = 0.1;
  const std::vector<LoadResponses> load{standing(1, {3600.0})};
  const double found_um = 2.0 * 0.5 / 1.01;
  for (const double tcp_um : {1.0, -1.0}) {
    const SensorChoice choice(load, parameters(1), row({1.0}), tcp, options,
                              {mesh_error(Eigen::VectorXd::Constant(1, 0.5), tcp_um, Eigen::Vector3d::UnitX())});
    EXPECT_NEAR(choice.left({}).mesh_um, 1.0, 1e-12);
    EXPECT_NEAR(choice.left({0}).mesh_um, std::abs(tcp_um - found_um), 1e-3) << tcp_um;
  }
}

// One mesh misleads at the first place, the other at the second: both count, by their mean square.
TEST(SensorChoice, TakesTheMeanOverOtherMeshes) {
  MatrixXd tcp = MatrixXd::Zero(3, 1);
  tcp(0, 0) = 2.0;
  ChoiceOptions options;
  options.noise_K = 1e-6;
  options.bias_K = 0.1;
  MatrixXd places(2, 1);
  places << 1.0, 1.0;
  const std::vector<LoadResponses> load{standing(1, {3600.0})};
  ModelErrors both = mesh_error(Eigen::Vector2d(0.5, 0.0), 0.3);
  both.meshes.push_back(mesh_error(Eigen::Vector2d(0.0, 0.2), 0.1).meshes.front());
  const SensorChoice choice(load, parameters(1), places, tcp, options, {both});
  const double found = 2.0 / 1.01;  // um of the TCP for a kelvin at a place
  EXPECT_NEAR(choice.left({}).mesh_um, std::sqrt(0.5 * (0.09 + 0.01)), 1e-12);
  EXPECT_NEAR(choice.left({0}).mesh_um, std::sqrt(0.5 * (0.09 + 0.01 + std::pow(0.5 * found, 2))), 1e-3);
  EXPECT_NEAR(choice.left({1}).mesh_um, std::sqrt(0.5 * (0.09 + 0.01 + std::pow(0.2 * found, 2))), 1e-3);
}

TEST(SensorChoice, TrustsAReadingLessTheMoreItChanges) {
  MatrixXd tcp = MatrixXd::Zero(3, 1);
  tcp(0, 0) = 1.0;
  ChoiceOptions options;
  options.noise_K = 0.05;
  options.bias_K = 0.0;
  ModelErrors hot;
  hot.changes_K = {Eigen::Vector2d(0.0, 20.0)};
  MatrixXd places(2, 1);
  places << 1.0, 1.0;
  const SensorChoice choice({standing(1, {3600.0})}, parameters(1), places, tcp, options, {hot});
  EXPECT_LT(choice.left_um({0}), 0.1);
  EXPECT_GT(choice.left_um({1}), 0.4);  // 3 % of 20 K
}

// Of many places only the most promising are judged along all times. Places and errors differ in shape and in time.
TEST(SensorChoice, ScreensManyPlacesWithoutALoss) {
  constexpr int count = 200, quantities = 6;
  LoadResponses load;
  for (int t = 1; t <= 42; ++t) {
    load.times.push_back(1200.0 * t);
    Eigen::MatrixXd state = Eigen::MatrixXd::Identity(quantities, quantities);
    for (int q = 0; q < quantities; ++q) state(q, q) = 1.0 - std::exp(-1200.0 * t / (1800.0 * (q + 1)));
    load.states.push_back(state);
  }
  Eigen::MatrixXd places(count, quantities), tcp(6, quantities);
  for (int i = 0; i < count; ++i)
    for (int q = 0; q < quantities; ++q) places(i, q) = std::exp(-std::pow((i - 35.0 * q) / (8.0 + 3.0 * q), 2));
  for (int i = 0; i < tcp.rows(); ++i)
    for (int q = 0; q < quantities; ++q) tcp(i, q) = std::cos(1.0 + i + 2.0 * q);
  ChoiceOptions all, screened;
  all.all_times_from = count;
  screened.all_times_from = 5;
  const SensorChoice slow({load}, parameters(quantities, 20000.0), places, tcp, all);
  const SensorChoice quick({load}, parameters(quantities, 20000.0), places, tcp, screened);
  const std::vector<int> expected = slow.chosen(slow.greedy(4)), found = quick.chosen(quick.greedy(4));
  EXPECT_DOUBLE_EQ(quick.left_um(expected), slow.left_um(expected));
  EXPECT_LE(quick.left_um(found), 1.001 * slow.left_um(expected));
  EXPECT_LT(quick.left_um(found), 0.7 * quick.left_um({}));
}

}  // namespace
}  // namespace thermotwin::study
