// SPDX-License-Identifier: GPL-3.0-or-later
// Plans on the five-axis machine of lumps: the NC program against the load program that is made beside it, the points
// against the sphere, limits.
#include "metrology/plan/test_plan.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <sstream>

#include "core/error.h"
#include "core/units.h"
#include "metrology/plan/sphere.h"
#include "solver/elastic/tcp.h"
#include "solver/operation/channels.h"
#include "solver/operation/load_program.h"
#include "tests/machines/five_axis.h"

namespace thermotwin::metrology {
namespace {

namespace units = core::units;
using compensation::test::five_axis_machine;

PlanOptions short_plan(TestKind kind) {
  PlanOptions options;
  options.kind = kind;
  options.warm_up_h = 0.5;
  options.cool_down_h = 0.25;
  options.height_mm = 200;
  return options;
}

/// Travel of each axis and the duration, from the text of an NC program: G00 at rapid, G01 at F, G02 and G03 by their
/// radius, G04, G91.
struct NcReading {
  std::map<std::string, double> path;  ///< mm and deg
  double seconds = 0;
};

NcReading read_nc(const std::string& text, const mesh::Machine& machine) {
  NcReading reading;
  std::map<std::string, double> at;
  const mesh::Pose home = mesh::home_pose(machine);
  for (Eigen::Index i = 0; i < home.size(); ++i) at[machine.axes[i].id] = mesh::pose_values(machine, home)[i];
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] != 'N') continue;
    line = line.substr(0, line.find('('));
    std::istringstream words(line);
    bool relative = false;
    int motion = -1;
    double feed = 0, dwell = 0;
    std::map<std::string, double> target, centre;
    for (std::string word; words >> word;) {
      const double value = std::atof(word.c_str() + 1);
      if (word == "G91") relative = true;
      if (word == "G00" || word == "G01" || word == "G02" || word == "G03") motion = static_cast<int>(value);
      if (word[0] == 'F') feed = value;
      if (word[0] == 'P') dwell = value;
      if (word[0] >= 'I' && word[0] <= 'K') centre[std::string(1, "XYZ"[word[0] - 'I'])] = value;
      if (at.contains(word.substr(0, 1))) target[word.substr(0, 1)] = value + (relative ? at[word.substr(0, 1)] : 0.0);
    }
    reading.seconds += dwell;
    if (motion < 0) continue;
    double linear = 0, rotary = 0, rapid = 0;
    for (const auto& [id, to] : target) {
      const mesh::Axis& axis = machine.axes[machine.axis_index(id)];
      const double way = std::abs(to - at[id]), unit = axis.kind == mesh::AxisKind::linear ? units::mm : units::deg;
      if (axis.kind == mesh::AxisKind::linear)
        linear += way * way;
      else
        rotary = std::max(rotary, way);
      rapid = std::max(rapid, way * unit / axis.rapid);
      if (motion < 2) reading.path[id] += way;
    }
    if (motion == 0) reading.seconds += rapid;
    if (motion == 1) reading.seconds += 60.0 * (linear > 0 ? std::sqrt(linear) : rotary) / feed;
    if (motion >= 2) {
      // The circle, walked in small steps.
      const double radius = std::hypot(centre.begin()->second, std::next(centre.begin())->second);
      reading.path["B"] += rotary;
      reading.seconds += 60.0 * rotary * units::deg * radius / feed;
      const std::string u = centre.begin()->first, v = std::next(centre.begin())->first;
      const double cu = at[u] + centre[u], cv = at[v] + centre[v];
      // In G18 the plane is z, x: a positive turn about y takes z to x.
      const double sense = (motion == 3 ? 1.0 : -1.0) * (u == "X" && v == "Z" ? -1.0 : 1.0);
      double pu = at[u], pv = at[v];
      constexpr int steps = 2000;
      for (int k = 1; k <= steps; ++k) {
        const double turned = sense * rotary * units::deg * k / steps;
        const double nu = cu + (at[u] - cu) * std::cos(turned) - (at[v] - cv) * std::sin(turned);
        const double nv = cv + (at[u] - cu) * std::sin(turned) + (at[v] - cv) * std::cos(turned);
        reading.path[u] += std::abs(nu - pu);
        reading.path[v] += std::abs(nv - pv);
        pu = nu;
        pv = nv;
      }
      EXPECT_NEAR(pu, target[u], 1e-3) << line;
      EXPECT_NEAR(pv, target[v], 1e-3) << line;
    }
    for (const auto& [id, to] : target) at[id] = to;
  }
  return reading;
}

