// SPDX-License-Identifier: GPL-3.0-or-later
// An unknown source on a machine that is measured on a finer mesh, with other parameters and noise.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/causes/parameter_sizes.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/report/diagnosis_json.h"
#include "mesh/machine/file.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/reduced_simulation.h"
#include "tests/machines/meshed_boxes.h"

namespace {

using namespace thermotwin;
using diagnosis::Kind;
using diagnosis::Diagnosis;

struct Hidden {
  const char *body, *box, *law;  ///< of the machine that is measured
  Eigen::Vector3d place;         ///< m
  const char* follows;
  double power;  ///< W at the largest value of the record
};
void PrintTo(const Hidden& hidden, std::ostream* out) { *out << hidden.body << " " << hidden.follows; }

compensation::Measurement measured(const Hidden& hidden, std::uint64_t seed,
                                   const std::string& phases = meshed::shift) {
  std::string text = meshed::machine_text();
  if (hidden.body) {
    text += fmt::format(
        "\n[[surface]]\nid = \"unknown.place\"\nbody = \"{}\"\nrule = {{ {} }}\n[[source]]\nid = \"unknown\"\nlaw = [ "
        "{} ]\n"
        "place = [ {{ surface = \"unknown.place\" }} ]\n",
        hidden.body, hidden.box, hidden.law);
  }
  const mesh::Machine machine = compensation::perturbed(mesh::parse_machine(text, "boxes/machine.toml"), seed, 0.7);
  const std::vector<mesh::Pose> poses{mesh::parse_pose(machine, "X=0,Z=0", "test"),
                                      mesh::parse_pose(machine, "X=150,Z=80", "test"),
                                      mesh::parse_pose(machine, "X=-150,Z=-80", "test")};
  compensation::Measurement m = compensation::measure_virtually(
      meshed::full_model(machine, 2), meshed::load(machine, "shift", phases, "06:00"), poses,
      {.sensor_noise_K = 0.03, .probe_noise_um = 0.2, .seed = seed, .mesh_cache = {}});
  m.starts_at_h = 6.0;  // a source may follow the time of day in all of them
  return m;
}

std::string listed(const Diagnosis& d) {
  std::string text = d.sentence + "\n";
  for (std::size_t i = 0; i < std::min<std::size_t>(6, d.ranking.size()); ++i) {
    const auto& r = d.ranking[i];
    text += fmt::format("  {:.3f} {} {} {} {:.3g} +- {:.2g}, log {:.1f}\n", r.probability, name_of(r.parameter.kind),
                        r.parameter.where, r.parameter.missing ? "follows " + r.parameter.missing->follows : "",
                        r.value, r.std, r.log_evidence);
  }
  return text;
}

class MissingSource : public ::testing::TestWithParam<Hidden> {};

TEST_P(MissingSource, IsFoundWhereItIs) {
  const Hidden& hidden = GetParam();
  const Diagnosis d = diagnosis::diagnose(meshed::reduced(), measured(hidden, 11), {});
  std::printf("%s", listed(d).c_str());
  ASSERT_FALSE(d.ranking.empty());
  const diagnosis::RankedCause& first = d.ranking.front();
  ASSERT_EQ(first.parameter.kind, Kind::source_missing) << listed(d);
  const diagnosis::MissingSource& found = *first.parameter.missing;
  const double off = (found.centre - hidden.place).norm();
  std::printf("off by %.0f mm, 95 %% region of %.0f mm\n", 1e3 * off, 1e3 * found.region95);
  EXPECT_EQ(found.body, hidden.body);
  EXPECT_LT(off, 0.15);
  EXPECT_LT(off, found.region95);
  EXPECT_EQ(found.follows, hidden.follows);
  EXPECT_NEAR(first.value, hidden.power, 0.25 * hidden.power);
  if (found.daily) {
    // A round course on half a day of record: place, hours and power are found, but the explanation counts as strained.
    EXPECT_NE(d.verdict, diagnosis::Verdict::no_discrepancy) << listed(d);
    EXPECT_NEAR(found.daily->from_h, 10.0, 0.6);
    EXPECT_NEAR(found.daily->to_h, 12.0, 0.6);
    return;
  }
  EXPECT_EQ(d.verdict, diagnosis::Verdict::explained) << listed(d);

  ASSERT_FALSE(d.extended_machine_text.empty()) << "the gain is certain";
  const mesh::Machine extended = mesh::parse_machine(d.extended_machine_text, "boxes/machine.toml");
  ASSERT_EQ(extended.sources.size(), meshed::machine().sources.size() + 1);
  ASSERT_EQ(d.causes.front().series.columns[1], "power_W");
  EXPECT_NEAR(d.causes.front().series.values.col(1).maxCoeff(), first.value, 1e-6 * hidden.power);
  const auto json = nlohmann::json::parse(diagnosis::diagnosis_json(d))["causes"][0];
  EXPECT_EQ(json["location"]["body"], hidden.body);
  EXPECT_EQ(json["follows"], hidden.follows);
}

INSTANTIATE_TEST_SUITE_P(
    Places, MissingSource,
    ::testing::Values(Hidden{"column",
                             "box_min_mm = [60, 379, 300], box_max_mm = [121, 381, 480]",
                             "{ input = \"spindle.speed_rpm\", at = [0, 4000, 12000], power_W = [0, 45, 130] }",
                             {0.09, 0.38, 0.39},
                             "spindle.speed_rpm",
                             98},
                      Hidden{"bed",
                             "box_min_mm = [-401, -130, -180], box_max_mm = [-399, 40, -20]",
                             "{ input = \"machine.on\", at = [0, 1], power_W = [0, 90] }",
                             {-0.4, -0.045, -0.1},
                             "machine.on",
                             90},
                      // The sun through a window, with a course of its own: from nine, most at eleven, gone at one.
                      Hidden{"column",
                             "box_min_mm = [60, 379, 300], box_max_mm = [121, 381, 480]",
                             "{ input = \"day.time_h\", at = [9, 10, 11, 12, 13], power_W = [0, 70, 100, 70, 0] }",
                             {0.09, 0.38, 0.39},
                             "day.time_h",
                             95}));

/// The state of the cutting fluid becomes another input's share of its largest value.
void let_fluid_change_as(const std::string& input, compensation::Measurement& m) {
  const auto other =
      std::find_if(m.channels.begin(), m.channels.end(), [&](const auto& c) { return c.input == input; });
  ASSERT_NE(other, m.channels.end());
  const Eigen::VectorXd share = m.values(*other) / m.values(*other).maxCoeff();
  std::erase_if(m.channels, [](const auto& c) { return c.input == "cutting_fluid.on"; });
  compensation::MeasuredChannel fluid;
  fluid.id = fluid.input = "cutting_fluid.on";
  fluid.kind = compensation::ChannelKind::state;
  fluid.unit = "1";
  fluid.column = std::ssize(m.data.columns);
  m.channels.push_back(fluid);
  m.data.columns.push_back(fluid.id);
  m.data.values.conservativeResize(Eigen::NoChange, fluid.column + 1);
  m.data.values.col(fluid.column) = share;
}

// A record in which two inputs change alike cannot tell which of them the heat follows: one cause that names both.
TEST(MissingSource, InputsThatChangeAlikeShareOneCause) {
  compensation::Measurement m =
      measured({"column",
                "box_min_mm = [60, 379, 300], box_max_mm = [121, 381, 480]",
                "{ input = \"spindle.speed_rpm\", at = [0, 4000, 12000], power_W = [0, 45, 130] }",
                {0.09, 0.38, 0.39},
                "spindle.speed_rpm",
                98},
               11);
  let_fluid_change_as("spindle.speed_rpm", m);
  const Diagnosis d = diagnosis::diagnose(meshed::reduced(), m, {});
  ASSERT_EQ(d.verdict, diagnosis::Verdict::explained) << listed(d);
  const diagnosis::MissingSource& found = *d.causes.front().parameter.missing;
  EXPECT_EQ(found.follows, "spindle.speed_rpm");
  EXPECT_EQ(found.alike, (std::vector<std::string>{"cutting_fluid.on"}));
  EXPECT_EQ(nlohmann::json::parse(diagnosis::diagnosis_json(d))["causes"][0]["follows_or"][0], "cutting_fluid.on");
  EXPECT_NE(d.sentence.find("follows spindle.speed_rpm or cutting_fluid.on"), std::string::npos) << d.sentence;
  const std::string extended =
      diagnosis::extended_text(meshed::machine(), d.causes.front().parameter, 98.0, 5.0, "test");
  EXPECT_NE(extended.find("(or cutting_fluid.on)"), std::string::npos) << extended.substr(extended.size() - 400);
  ASSERT_FALSE(d.actions.empty());
  EXPECT_NE(d.actions.front().find("Run them one after another"), std::string::npos) << d.actions.front();
}

// The machine is switched off for a while, and the fluid with it: the heat follows the one or the other.
TEST(MissingSource, FollowsTheMachineThatIsSwitchedOff) {
  std::string phases = meshed::shift;
  const auto switch_in = [&](const std::string& phase, const std::string& to) {
    const std::string name = "\"" + phase + "\"\n";
    for (std::size_t at = phases.find(name); at != std::string::npos; at = phases.find(name, at + 1))
      phases.insert(at + name.size(), "machine_on = " + to + "\n");
  };
  switch_in("rest", "false");
  switch_in("both", "true");
  compensation::Measurement m = measured({"bed",
                                          "box_min_mm = [-401, -130, -180], box_max_mm = [-399, 40, -20]",
                                          "{ input = \"machine.on\", at = [0, 1], power_W = [0, 90] }",
                                          {-0.4, -0.045, -0.1},
                                          "machine.on",
                                          90},
                                         11, phases);
  let_fluid_change_as("machine.on", m);
  const Diagnosis d = diagnosis::diagnose(meshed::reduced(), m, {});
  ASSERT_EQ(d.verdict, diagnosis::Verdict::explained) << listed(d);
  const diagnosis::MissingSource& found = *d.causes.front().parameter.missing;
  EXPECT_EQ(found.follows, "machine.on") << listed(d);
  EXPECT_EQ(found.alike, (std::vector<std::string>{"coolant.main.on", "cutting_fluid.on"}));
}

TEST(MissingSource, IsNotSeenWhereThereIsNone) {
  const Diagnosis d = diagnosis::diagnose(meshed::reduced(), measured({}, 12), {});
  EXPECT_EQ(d.verdict, diagnosis::Verdict::no_discrepancy) << listed(d);
}

TEST(MissingSource, ExtendedMachineRunsInBothModelsAlike) {
  const mesh::Machine machine = meshed::machine();
  diagnosis::Parameter cause = diagnosis::make_parameter(Kind::source_missing, "column");
  auto missing = std::make_shared<diagnosis::MissingSource>();
  const auto& patches = meshed::reduced().patches.items;
  const auto patch = std::find_if(patches.begin(), patches.end(),
                                  [](const auto& p) { return p.surface.body == "column" && p.centre.z() > 0.3; });
  ASSERT_NE(patch, patches.end());
  missing->surface = patch->surface;
  missing->follows = "spindle.speed_rpm";
  missing->at = 9000;
  missing->most = 12000;
  cause.missing = missing;
  const mesh::Machine extended =
      mesh::parse_machine(diagnosis::extended_text(machine, cause, 80.0, 4.0, "test"), machine.path);
  const auto load = meshed::load(extended, "shift", meshed::shift);
  const auto poses = mesh::workspace_poses(machine);
  const auto full = solver::run_campaign(meshed::full_model(extended), {load}, {}).front(),
             nominal = solver::run_campaign(meshed::full_model(machine), {load}, {}).front();
  const auto reduced =
      reduction::simulate_reduced(diagnosis::model_of_changed(meshed::reduced(), extended), extended, load, poses);
  const double effect = reduction::compare(nominal, full).max_um, error = reduction::compare(full, reduced).max_um;
  std::printf("80 W move the TCP by up to %.2f um; reduced against full %.3f um\n", effect, error);
  EXPECT_GT(effect, 1.0);
  EXPECT_LT(error, 0.05 * effect + 0.1);
  // The same machine, told by its numbers.
  const mesh::Machine told = diagnosis::with_parameter(machine, cause, 80.0);
  EXPECT_EQ(told.sources.back().id, extended.sources.back().id);
  EXPECT_NEAR(told.sources.back().laws[0].power[1], extended.sources.back().laws[0].power[1], 1e-6);
  EXPECT_EQ(*told.surfaces.back().any_of[0].box_min, *extended.surfaces.back().any_of[0].box_min);
}

}  // namespace
