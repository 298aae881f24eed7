// SPDX-License-Identifier: GPL-3.0-or-later
// Heats and operating points of a day of work in the online core beside those of the classes.
#include "compensation/control/day_of_work.h"

#include <gtest/gtest.h>

#include "compensation/control/work_before.h"
#include "tests/compensation/control/day_of_work.h"
#include "tests/compensation/control/observer_parts.h"
#include "tests/compensation/control/unit_capacity.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const reduction::ReducedModel& lumps() {
  static const reduction::ReducedModel model = test::unit_capacity(test::lumped_model());
  return model;
}

void coefficients(const void* with, const double* row, double* p, double* q) {
  const auto& operating = *static_cast<const solver::OperatingModel*>(with);
  const VectorXd values = Eigen::Map<const VectorXd>(row, operating.channels().size());
  const solver::Coefficients c = operating.coefficients(values, VectorXd::Zero(std::ssize(lumps().machine.coolants)));
  Eigen::Map<VectorXd>(p, c.p.size()) = c.p;
  Eigen::Map<VectorXd>(q, c.q.size()) = c.q;
}

struct Core {
  solver::OperatingModel operating{lumps().machine, lumps().system.layout};
  test::ObserverParts parts{lumps(), {}, 0};
  test::InArena<tt_day, tt_day_model> day{tt_day_lay, parts.day()};
  VectorXd row = operating.channels().defaults();

  Core() {
    parts.set_coefficients(coefficients, &operating);
    row[operating.channels().index("axis.X.position_mm")] = 250.0;
    tt_day_set(day.get(), row.data());
  }
};

TEST(ControlDayOfWork, HasTheHeatsOfTheClass) {
  Core core;
  const MatrixXd heats = test::Day(lumps(), core.row).heats();
  ASSERT_EQ(tt_day_heats(&core.parts.day()), heats.cols());
  for (Index k = 0; k < heats.cols(); ++k) {
    VectorXd heat(lumps().system.order());
    tt_day_heat(core.day.get(), static_cast<int>(k), heat.data());
    EXPECT_LE((heat - heats.col(k)).norm(), 1e-12 * heats.norm()) << k;
  }
  EXPECT_GT(heats.col(1).norm(), 1.0) << "the spindle";
}

TEST(ControlDayOfWork, StandsSweepsAndRestsWhereTheClassDoes) {
  Core core;
  const test::Day day(lumps(), core.row);
  for (const auto& [kind, row] :
       {std::pair{TT_DAY_OFF, &day.off()}, {TT_DAY_STANDING, &day.rest()}, {TT_DAY_SWEPT, &day.swept()}}) {
    VectorXd p(std::ssize(lumps().system.terms));
    tt_day_coefficients(core.day.get(), kind, p.data());
    MatrixXd matrix = lumps().system.conduction;
    for (Index j = 0; j < p.size(); ++j) matrix += p[j] * lumps().system.terms[j];
    EXPECT_EQ((matrix - day.operator_at(*row)).norm(), 0.0) << kind;
  }
  EXPECT_EQ(static_cast<int>(TT_DAY_OFF), static_cast<int>(TT_MODES_COOLING));
  EXPECT_EQ(static_cast<int>(TT_DAY_SWEPT), static_cast<int>(TT_MODES_SWEPT));
}

TEST(ControlDayOfWork, DrivesHeatAsInTheClassWhileTheMachineIsOn) {
  Core core;
  VectorXd row = core.row;
  const solver::Channels& channels = core.operating.channels();
  row[channels.index("spindle.speed_rpm")] = 3000.0;
  row[channels.index("axis.X.feed_mm_min")] = 9000.0;
  const std::vector<DriveHeat> drives = drive_heats(lumps(), core.operating, channels.defaults());
  ASSERT_EQ(core.parts.day().drives, std::ssize(drives));
  double largest = 0.0;
  for (const bool on : {true, false}) {
    row[channels.index("machine.on")] = on ? 1.0 : 0.0;
    for (Index d = 0; d < std::ssize(drives); ++d) {
      VectorXd heat(lumps().system.order());
      tt_day_drive_heat(core.day.get(), static_cast<int>(d), row.data(), heat.data());
      if (drives[d].channel < 0) continue;
      const VectorXd wanted = heat_at_half_speed(lumps().system, core.operating, drives[d], row);
      EXPECT_LE((heat - wanted).norm(), 1e-12 * (1.0 + wanted.norm())) << drives[d].name;
      EXPECT_TRUE(on || heat.norm() == 0.0);
      largest = std::max(largest, heat.norm());
    }
  }
  EXPECT_GT(largest, 1.0);
}

}  // namespace
}  // namespace thermotwin::compensation
