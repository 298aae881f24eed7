// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/detectability.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <limits>

#include "compensation/online/compensator.h"
#include "core/error.h"
#include "mesh/machine/kinematics.h"
#include "tests/compensation/shift.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A rod of eight lumps that gives its heat to the air at both ends, read at some lumps, with heat
/// sources at some lumps.
struct Rod {
  MatrixXd capacity = MatrixXd::Identity(8, 8), conduction = MatrixXd::Zero(8, 8);
  Rod() {
    for (Index i = 0; i + 1 < 8; ++i) {
      conduction(i, i) += 1.0;
      conduction(i + 1, i + 1) += 1.0;
      conduction(i, i + 1) -= 1.0;
      conduction(i + 1, i) -= 1.0;
    }
    conduction(0, 0) += 0.2;
    conduction(7, 7) += 0.4;
  }
  static MatrixXd rows(const std::vector<Index>& lumps) {
    MatrixXd matrix = MatrixXd::Zero(std::ssize(lumps), 8);
    for (std::size_t i = 0; i < lumps.size(); ++i) matrix(i, lumps[i]) = 1.0;
    return matrix;
  }
};

ErrorModel::State state(const std::string& name, double prior) { return {name, "1", 0.0, prior, prior, 0.0}; }

/// The test itself on the augmented system: rank of [lambda - M; C] at every eigenvalue with Re >= 0.
bool passes(const MatrixXd& conduction, const MatrixXd& rates, const MatrixXd& sensors) {
  const Index r = conduction.rows(), m = rates.cols(), all = r + m;
  MatrixXd dynamics = MatrixXd::Zero(all, all), output = MatrixXd::Zero(sensors.rows(), all);
  dynamics.topLeftCorner(r, r) = -conduction;
  dynamics.topRightCorner(r, m) = rates;
  output.leftCols(r) = sensors;
  const Eigen::VectorXcd poles = Eigen::EigenSolver<MatrixXd>(dynamics, false).eigenvalues();
  for (const std::complex<double>& pole : poles) {
    if (pole.real() < -1e-9) continue;
    Eigen::MatrixXcd pencil(all + sensors.rows(), all);
    pencil.topRows(all) = pole * Eigen::MatrixXcd::Identity(all, all) - dynamics;
    pencil.bottomRows(sensors.rows()) = output.cast<std::complex<double>>();
    if (Eigen::JacobiSVD<Eigen::MatrixXcd>(pencil).setThreshold(1e-9).rank() < all) return false;
  }
  return true;
}

TEST(Detectability, AgreesWithTheRankTestOfTheAugmentedSystem) {
  const Rod rod;
  for (const std::vector<Index>& at : {std::vector<Index>{1, 6}, {0, 3, 7}, {2}}) {
    for (const std::vector<Index>& sources : {std::vector<Index>{2}, {2, 5}, {1, 4, 6}, {3, 3}}) {
      const MatrixXd sensors = Rod::rows(at), rates = Rod::rows(sources).transpose();
      std::vector<ErrorModel::State> states;
      for (std::size_t i = 0; i < sources.size(); ++i) states.push_back(state("source " + std::to_string(i), 10.0));
      for (std::size_t i = 0; i < at.size(); ++i)
        states.push_back(state("offset " + std::to_string(i), 1e-9));  // below any reading
      const Detectability told =
          detectability(rod.capacity, rod.conduction, rates, sensors, states, VectorXd::Constant(sensors.rows(), 1e-3));
      EXPECT_EQ(told.detectable == std::ssize(sources), passes(rod.conduction, rates, sensors))
          << at.size() << " sensors, " << sources.size() << " sources";
      EXPECT_TRUE(std::isfinite(told.slowest_s));
      if (told.detectable > 0) {
        EXPECT_GT(told.margin, 1.0);
      }
    }
  }
}

