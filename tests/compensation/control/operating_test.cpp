// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/control/operating.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "compensation/control/chiller.h"
#include "compensation/control/control_model.h"
#include "compensation/control/machine_arrays.h"
#include "compensation/control/mean_row.h"
#include "compensation/online/input_mean.h"
#include "solver/operation/chiller.h"
#include "tests/compensation/control/rich_machine.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// The machine with every law, for the program and for the core.
struct Rich {
  mesh::Machine machine = test::rich_machine();
  solver::Layout layout = test::rich_layout(machine);
  solver::OperatingModel operating{machine, layout};
  ControlModel control = made();
  const tt_model& model = control.model();

  ControlModel made() const {
    ControlData data;
    fill_machine(machine, layout, operating.channels(), data);
    return ControlModel(std::move(data));
  }
};

const Rich& rich() {
  static const Rich one;
  return one;
}

double relative(const VectorXd& value, const VectorXd& truth) {
  double worst = 0.0;
  for (Index i = 0; i < truth.size(); ++i)
    worst = std::max(worst, std::abs(value[i] - truth[i]) / std::max(std::abs(truth[i]), 1e-6));
  return worst;
}

VectorXd random_temperatures(Index count, test::Uniform& number) {
  return VectorXd::NullaryExpr(count, [&](Index) { return number(-8.0, 30.0); });
}

TEST(ControlOperating, CoefficientsEqualThoseOfTheProgram) {
  const Rich& r = rich();
  test::Uniform number(7);
  double worst_p = 0.0, worst_q = 0.0;
  for (int i = 0; i < 500; ++i) {
    const VectorXd row = test::random_row(r.machine, r.operating.channels(), number);
    const VectorXd inlet = random_temperatures(r.model.coolants, number);
    const VectorXd readings = random_temperatures(r.model.readings, number);
    const VectorXd none;
    const bool read = i % 5 != 0;
    const solver::Coefficients c = r.operating.coefficients(row, inlet, read ? readings : none);
    VectorXd p = VectorXd::Constant(r.model.terms, 1e9), q = VectorXd::Constant(r.model.inputs, 1e9), share = p;
    tt_coefficients(&r.model, row.data(), inlet.data(), read ? readings.data() : nullptr, p.data(), q.data(),
                    share.data());
    worst_p = std::max(worst_p, relative(p, c.p));
    worst_q = std::max(worst_q, relative(q, c.q));
    EXPECT_LT(relative(share, c.occupancy), 1e-12);
  }
  EXPECT_LT(worst_p, 1e-12);
  EXPECT_LT(worst_q, 1e-12);
}

TEST(ControlOperating, TablesOverTheTimeOfDayHaveTheSameBits) {
  const Rich& r = rich();
  const auto film = std::find_if(r.machine.films.begin(), r.machine.films.end(),
                                 [](const mesh::FilmSpec& one) { return one.id == "ventilation"; });
  Index term = 0;
  while (r.layout.terms[term].kind != solver::TermKind::film ||
         r.layout.terms[term].item != film - r.machine.films.begin())
    ++term;
  const int hour = r.operating.channels().index(mesh::time_of_day);
  ASSERT_GE(hour, 0);
  VectorXd row = r.operating.channels().defaults();
  const VectorXd inlet = VectorXd::Zero(r.model.coolants), none;
  const auto both = [&](double at) {
    row[hour] = at;
    VectorXd p(r.model.terms), q(r.model.inputs), share(r.model.terms);
    tt_coefficients(&r.model, row.data(), inlet.data(), nullptr, p.data(), q.data(), share.data());
    EXPECT_EQ(p[term], r.operating.coefficients(row, inlet, none).p[term]) << at;
    return p[term];
  };
  for (const double at : {-30.1, -1e-18, 5.7, 23.999999999999996, 24.0, 54.3, 87600.7}) both(at);
  EXPECT_NEAR(both(5.75), 5.5, 1e-12);
  EXPECT_NEAR(both(5.75 - 48.0), 5.5, 1e-12) << "two days before";
  EXPECT_NEAR(both(24.0), 2.0, 1e-12);
  EXPECT_EQ(both(solver::not_given), 0.0) << "not told";
}

