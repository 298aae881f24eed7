// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis/observer_noise.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <random>

#include "core/error.h"
#include "core/progress.h"
#include "reduction/basis/reduce.h"
#include "reduction/basis/responses.h"
#include "solver/campaign/full_model.h"
#include "solver/operation/layout.h"
#include "tests/machines/boxes.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST(StationaryPrediction, OfOneStateIsTheRootOfItsQuadratic) {
  const double f = 0.9, q = 0.3, h = 2.0, r = 0.5;
  const double s = stationary_prediction(MatrixXd::Constant(1, 1, f), MatrixXd::Constant(1, 1, q),
                                         MatrixXd::Constant(1, 1, h), VectorXd::Constant(1, r))(0, 0);
  // h^2 s^2 + (r - f^2 r - q h^2) s - q r = 0
  const double b = r - f * f * r - q * h * h;
  EXPECT_NEAR(s, (-b + std::sqrt(b * b + 4 * h * h * q * r)) / (2 * h * h), 1e-12);
  const double open = stationary_prediction(MatrixXd::Constant(1, 1, f), MatrixXd::Constant(1, 1, q),
                                            MatrixXd::Zero(1, 1), VectorXd::Ones(1))(0, 0);
  EXPECT_NEAR(open, q / (1 - f * f), 1e-10);
}

TEST(StationaryPrediction, SolvesTheRiccatiEquation) {
  std::mt19937 engine(3);
  std::normal_distribution<double> normal;
  const auto random = [&](Index rows, Index columns) {
    return MatrixXd(MatrixXd::NullaryExpr(rows, columns, [&](Index, Index) { return normal(engine); }));
  };
  constexpr Index n = 12;
  MatrixXd f = random(n, n);
  f *= 0.995 / f.eigenvalues().cwiseAbs().maxCoeff();
  const MatrixXd half = random(n, 4), q = half * half.transpose(), h = random(3, n);
  const VectorXd r = VectorXd::Constant(3, 0.2);
  const MatrixXd s = stationary_prediction(f, q, h, r);
  const MatrixXd seen = h * s * h.transpose() + MatrixXd(r.asDiagonal());
  const MatrixXd next = f * (s - s * h.transpose() * seen.inverse() * h * s) * f.transpose() + q;
  EXPECT_LT((next - s).norm(), 1e-9 * s.norm());
}

struct Boxes {
  solver::FullModel full;
  ReducedModel model;
  VectorXd standing;
  MatrixXd states;

  Boxes() : full(test::boxes()) {
    core::set_quiet(true);
    model = reduce(full, {}, {}, {.method = BasisMethod::krylov, .order = 30, .parts = false});
    const solver::OperatingModel operating(full.mesh.machine, full.thermal.layout);
    standing = operating_points(operating).front().c.p;
    // What each source makes of the machine in hours.
    ReducedStepper stepper(model.system);
    const auto& inputs = model.system.layout.inputs;
    for (std::size_t k = 0; k < inputs.size(); ++k) {
      if (inputs[k].kind != solver::InputKind::source) continue;
      solver::Coefficients c;
      c.p = standing;
      c.q = VectorXd::Zero(model.system.inputs.cols());
      c.q(k) = 100.0;
      VectorXd x = VectorXd::Zero(model.system.order());
      for (int i = 0; i < 20; ++i) {
        stepper.advance(x, c, 600.0);
        states.conservativeResize(x.size(), states.cols() + 1);
        states.rightCols(1) = x;
      }
    }
  }
};
const Boxes& boxes() {
  static const Boxes made;
  return made;
}

double rms_um(const ReducedModel& model, const MatrixXd& states) {
  const auto poses = mesh::workspace_poses(model.machine);
  const MatrixXd values = value_rows(model, poses) * states;
  double sum = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) sum += values.middleRows(18 * i, 3).squaredNorm();
  return std::sqrt(sum / poses.size() / states.cols());
}

TEST(ObserverNoise, LiesBetweenNothingAndWhatThePriorLeaves) {
  ReducedModel model = boxes().model;
  ASSERT_FALSE(model.machine.sensors.empty());
  const double share = prior_share(model.machine), prior = share * rms_um(model, boxes().states);
  const auto with = [&](double uncertainty) {
    for (mesh::SensorSpec& sensor : model.machine.sensors) sensor.uncertainty = uncertainty;
    return observer_noise(model, boxes().states, boxes().standing);
  };
  const ObserverNoise fine = with(0.01), usual = with(0.05), blind = with(1e6);
  std::printf("prior %.2f um, open %.2f um; sensors of 0.01 K leave %.3f, of 0.05 K %.3f um\n", prior, usual.open_um,
              fine.predicted_um, usual.predicted_um);
  EXPECT_NEAR(blind.predicted_um, blind.open_um, 1e-6 * blind.open_um);
  EXPECT_LT(usual.predicted_um, 0.9 * usual.open_um);
  EXPECT_LT(fine.predicted_um, usual.predicted_um);
  EXPECT_GT(fine.predicted_um, 0.0);
  // The disturbance keeps the prior; its negative part, which is left out, only adds.
  EXPECT_GT(usual.open_um, 0.999 * prior);
  EXPECT_LT(usual.open_um, 1.5 * prior);
}

TEST(ObserverNoise, GrowsWithWhatTheMachineIsUnsureOf) {
  ReducedModel model = boxes().model;
  for (mesh::SourceSpec& source : model.machine.sources) source.scale.std_percent = 0;
  for (mesh::FilmSpec& film : model.machine.films) film.coefficient.std_percent = 0;
  EXPECT_EQ(prior_share(model.machine), 0.1);
  const double unstated = observer_noise(model, boxes().states, boxes().standing).open_um;
  const double all = model.machine.sources.size() + model.machine.films.size();
  for (mesh::SourceSpec& source : model.machine.sources) source.scale.std_percent = 30;
  EXPECT_NEAR(prior_share(model.machine), 0.3 * std::sqrt(static_cast<double>(model.machine.sources.size()) / all),
              1e-12);
  EXPECT_NEAR(observer_noise(model, boxes().states, boxes().standing).open_um / unstated,
              prior_share(model.machine) / 0.1, 1e-6);
  EXPECT_THROW(observer_noise(model, MatrixXd(30, 0), boxes().standing), core::InputError);
}

}  // namespace
}  // namespace thermotwin::reduction
