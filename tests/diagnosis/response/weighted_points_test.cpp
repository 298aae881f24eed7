// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/weighted_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/offered_causes.h"
#include "diagnosis/inference/hypothesis_fit.h"
#include "diagnosis/response/problem.h"
#include "tests/machines/rods_record.h"

namespace {

using namespace thermotwin;
using diagnosis::Observations;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The record of the rods with sums of its displacements beside them: of the deviations at the first two poses.
struct Summed {
  compensation::Measurement measurement;
  std::vector<std::size_t> parts;  ///< channels that are summed
};

Summed summed() {
  Summed result{lumped::measure({}, {.hours = 10}), {}};
  compensation::Measurement& m = result.measurement;
  std::vector<std::string> poses;
  for (std::size_t k = 0; k < m.channels.size(); ++k) {
    const compensation::MeasuredChannel& channel = m.channels[k];
    if (channel.quantity.size() != 2 || channel.quantity[0] != 'd') continue;
    if (std::find(poses.begin(), poses.end(), channel.pose_text) == poses.end()) poses.push_back(channel.pose_text);
    if (poses.size() > 2) break;
    result.parts.push_back(k);
  }
  EXPECT_EQ(poses.size(), 2U);
  const std::vector<std::vector<double>> weights = {
      {0.5, 0, 0.2, 0.5, 0, -0.2}, {0, 0, 4, 0, 0, -4}, {0.3, 0.4, 0.5, 0.6, 0.1, 0.2}};
  const char* names[] = {"X0C", "B0C", "Z0T"};
  for (std::size_t e = 0; e < 3; ++e) {
    compensation::MeasuredChannel sum = m.channels[result.parts.front()];
    sum.id = sum.quantity = names[e];
    sum.unit = e == 1 ? "um/m" : "um";
    sum.pose_text.clear();
    sum.arrangement = "rtest";
    for (const std::string& pose : poses) sum.points.push_back({pose, Eigen::Vector3d::Zero()});
    VectorXd values = VectorXd::Zero(m.data.rows());
    for (const std::size_t part : result.parts) {
      const compensation::MeasuredChannel& channel = m.channels[part];
      const std::size_t point = channel.pose_text == poses[0] ? 0 : 1, direction = channel.quantity[1] - 'x';
      sum.points[point].weight[static_cast<Index>(direction)] = weights[e][3 * point + direction];
      values += weights[e][3 * point + direction] * m.values(channel);
    }
    double square = 0.0;
    for (const auto& point : sum.points) square += point.weight.squaredNorm();
    sum.uncertainty = 0.3 * std::sqrt(square);
    sum.column = m.data.values.cols();
    m.data.columns.push_back(sum.id);
    m.data.values.conservativeResize(Eigen::NoChange, sum.column + 1);
    m.data.values.col(sum.column) = values;
    m.channels.push_back(sum);
  }
  return result;
}

Observations observed(const compensation::Measurement& m) {
  const mesh::Machine machine = lumped::machine();
  return diagnosis::observe(m, machine, solver::Channels(machine), {.interval_s = 600});
}

const diagnosis::ObservedChannel& named(const Observations& obs, const std::string& id, Index& first) {
  first = 0;
  for (const diagnosis::ObservedChannel& channel : obs.channels) {
    if (channel.channel.id == id) return channel;
    first += channel.size();
  }
  throw std::logic_error(id);
}

// A sum of deviations is predicted, and changes with every parameter, as the sum of the predicted deviations.
TEST(WeightedPoints, ArePredictedAsTheSumOfTheirDeviations) {
  const Summed record = summed();
  const Observations obs = observed(record.measurement);
  const reduction::ReducedModel model = lumped::model(lumped::machine(), 9);
  const diagnosis::Response response(model, obs);
  const auto parameters = diagnosis::candidate_parameters(model.machine, record.measurement);
  VectorXd nominal(std::ssize(parameters));
  for (Index i = 0; i < nominal.size(); ++i) nominal[i] = parameters[i].nominal;
  const auto linear = response.linearise(model.machine, parameters, nominal, true);
  MatrixXd all(linear.predicted.size(), 1 + linear.sensitivity.cols());
  all << linear.predicted, linear.sensitivity;
  for (Index c = 0; c < linear.sensitivity.cols(); ++c)
    if (diagnosis::acts_on_readings(parameters[c].kind)) all.col(1 + c).setZero();  // of each channel for itself
  for (const char* id : {"X0C", "B0C", "Z0T"}) {
    Index first = 0, part_first = 0;
    const diagnosis::ObservedChannel& sum = named(obs, id, first);
    MatrixXd expected = MatrixXd::Zero(sum.size(), all.cols());
    for (const std::size_t part : record.parts) {
      const compensation::MeasuredChannel& channel = record.measurement.channels[part];
      const bool second = channel.pose_text != sum.channel.points[0].pose_text;
      const auto& of = named(obs, channel.id, part_first);
      expected +=
          sum.channel.points[second ? 1 : 0].weight[channel.quantity[1] - 'x'] * all.middleRows(part_first, of.size());
    }
    EXPECT_GT(expected.col(0).norm(), 1.0);
    EXPECT_LT((all.middleRows(first, sum.size()) - expected).norm(), 1e-9 * expected.norm()) << id;
  }
}

// Independent errors of the deviations: the sums of a test's channels have independent ones of the channels' sizes.
TEST(WeightedPoints, SumsHaveIndependentErrors) {
  const Observations obs = observed(summed().measurement);
  const std::vector<diagnosis::PointTest> tests = diagnosis::tests_of(lumped::machine(), obs);
  ASSERT_EQ(tests.size(), 1U);
  ASSERT_EQ(tests[0].channels.size(), 3U);
  const double std = obs.channels[tests[0].channels[0]].channel.uncertainty / tests[0].weights.row(0).norm();
  const MatrixXd weights = tests[0].weights_of_sums();
  const MatrixXd covariance = std * std * weights * weights.transpose();
  for (Index k = 0; k < 3; ++k) {
    const double own = obs.channels[tests[0].channels[k]].channel.uncertainty;
    EXPECT_NEAR(covariance(k, k), own * own, 1e-9 * own * own);
    for (Index l = 0; l < k; ++l) EXPECT_NEAR(covariance(k, l), 0.0, 1e-9 * own * own);
  }
  EXPECT_LT((tests[0].sums * tests[0].from_sums - MatrixXd::Identity(3, 3)).norm(), 1e-9);
  EXPECT_GT((tests[0].sums - MatrixXd::Identity(3, 3)).norm(), 0.1) << "nothing was correlated";
  // Blank cells of one channel make it a test of its own.
  Summed other = summed();
  other.measurement.data.values.col(other.measurement.channels.back().column).head(40).setConstant(std::nan(""));
  EXPECT_EQ(diagnosis::tests_of(lumped::machine(), observed(other.measurement)).size(), 2U);
}

// A rotation hardly shows a shift of all points alike, a location error along it shows it whole.
TEST(WeightedPoints, TheMeshErrsByTheFunctionalOfTheMotion) {
  const Summed record = summed();
  const Observations obs = observed(record.measurement);
  reduction::ReducedModel model = lumped::model(lumped::machine(), 9);
  model.mesh_error = reduction::MeshError{VectorXd::Constant(std::ssize(model.machine.sensors), 0.02),
                                          VectorXd::Constant(6, 0.02), "made up"};
  const diagnosis::Response response(model, obs);
  const diagnosis::Problem problem = diagnosis::make_problem(model.machine, record.measurement, obs, response, {});
  ASSERT_EQ(problem.tests.size(), 1U);
  const diagnosis::MeshAllowance allowance(model.machine, model.mesh_error, {});
  const diagnosis::TestErrors errors = diagnosis::errors_of(model.machine, obs, problem.tests[0], response, allowance);
  ASSERT_EQ(errors.joint.size(), 9U);
  // z by z: the difference of both poses for B0C, 2 % of 4 times it.
  Index first[2] = {0, 0};
  std::vector<VectorXd> dz;
  for (const std::size_t part : record.parts) {
    const compensation::MeasuredChannel& channel = record.measurement.channels[part];
    if (channel.quantity != "dz") continue;
    const auto& of = named(obs, channel.id, first[0]);
    dz.emplace_back(problem.predicted.segment(first[0], of.size()));
  }
  ASSERT_EQ(dz.size(), 2U);
  const VectorXd expected = 0.02 * 4.0 * (dz[0] - dz[1]);
  EXPECT_LT((errors.joint[8].col(1) - expected).norm(), 1e-6 * expected.norm() + 1e-9);
  // Residual, columns and expectation stay those of the channels; what is fitted is the sums.
  const VectorXd fitted = problem.fitted(problem.measured);
  const VectorXd sums = diagnosis::with_sums(problem.tests, obs, problem.measured);
  EXPECT_NE(sums, problem.measured);
  EXPECT_EQ(fitted.tail(5),
            sums.segment(problem.first_row(obs.channels.size() - 1) + obs.channels.back().fitted - 5, 5));
  EXPECT_TRUE((problem.expected_std.array() > 0.0).all());
  const diagnosis::White white(problem);
  EXPECT_TRUE(white.residual.allFinite());
}

}  // namespace