TEST(ControlOperating, PosesRowsAndGuidesEqualThoseOfTheProgram) {
  const Rich& r = rich();
  test::Uniform number(8);
  VectorXd row = r.operating.channels().defaults(), held = row;
  for (int i = 0; i < 200; ++i) {
    VectorXd given = test::random_row(r.machine, r.operating.channels(), number);
    for (double& value : given)
      if (number(0.0, 1.0) < 0.5) value = solver::not_given;
    r.operating.channels().update(given, row);
    tt_update_row(&r.model, given.data(), held.data());
    for (Index k = 0; k < row.size(); ++k) {
      ASSERT_EQ(std::isnan(row[k]), std::isnan(held[k])) << r.operating.channels().names()[k];
      if (!std::isnan(row[k])) {
        ASSERT_EQ(row[k], held[k]);
      }
    }
    VectorXd pose(r.model.axes), guide(r.model.coolants);
    tt_pose(&r.model, row.data(), pose.data());
    tt_guide_K(&r.model, row.data(), guide.data());
    EXPECT_EQ((pose - r.operating.pose(row)).norm(), 0.0);
    EXPECT_LT((guide - r.operating.guide_K(row)).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(ControlOperating, ChillersFollowThoseOfTheProgram) {
  const Rich& r = rich();
  test::Uniform number(9);
  VectorXd readings = random_temperatures(r.model.readings, number);
  VectorXd row = test::random_row(r.machine, r.operating.channels(), number);
  solver::Chiller chiller(r.machine, r.layout, r.operating.channels(),
                          solver::chiller_set_points(r.machine, r.layout, readings, r.operating.guide_K(row)));
  tt_arena count{nullptr, 0};
  tt_chiller_in(&count, &r.model);
  std::vector<double> block(count.used / sizeof(double));
  tt_arena arena{reinterpret_cast<unsigned char*>(block.data()), 0};
  tt_chiller core = tt_chiller_in(&arena, &r.model);
  VectorXd guide = r.operating.guide_K(row);
  tt_chiller_start(&r.model, readings.data(), guide.data(), &core);
  double worst = 0.0, moved = 0.0;
  for (int i = 0; i < 400; ++i) {
    if (i % 10 == 0) row = test::random_row(r.machine, r.operating.channels(), number);
    for (double& reading : readings) reading += number(-0.5, 0.5);
    guide = r.operating.guide_K(row);
    const double step = number(1.0, 60.0);
    const VectorXd inlet = chiller.advance(row, readings, guide, step);
    tt_chiller_advance(&r.model, row.data(), readings.data(), guide.data(), step, &core);
    for (Index k = 0; k < inlet.size(); ++k) {
      worst = std::max({worst, std::abs(inlet[k] - core.inlet[k]), std::abs(chiller.outlet_K()[k] - core.outlet[k])});
      EXPECT_EQ(chiller.running(k), core.running[k] != 0);
      moved = std::max(moved, std::abs(inlet[k]));
    }
  }
  EXPECT_LT(worst, 1e-9);
  EXPECT_GT(moved, 1.0);
}

TEST(ControlOperating, MeanRowsEqualThoseOfTheProgram) {
  const Rich& r = rich();
  test::Uniform number(10);
  InputMean mean(r.machine, r.operating.channels());
  tt_arena count{nullptr, 0};
  tt_mean_row_in(&count, &r.model);
  std::vector<double> block(count.used / sizeof(double));
  tt_arena arena{reinterpret_cast<unsigned char*>(block.data()), 0};
  tt_mean_row core = tt_mean_row_in(&arena, &r.model);
  for (int step = 0; step < 50; ++step) {
    VectorXd row = test::random_row(r.machine, r.operating.channels(), number);
    for (int i = 0; i <= step % 5; ++i) {
      if (step % 2 == 0) row = test::random_row(r.machine, r.operating.channels(), number);
      const double duration = number(0.1, 20.0);
      mean.add(row, duration);
      tt_mean_add(&r.model, row.data(), duration, &core);
    }
    EXPECT_EQ(mean.duration(), *core.duration);
    const VectorXd& expected = mean.take();
    VectorXd taken(expected.size());
    tt_mean_take(&r.model, &core, taken.data());
    for (Index k = 0; k < taken.size(); ++k) {
      ASSERT_EQ(std::isnan(taken[k]), std::isnan(expected[k])) << r.operating.channels().names()[k];
      if (!std::isnan(taken[k])) {
        ASSERT_NEAR(taken[k], expected[k], 1e-14 * std::abs(expected[k])) << r.operating.channels().names()[k];
      }
    }
  }
}

}  // namespace
}  // namespace thermotwin::compensation