TEST(Detectability, NamesWhatItIsTakenFor) {
  const Rod rod;
  // Two sources at one place, the second of them weaker; and one that no sensor sees.
  const MatrixXd sensors = Rod::rows({1, 6}), rates = Rod::rows({2, 2, 5}).transpose();
  const std::vector<ErrorModel::State> states{state("strong", 1.0), state("weak", 0.5), state("faint", 1e-6),
                                              state("offset a", 1e-6), state("offset b", 1e-6)};
  const Detectability told =
      detectability(rod.capacity, rod.conduction, rates, sensors, states, VectorXd::Constant(2, 1e-2));
  ASSERT_EQ(told.detectable, 1);
  EXPECT_EQ(told.states[0].state.name, "strong");
  EXPECT_EQ(told.states[1].state.name, "weak");
  EXPECT_EQ(told.states[1].like, "strong");
  EXPECT_LT(told.states[1].beyond, 1e-9 * told.states[1].reach);
  EXPECT_NE(told.brief().find("no: no sensor near"), std::string::npos);
  // An offset as large as what the source moves is a rival: two sensors, two of the three.
  const std::vector<ErrorModel::State> rivals{state("source", 1.0), state("unused", 0.0), state("unused too", 0.0),
                                              state("offset a", 1.0), state("offset b", 1.0)};
  EXPECT_EQ(detectability(rod.capacity, rod.conduction, rates, sensors, rivals, VectorXd::Constant(2, 1e-2)).detectable,
            2);
}

TEST(Detectability, AnInsulatedMachineIsSaidToKeepItsHeat) {
  Rod rod;
  rod.conduction(0, 0) -= 0.2;
  rod.conduction(7, 7) -= 0.4;
  rod.conduction += 1e-18 * MatrixXd::Identity(8, 8);
  const Detectability told = detectability(rod.capacity, rod.conduction, Rod::rows({2}).transpose(), Rod::rows({1}),
                                           {state("source", 1.0), state("offset", 0.1)}, VectorXd::Constant(1, 0.01));
  EXPECT_FALSE(std::isfinite(told.slowest_s));
  EXPECT_NE(told.brief().find("no path for its heat"), std::string::npos);
}

TEST(Detectability, OfTheCompensatorNamesItsStates) {
  const reduction::ReducedModel model = test::lumped_model();
  const std::vector<mesh::Pose> poses{mesh::home_pose(model.machine)};
  const test::Truth truth = test::run_truth(model.machine, model, 60.0, 1, 4 * 3600.0, poses);
  Compensator compensator(model), fewer(model);
  for (std::size_t i = 0; i < truth.time.size(); ++i) {
    compensator.step(truth.time[i], truth.rows[i], truth.readings_C[i]);
    VectorXd one = VectorXd::Constant(truth.readings_C[i].size(), std::numeric_limits<double>::quiet_NaN());
    one[0] = truth.readings_C[i][0];
    fewer.step(truth.time[i], truth.rows[i], one);
  }
  const Detectability all = compensator.detectability();
  EXPECT_EQ(all.sensors, 8);
  EXPECT_LE(all.detectable, 8);
  EXPECT_GE(all.detectable, 4);
  EXPECT_GT(all.margin, 0.2);
  EXPECT_NE(all.brief().find("power of source spindle_bearings"), std::string::npos);
  EXPECT_NE(all.brief().find("offset of sensor T_nose"), std::string::npos);
  const Detectability one = fewer.detectability();
  EXPECT_EQ(one.sensors, 1);
  EXPECT_EQ(one.detectable, 1);
  // A run tells more than a standing machine: the spindle's power is known better afterwards.
  for (const AugmentedState& a : all.states) {
    if (a.state.name != "power of source spindle_bearings") continue;
    EXPECT_LT(a.state.std, 0.7 * a.state.prior_std);
  }
  EXPECT_THROW(Compensator(model).detectability(), core::InputError);
}

}  // namespace
}  // namespace thermotwin::compensation
