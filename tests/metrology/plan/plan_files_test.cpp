// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/plan/plan_files.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/file.h"
#include "tests/core/reference_page.h"
#include "tests/core/temporary_folder.h"
#include "tests/machines/five_axis.h"

namespace thermotwin::metrology {
namespace {

using compensation::test::five_axis_machine;

TEST(PlanFiles, APlanIsReadAsItWasWritten) {
  mesh::Machine machine = five_axis_machine();
  const Eigen::Vector3d offset(0, 0, -0.1);
  const core::TemporaryFolder folder;
  ProbeSetup probes;
  probes.on_table = true;
  probes.contact_radius = 0.02;
  PlanOptions options;
  options.warm_up_h = 0.25;
  options.cool_down_h = 0;
  options.air_C = {20.0, 25.0};
  mesh::Machine moved = machine;
  move_tool_point(moved, offset);
  const TestPlan plan = make_plan(moved, options);
  write_plan(folder / "plan", moved, plan, probes, offset);
  const PlanFolder read = read_plan(folder / "plan", machine);
  EXPECT_EQ(read.kind, "rtest");
  EXPECT_EQ(read.tested, "C");
  EXPECT_TRUE(read.is_rtest);
  EXPECT_LT((read.tool_offset - offset).norm(), 1e-12);
  EXPECT_TRUE(read.probes.on_table);
  EXPECT_NEAR(read.probes.contact_radius, 0.02, 1e-12);
  ASSERT_EQ(read.points.size(), plan.points.size());
  for (std::size_t i = 0; i < plan.points.size(); ++i) {
    EXPECT_NEAR(read.points[i].time, plan.points[i].time, 1e-6);
    EXPECT_EQ(read.points[i].cycle, plan.points[i].cycle);
    EXPECT_EQ(read.points[i].place, plan.points[i].place);
    EXPECT_LT((read.points[i].pose - plan.points[i].pose).norm(), 1e-9);
    EXPECT_LT((read.points[i].sphere - plan.points[i].sphere).norm(), 1e-9);
  }
  const core::Table rows = core::read_csv(folder / "plan" / "rows.csv");
  EXPECT_NEAR(rows.column("air.T_C").minCoeff(), 20.0, 0.5);
  EXPECT_GT(rows.column("air.T_C").maxCoeff(), 23.0);  // rows are means over a phase
  EXPECT_LT(rows.column("air.T_C").maxCoeff(), 25.0);
  EXPECT_GT(rows.column("axis.C.feed_deg_min").maxCoeff(), 30000.0);
}

TEST(PlanFiles, SlipsAreRefused) {
  const mesh::Machine machine = five_axis_machine();
  const core::TemporaryFolder folder;
  PlanOptions options;
  options.warm_up_h = options.cool_down_h = 0.25;
  write_plan(folder / "plan", machine, make_plan(machine, options), ProbeSetup(), Eigen::Vector3d::Zero());
  const std::string text = core::read_file(folder / "plan" / "plan.toml");
  const auto refused = [&](const std::string& with) {
    core::write_file(folder / "plan" / "plan.toml", with);
    try {
      read_plan(folder / "plan", machine);
    } catch (const core::InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const auto replaced = [&](const std::string& old, const std::string& with) {
    std::string changed = text;
    changed.replace(changed.find(old), old.size(), with);
    return changed;
  };
  EXPECT_NE(refused(replaced("\"lumps\"", "\"other\"")).find("the machine of the case"), std::string::npos);
  EXPECT_NE(refused(replaced("\"rtest\"", "\"rtset\"")).find("plan.toml:3 kind"), std::string::npos);
  const std::string flat =
      replaced("directions = [", "directions = [[1, 0, 0], [0, 1, 0], [1, 1, 0]]\nno_one_reads_this = [");
  EXPECT_NE(refused(flat).find("in different directions"), std::string::npos) << refused(flat);
  EXPECT_EQ(refused(text), "");
}

TEST(PlanFiles, ReferencePageIsThatOfTheReader) { core::expect_reference_page("plan", plan_keys(), "metrology_tests"); }

}  // namespace
}  // namespace thermotwin::metrology
