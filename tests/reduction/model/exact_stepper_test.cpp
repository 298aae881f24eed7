// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/model/exact_stepper.h"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "tests/reduction/random_system.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::exact;
using test::Numbers;
using test::random_coefficients;
using test::random_system;

ExactOptions at_once() {
  ExactOptions options;
  options.from_first = true;
  return options;
}

TEST(ExactStepper, MeetsTheExponentialForAnyInterval) {
  const ReducedSystem system = random_system(24, 4, 3, 1);
  const solver::Coefficients c = random_coefficients(system, 2);
  const VectorXd start = Numbers(3).matrix(24, 1);
  ExactStepper stepper(system, at_once());
  for (const double time : {60.0, 1.0, 0.013, 59.9, 61.0, 487.25, 86400.0}) {
    VectorXd state = start;
    stepper.advance(state, c, time);
    EXPECT_LT((state - exact(system, c, start, time)).norm(), 1e-9 * start.norm()) << time << " s";
  }
  EXPECT_EQ(stepper.statistics().ladders, 1);
}

TEST(ExactStepper, DoesNotDependOnHowTimeIsCut) {
  const ReducedSystem system = random_system(24, 4, 3, 4);
  const solver::Coefficients c = random_coefficients(system, 5);
  const VectorXd start = Numbers(6).matrix(24, 1);
  VectorXd whole = start, cut = start;
  ExactStepper one(system, at_once()), many(system, at_once());
  one.advance(whole, c, 4000.0);
  Numbers number(7);
  double time = 0.0;
  while (time < 4000.0) {
    const double step = std::min(number(0.01, 90.0), 4000.0 - time);
    many.advance(cut, c, step);
    time += step;
  }
  EXPECT_LT((whole - cut).norm(), 1e-9 * start.norm());
}

TEST(ExactStepper, AcceptsAnyCapacity) {
  ReducedSystem system = random_system(8, 2, 2, 8);
  const MatrixXd b = Numbers(9).matrix(8, 8);
  system.capacity += 0.2 * b * b.transpose();
  const solver::Coefficients c = random_coefficients(system, 10);
  const VectorXd start = Numbers(11).matrix(8, 1);
  VectorXd state = start;
  ExactStepper(system, at_once()).advance(state, c, 777.0);
  EXPECT_LT((state - exact(system, c, start, 777.0)).norm(), 1e-9 * start.norm());
}

TEST(ExactStepper, PassesChangingCoefficientsWithSecondOrder) {
  const ReducedSystem system = random_system(16, 4, 3, 12);
  const solver::Coefficients c0 = random_coefficients(system, 13), c1 = random_coefficients(system, 14);
  const VectorXd start = Numbers(15).matrix(16, 1);
  const auto run = [&](int steps) {
    ExactStepper stepper(system);
    VectorXd state = start;
    for (int i = 0; i < steps; ++i) {
      solver::Coefficients c = c0;
      const double share = (i + 0.5) / steps;  // means over the step
      c.p += share * (c1.p - c0.p);
      stepper.advance(state, c, 2000.0 / steps);
    }
    EXPECT_EQ(stepper.statistics().exact, 0);
    return state;
  };
  const VectorXd truth = run(1600);
  const double coarse = (run(50) - truth).norm(), fine = (run(100) - truth).norm();
  EXPECT_GT(std::log2(coarse / fine), 1.8);
  EXPECT_LT(coarse, 1e-2 * start.norm());
}

TEST(ExactStepper, MakesALadderOnceCoefficientsStay) {
  const ReducedSystem system = random_system(16, 4, 3, 16);
  const solver::Coefficients c = random_coefficients(system, 17);
  ExactStepper stepper(system);
  VectorXd state = VectorXd::Ones(16);
  for (int i = 0; i < 5; ++i) stepper.advance(state, c, 30.0);
  EXPECT_EQ(stepper.statistics().passed, 1);
  EXPECT_EQ(stepper.statistics().exact, 4);
  EXPECT_EQ(stepper.statistics().ladders, 1);
}

TEST(ExactStepper, InputsThatChangeOneByOneAddUp) {
  const ReducedSystem system = random_system(16, 4, 12, 20);
  solver::Coefficients c = random_coefficients(system, 21);
  ExactStepper many(system, at_once());
  VectorXd state = VectorXd::Zero(16), fresh = state;
  Numbers number(22);
  for (int i = 0; i < 600; ++i) {
    c.q(i % 12) = number();
    many.advance(state, c, 5.0);
    ExactStepper(system, at_once()).advance(fresh, c, 5.0);
    ASSERT_LT((state - fresh).norm(), 1e-12 * (1.0 + fresh.norm())) << i;
  }
}

TEST(ExactStepper, TellsWhereNumbersAreNotFinite) {
  const ReducedSystem system = random_system(8, 2, 2, 18);
  solver::Coefficients c = random_coefficients(system, 19);
  ExactStepper stepper(system, at_once());
  VectorXd state = VectorXd::Ones(8);
  c.q(0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(stepper.advance(state, c, 60.0), core::SolverError);
}

}  // namespace
}  // namespace thermotwin::reduction
