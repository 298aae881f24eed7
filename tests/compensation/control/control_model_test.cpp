// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/control_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "compensation/control/linear.h"
#include "compensation/control/low_rank.h"
#include "compensation/control/model_order.h"
#include "compensation/control/outputs.h"
#include "compensation/online/output_map.h"
#include "core/error.h"
#include "tests/compensation/control/twin_of_lumps.h"
#include "tests/compensation/scratch.h"
#include "tests/compensation/shift.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd random_vector(Index count, test::Uniform& number, double size) {
  return VectorXd::NullaryExpr(count, [&](Index) { return number(-size, size); });
}

TEST(ControlModel, ErrorsAndOffsetsEqualThoseOfTheModelAtAnyPose) {
  const reduction::ReducedModel model = test::lumps_with_lines();
  const ControlModel control(model);
  const tt_model& m = control.model();
  const OutputMap map(model);
  test::Uniform number(1);
  const VectorXd state = random_vector(m.order, number, 1e3), change = random_vector(m.order, number, 1e2);
  std::vector<double> base(tt_output_count(&m)), slope(base.size()), scratch(m.tool_poses + m.table_poses);
  tt_project(&m, 0, tt_output_count(&m), state.data(), change.data(), base.data(), slope.data());
  for (int i = 0; i < 300; ++i) {
    mesh::Pose pose(m.axes);
    for (Index a = 0; a < pose.size(); ++a) {
      const mesh::Axis& axis = model.machine.axes[a];
      const double low = axis.endless ? -9.0 : axis.low - 0.1, high = axis.endless ? 9.0 : axis.high + 0.1;
      pose[a] = number(0.0, 1.0) < 0.1 ? 0.5 * (axis.low + axis.high) : number(low, high);
    }
    const double share = i % 3 == 0 ? 0.0 : number(0.0, 1.0);
    const solver::TcpError expected = model.tcp(state + share * change, pose);
    Eigen::Vector3d error;
    tt_tcp_error(&m, base.data(), slope.data(), share, pose.data(), scratch.data(), error.data());
    ASSERT_LT((error - expected.error.head<3>()).norm(), 1e-12 * (1e-6 + expected.error.head<3>().norm()) + 1e-15);
    VectorXd offsets(m.linear_axes);
    tt_offsets(&m, error.data(), offsets.data());
    EXPECT_LT((offsets - map.offsets(expected)).norm(), 1e-11 * (1e-6 + offsets.norm()));
    EXPECT_EQ(tt_outside(&m, pose.data()) != 0, map.outside(pose));
  }
}

TEST(ControlModel, TermsInLowRankEqualTheDenseOnes) {
  reduction::ReducedModel model = test::lumps_with_lines();
  test::Uniform number(2);
  const Index r = model.system.order();
  const MatrixXd skew = MatrixXd::NullaryExpr(r, r, [&](Index, Index) { return number(-1e-4, 1e-4); });
  model.system.terms.back() += skew - skew.transpose();  // not symmetric, of full rank
  model.system.terms.front() *= -1.0;                    // not positive
  const ControlModel control(model);
  const tt_model& m = control.model();
  const VectorXd p = random_vector(m.terms, number, 10.0), x = random_vector(m.order, number, 1.0);
  VectorXd y = VectorXd::Zero(r);
  MatrixXd sum = model.system.conduction, dense = sum;
  tt_apply_operator(&m, 1.0, p.data(), x.data(), y.data());
  for (Index j = 0; j < p.size(); ++j) {
    dense += p[j] * model.system.terms[j];
    tt_add_term(&m, static_cast<int>(j), p[j], sum.data());
  }
  EXPECT_LT((sum - dense).norm(), 1e-7 * dense.norm());
  EXPECT_LT((y - dense * x).norm(), 1e-7 * (dense * x).norm());
}