/// Travel of each axis in the load program: feed times time.
std::map<std::string, double> travel_of(const solver::LoadProgram& load, const mesh::Machine& machine) {
  const solver::Channels channels(machine);
  std::map<std::string, double> travel;
  double from = 0;
  for (const double to : load.step_ends()) {
    const Eigen::VectorXd row = load.row(from, to);
    for (const mesh::Axis& axis : machine.axes) {
      const std::string unit = axis.kind == mesh::AxisKind::linear ? "mm" : "deg";
      travel[axis.id] += row[channels.index("axis." + axis.id + ".feed_" + unit + "_min")] * (to - from) / 60.0;
    }
    from = to;
  }
  return travel;
}

TEST(TestPlan, LoadProgramTravelsAsTheNcProgram) {
  const mesh::Machine machine = five_axis_machine();
  for (std::size_t k = 0; k < test_kinds().size(); ++k) {
    PlanOptions options = short_plan(static_cast<TestKind>(k));
    if (options.kind == TestKind::rtest_continuous) {
      options.axis = "B";
      options.radius_mm = 0;
      options.height_mm = 260;
      options.angles_deg = {-20, 20};
    }
    if (options.kind == TestKind::rtest_grid) {
      options.tilts_deg = {0, 10};
      options.radius_mm = 100;
    }
    if (options.kind == TestKind::random_cycle) options.loads = {"C", "B", "X"};
    const TestPlan plan = make_plan(machine, options);
    const NcReading nc = read_nc(nc_text(machine, plan.timeline, "test"), machine);
    const std::string text = load_text(machine, plan.timeline, "test", std::nullopt, 20.0);
    const solver::LoadProgram load = solver::LoadProgram::parse(text, "plan.toml", machine);
    const std::string& kind = test_kinds()[k];
    EXPECT_NEAR(load.duration(), plan.timeline.now(), 1e-6) << kind;
    EXPECT_NEAR(nc.seconds, plan.timeline.now(), 0.02) << kind;
    for (const auto& [id, travel] : travel_of(load, machine)) {
      const auto found = nc.path.find(id);
      const double written = found == nc.path.end() ? 0.0 : found->second;
      EXPECT_NEAR(travel, written, 1e-3 + 2e-5 * written) << kind << " " << id;
    }
    EXPECT_FALSE(plan.points.empty());
    for (const PlannedPoint& point : plan.points) EXPECT_LT(point.time, load.duration()) << kind;
  }
}

TEST(TestPlan, ThePointsAreOnTheSphere) {
  const mesh::Machine machine = five_axis_machine();
  PlanOptions options = short_plan(TestKind::rtest_grid);
  options.tilts_deg = {0, 20};
  options.radius_mm = 100;
  const TestPlan plan = make_plan(machine, options);
  const Eigen::Vector3d sphere = sphere_on_table(machine, 0.1, 0.0, 0.2);
  std::map<int, int> of_cycle;
  for (const PlannedPoint& point : plan.points) {
    ++of_cycle[point.cycle];
    const int table = machine.body_index("table");
    const Eigen::Vector3d place = mesh::body_transform(machine, table, point.pose) * sphere;
    EXPECT_LT((place - point.sphere).norm(), 1e-9);
    EXPECT_LT((solver::tcp_position(machine, point.pose) - place).norm(), 1e-9);
  }
  // Two tilts of four points and the first one again; a reference, six loads, three standstills.
  EXPECT_EQ(of_cycle.size(), 10u);
  for (const auto& [cycle, points] : of_cycle) EXPECT_EQ(points, 9);
}

TEST(TestPlan, IntervalsAreAsLongAsAsked) {
  const mesh::Machine machine = five_axis_machine();
  const TestPlan plan = make_plan(machine, short_plan(TestKind::linear_axis));
  for (const Stage& stage : plan.timeline.stages()) {
    if (stage.cycle > 0) continue;
    EXPECT_NEAR(stage.duration, 300.0, 1e-6) << stage.name;
  }
  EXPECT_EQ(plan.tested, "X");
}