TEST(ControlModel, CapacityBecomesOne) {
  reduction::ReducedModel model = test::lumps_with_lines();
  const Index r = model.system.order();
  test::Uniform number(6);
  MatrixXd other =
      MatrixXd::Identity(r, r) + MatrixXd::NullaryExpr(r, r, [&](Index, Index) { return number(-.1, .1); });
  // The same machine in other coordinates, x = T z.
  reduction::ReducedModel turned = model;
  reduction::ReducedSystem& system = turned.system;
  const auto both = [&](const MatrixXd& a) { return MatrixXd(other.transpose() * a * other); };
  system.capacity = both(system.capacity);
  system.conduction = both(system.conduction);
  for (MatrixXd& term : system.terms) term = both(term);
  system.inputs = other.transpose() * system.inputs;
  system.sensors = system.sensors * other;
  system.one_kelvin = other.partialPivLu().solve(system.one_kelvin);
  for (auto* rows : {&turned.outputs.tool, &turned.outputs.table_axis, &turned.outputs.table_own})
    for (MatrixXd& row : *rows) row = row * other;
  const ControlModel plain(model), changed(turned);
  test::Twin one(plain.model()), two(changed.model());
  const solver::OperatingModel operating(model.machine, model.system.layout);
  double worst = 0.0, largest = 0.0;
  for (int i = 0; i < 300; ++i) {
    const VectorXd row = test::shift_row(operating.channels(), 60.0 * i + 1.0);
    one.row(60.0 * i, row);
    two.row(60.0 * i, row);
    worst = std::max(worst, (one.offset_um() - two.offset_um()).cwiseAbs().maxCoeff());
    largest = std::max(largest, one.offset_um().cwiseAbs().maxCoeff());
  }
  EXPECT_LT(worst, 1e-5 * largest);
  EXPECT_GT(largest, 1.0);
}

TEST(ControlModel, LowRankHasTheDirectionsOfAMatrixAndNoMore) {
  test::Uniform number(5);
  const Index n = 40;
  const MatrixXd any = MatrixXd::NullaryExpr(n, n, [&] { return number(-1.0, 1.0); });
  const MatrixXd turn = any.householderQr().householderQ();
  const auto of_values = [&](const VectorXd& values) {
    const MatrixXd matrix = turn * values.asDiagonal() * turn.transpose();
    return MatrixXd(0.5 * (matrix + matrix.transpose()));
  };
  const auto error = [](const LowRank& parts, const MatrixXd& matrix) {
    return (parts.left * parts.weight.asDiagonal() * parts.left.transpose() - matrix).norm();
  };
  VectorXd few = VectorXd::Zero(n), fading(n);
  few.head(7) << 3.0, 1.0, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6;
  for (Index i = 0; i < n; ++i) fading[i] = std::pow(10.0, -i - 0.5);
  for (const auto& [values, tolerance, kept] :
       {std::tuple{few, 1e-7, 7}, {few, 1e-3, 3}, {few, 0.0, 7}, {fading, 1e-7, 7}, {fading, 1e-3, 3}}) {
    const MatrixXd matrix = of_values(values);
    const LowRank parts = low_rank(matrix, tolerance);
    if (tolerance > 0.0) {
      EXPECT_EQ(parts.left.cols(), kept) << tolerance;
    }
    EXPECT_EQ(parts.right.size(), 0);
    EXPECT_LT(error(parts, matrix), 1.2 * tolerance * values.maxCoeff() + 1e-14) << tolerance;
  }
  few[3] = -0.5;
  const LowRank mixed = low_rank(of_values(few), 1e-7);
  EXPECT_EQ(mixed.left.cols(), 7);
  EXPECT_EQ(mixed.weight.minCoeff(), -1.0);
  EXPECT_LT(error(mixed, of_values(few)), 1e-6);
  EXPECT_EQ(low_rank(MatrixXd::Zero(n, n), 1e-7).left.cols(), 0);
}

TEST(ControlModel, ASmallerOrderStatesWhatItCosts) {
  reduction::ReducedModel model = test::lumps_with_lines();
  model.errors.emplace_back().rms_um = 0.1;
  const Index order = model.system.order();
  const reduction::ReducedModel small = model_of_order(model, order / 2);
  EXPECT_EQ(small.system.order(), order / 2);
  EXPECT_GT(small.errors.back().rms_um, 0.2) << "half of the lumps carry more than that";
  EXPECT_EQ(model_of_order(model, 0).errors.back().rms_um, 0.1);
}

TEST(ControlModel, OptionsReachTheGuardAndBadOnesAreNamed) {
  const reduction::ReducedModel model = test::lumps_with_lines();
  ControlOptions options;
  options.compensator.largest_um = 7.0;
  options.compensator.rate_um_s = 0.25;
  const ControlModel control(model, options);
  EXPECT_EQ(control.model().largest_um, 7.0);
  EXPECT_EQ(control.model().rate_um_s, 0.25);
  EXPECT_NE(control.model().hash, ControlModel(model).model().hash);
  EXPECT_EQ(ControlModel(model).model().hash, ControlModel(model).model().hash);
  options.tolerance = 0.5;
  test::expect_input_error([&] { control_data(model, options); }, {"tolerance", "0.5", "0 to 0.1"});
}

}  // namespace
}  // namespace thermotwin::compensation