TEST(TestPlan, AHeldPositionIsHeldInTheLoadProgram) {
  const mesh::Machine machine = five_axis_machine();
  PlanOptions options = short_plan(TestKind::random_cycle);
  options.warm_up_h = 3;
  options.loads = {"X"};
  const TestPlan plan = make_plan(machine, options);
  const solver::LoadProgram load =
      solver::LoadProgram::parse(load_text(machine, plan.timeline, "test", std::nullopt, 20.0), "plan.toml", machine);
  const solver::Channels channels(machine);
  int held = 0;
  for (const Stage& stage : plan.timeline.stages()) {
    // A dwell of nearly the whole interval: the axis has gone to a position and stands there.
    double dwell = 0.0;
    for (const NcBlock& block : stage.blocks)
      if (block.words.starts_with("G04")) dwell += block.duration;
    if (stage.cycle > 0 || dwell < 290.0) continue;
    ++held;
    const double end = stage.start + stage.duration, middle = end - 0.5 * dwell;
    const Eigen::VectorXd row = load.row(middle, end);
    EXPECT_EQ(row[channels.index("axis.X.feed_mm_min")], 0.0) << stage.name;
    EXPECT_NEAR(row[channels.index("axis.X.position_mm")], stage.axes[0].end / units::mm, 1e-9) << stage.name;
  }
  EXPECT_GT(held, 5);
}

TEST(TestPlan, RandomCyclesFollowTheirSeedAndLimits) {
  const mesh::Machine machine = five_axis_machine();
  PlanOptions options = short_plan(TestKind::random_cycle);
  options.warm_up_h = 20;
  options.cool_down_h = 0;
  options.speeds = {10, 40};
  options.standstills = true;
  const auto speeds = [&](std::uint64_t seed) {
    options.seed = seed;
    std::vector<double> rpm;
    const TestPlan plan = make_plan(machine, options);
    for (const Stage& stage : plan.timeline.stages()) {
      if (stage.cycle == 0) rpm.push_back(stage.axes[4].path / stage.duration / units::rpm);
    }
    return rpm;
  };
  const std::vector<double> one = speeds(1);
  EXPECT_EQ(one, speeds(1));
  EXPECT_NE(one, speeds(2));
  ASSERT_EQ(one.size(), 240u);
  int changes = 0, standing = 0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    // Whole turns: below the drawn speed by less than a turn in five minutes.
    EXPECT_TRUE(one[i] == 0.0 || (one[i] > 10.0 - 0.21 && one[i] < 40.0 + 1e-9)) << one[i];
    standing += one[i] == 0.0;
    if (i > 0 && std::abs(one[i] - one[i - 1]) > 1e-6) {
      ++changes;
      EXPECT_TRUE(one[i] == 0.0 || one[i - 1] == 0.0);
    }
  }
  EXPECT_NEAR(changes, 120, 35);  // half of the intervals, five standard deviations
  EXPECT_NEAR(standing, 120, 60);
}

/// The message of a plan that is refused.
std::string refused(const PlanOptions& options) {
  const mesh::Machine machine = five_axis_machine();
  try {
    make_plan(machine, options);
  } catch (const core::InputError& error) {
    return error.what();
  }
  return "";
}

TEST(TestPlan, LimitsOfTheMachineAreKept) {
  const auto says = [](const std::string& text, const char* words) { return text.find(words) != std::string::npos; };
  PlanOptions low = short_plan(TestKind::rtest);
  low.height_mm = 25;
  EXPECT_PRED2(says, refused(low), "axis Z: -95 mm; allowed: its travel 0 to 500 mm");
  PlanOptions fast = short_plan(TestKind::rtest);
  fast.speed = 300;
  EXPECT_PRED2(says, refused(fast), "--speed: 300; allowed: at most the rapid of axis C, 200");
  PlanOptions head = short_plan(TestKind::rtest);
  head.axis = "X";
  EXPECT_PRED2(says, refused(head), "allowed: a rotary axis");
  head.axis = "D";
  EXPECT_PRED2(says, refused(head), "axes of the machine: X, Y, Z, B, C");
  PlanOptions spindle = short_plan(TestKind::spindle);
  spindle.speed = 20000;
  EXPECT_PRED2(says, refused(spindle), "0 to 12000 rpm");
  PlanOptions air = short_plan(TestKind::etve);
  air.loads = {"X"};
  EXPECT_PRED2(says, refused(air), "the machine stands");
  PlanOptions cut = short_plan(TestKind::rtest);
  cut.record_s = 2;
  EXPECT_PRED2(says, refused(cut), "more than twice cut_s");
}

}  // namespace
}  // namespace thermotwin::metrology
