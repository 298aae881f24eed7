// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/machine/machine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <tuple>

#include "mesh/machine/file.h"
#include "mesh/machine/finer_pads.h"
#include "mesh/machine/flow_network.h"
#include "tests/mesh/samples.h"

using namespace thermotwin;
using samples::machine_text;
using samples::replaced;

namespace {

mesh::Machine small() { return mesh::parse_machine(machine_text(), "/there/machine.toml"); }

TEST(MachineFile, UnitsBecomeSi) {
  const mesh::Machine m = small();
  EXPECT_EQ(m.name, "small");
  EXPECT_DOUBLE_EQ(m.reference_C, 21.0);
  EXPECT_DOUBLE_EQ(m.coarse, 1.2);
  EXPECT_DOUBLE_EQ(m.standard, 0.55);
  EXPECT_DOUBLE_EQ(m.material("iron").young, 120e9);
  EXPECT_DOUBLE_EQ(m.material("iron").specific_heat.std_percent, 5.0);
  EXPECT_EQ(m.bodies[1].cad, "/there/slide.stl");
  EXPECT_DOUBLE_EQ(m.bodies[0].unit_m, 1e-3);
  EXPECT_DOUBLE_EQ(m.bodies[1].unit_m, 1.0);
  EXPECT_DOUBLE_EQ(m.bodies[0].element_size, 0.09);
  EXPECT_FALSE(m.bodies[4].elastic);
  EXPECT_TRUE(m.axes[0].direction.isApprox(Eigen::Vector3d::UnitX()));
  EXPECT_DOUBLE_EQ(m.axes[0].rapid, 1.0);
  EXPECT_DOUBLE_EQ(m.axes[0].low, -0.4);
  EXPECT_DOUBLE_EQ(m.axes[1].high, 110.0 * std::numbers::pi / 180.0);
  EXPECT_DOUBLE_EQ(m.axes[1].rapid, 300.0 * std::numbers::pi / 180.0);
  EXPECT_DOUBLE_EQ(m.axes[1].origin.z(), 0.1);
  EXPECT_TRUE(m.axes[2].endless);
}

TEST(MachineFile, SurfacesAndJoints) {
  const mesh::Machine m = small();
  EXPECT_TRUE(m.surfaces[0].any_of.empty());
  EXPECT_EQ(m.surfaces[0].except.size(), 2u);
  EXPECT_EQ(m.surfaces[2].any_of.size(), 2u);
  EXPECT_NEAR(m.surfaces[2].any_of[0].max_angle, 10 * std::numbers::pi / 180, 1e-15);
  EXPECT_DOUBLE_EQ(m.surfaces[4].any_of[0].cylinder_radius, 0.02);
  EXPECT_DOUBLE_EQ(m.surfaces[4].any_of[0].tolerance, 1e-3);
  EXPECT_NE(m.surfaces[4].any_of[0].place.find("machine.toml:"), std::string::npos) << m.surfaces[4].any_of[0].place;
  const mesh::JointSpec& guide = m.joints[0];
  EXPECT_DOUBLE_EQ(guide.stiffness_normal.value, 300e9);
  EXPECT_DOUBLE_EQ(guide.stiffness_normal.std_percent, 20.0);
  EXPECT_DOUBLE_EQ(guide.stiffness_tangential.value, 200e9);
  EXPECT_DOUBLE_EQ(guide.reach, 0.004);
  EXPECT_EQ(guide.divide, Eigen::Vector3i(2, 1, 1));
  EXPECT_EQ(m.joints[1].sectors, 8);
  EXPECT_DOUBLE_EQ(m.joints[1].sector_point.z(), 0.01);
  EXPECT_DOUBLE_EQ(m.joints[1].sector_axis.x(), 1.0);
  EXPECT_DOUBLE_EQ(m.joints[1].stiffness_normal.value, 0.0);
  EXPECT_EQ(m.joints[2].ambient, "foundation");
  EXPECT_TRUE(m.joints[2].master.empty());
  EXPECT_EQ(m.joint_index("feet"), 2);
  EXPECT_EQ(m.surface_index("nowhere"), -1);
  EXPECT_DOUBLE_EQ(m.scales[0].head.z(), 0.005);
}

TEST(MachineFile, FinerPadsHaveMoreCellsWhereThereWereSeveral) {
  const mesh::Machine m = small(), finer = mesh::with_finer_pads(m, 3);
  EXPECT_EQ(finer.joints[0].divide, Eigen::Vector3i(6, 1, 1));
  EXPECT_EQ(finer.joints[1].sectors, 24);
  EXPECT_EQ(finer.joints[2].divide, m.joints[2].divide) << "one pad stays one";
  EXPECT_TRUE(mesh::has_divided_pads(m));
  mesh::Machine undivided = m;
  for (mesh::JointSpec& joint : undivided.joints) joint.divide.setOnes(), joint.sectors = 0;
  EXPECT_FALSE(mesh::has_divided_pads(undivided));
}

TEST(MachineFile, Physics) {
  const mesh::Machine m = small();
  EXPECT_EQ(m.ambients[1].follows, "air");
  EXPECT_DOUBLE_EQ(m.ambients[1].default_C.value, 18.5);  // that of air plus the offset
  EXPECT_EQ(m.films[0].kind, mesh::FilmKind::free_convection);
  EXPECT_EQ(m.films[0].orientation, mesh::Orientation::up);
  EXPECT_EQ(m.films[0].ambient, "air");
  EXPECT_DOUBLE_EQ(m.films[1].radius, 0.4);
  EXPECT_EQ(m.films[1].state, "cutting_fluid.on");
  EXPECT_EQ(m.films[2].kind, mesh::FilmKind::constant);
  EXPECT_DOUBLE_EQ(m.films[2].coefficient.value, 8.0);
  EXPECT_DOUBLE_EQ(m.coolants[0].segments[0].volume, 0.7e-3);
  EXPECT_DOUBLE_EQ(m.coolants[0].density, 815.0);
  EXPECT_EQ(m.sources[0].laws.size(), 2u);
  EXPECT_DOUBLE_EQ(m.sources[0].places[1].slave_share, 0.25);
  EXPECT_DOUBLE_EQ(m.sensors[0].point.y(), 0.002);
  EXPECT_DOUBLE_EQ(m.tcp.table_radius, 0.3);
  EXPECT_EQ(m.workspace.axes, std::vector<std::string>{"X"});
  EXPECT_EQ(m.workspace.table_axes, std::vector<std::string>{"B"});
  EXPECT_DOUBLE_EQ(m.workspace.table_positions[0][1], std::numbers::pi / 4);
  EXPECT_EQ(m.hash.size(), 16u);
  EXPECT_EQ(m.text, machine_text());
}

TEST(MachineFile, ReadingAsksForTheCadFiles) {
  const samples::Folder folder;
  const auto path = folder.write("machine.toml", machine_text());
  const std::string message = samples::message_of([&] { mesh::read_machine(path); });
  EXPECT_NE(message.find("bed.stl"), std::string::npos) << message;
  EXPECT_NE(message.find("machine.toml:"), std::string::npos) << message;
}

// Each row: text to replace, its replacement, words that the message must hold.
TEST(MachineFile, ACoolerMaySwitch) {
  EXPECT_EQ(small().coolants[0].control, mesh::ChillerControl::lag);
  const std::string guided = "guide_sensor = \"T1\"\n";
  const mesh::Machine m =
      mesh::parse_machine(replaced(machine_text(), guided,
                                   guided + "control = \"two_point\"\nband_K = 1.5\npull_down_K = 6\ndrift_up_K = 2\n"),
                          "machine.toml");
  EXPECT_EQ(m.coolants[0].control, mesh::ChillerControl::two_point);
  EXPECT_DOUBLE_EQ(m.coolants[0].band, 1.5);
  EXPECT_DOUBLE_EQ(m.coolants[0].pull_down, 6.0);
  EXPECT_DOUBLE_EQ(m.coolants[0].drift_up, 2.0);
}

TEST(MachineFile, AStillFilmOnARotatingDiscIsWarnedOf) {
  const auto warnings = [](const std::string& text) {
    testing::internal::CaptureStderr();
    mesh::parse_machine(text, "machine.toml");
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(warnings(machine_text()).find("rotating_disc"), std::string::npos) << "the disc's film has a state";
  const std::string always = warnings(replaced(machine_text(), "fraction = 0.5\nstate = \"cutting_fluid.on\"\n", ""));
  EXPECT_NE(always.find("'table.top' has the film 'disc' as well"), std::string::npos) << always;
  EXPECT_NE(always.find("machine.toml:"), std::string::npos) << always;
}

TEST(MachineFile, StandstillAloneIsAPower) {
  const std::string source =
      "[[source]]\nid = \"cabinet\"\nstandstill_W = 25\nplace = [ { surface = \"table.top\" } ]\n";
  EXPECT_DOUBLE_EQ(mesh::parse_machine(machine_text() + source, "machine.toml").sources.back().standstill, 25.0);
  const std::string message = samples::message_of(
      [&] { mesh::parse_machine(machine_text() + replaced(source, "standstill_W = 25\n", ""), "machine.toml"); });
  EXPECT_NE(message.find("or standstill_W"), std::string::npos) << message;
}

TEST(MachineFile, FluidsAndWhatFollowsTheTemperature) {
  const mesh::Machine m = mesh::parse_machine(machine_text() + R"(
[[door]]
id = "front"
[[volume]]
id = "tank"
content_l = {value = 200, std_percent = 5}
[[volume.exchange]]
with = "air"
conductance_W_K = 8
state = "door.front.open"
[[volume]]
id = "cabinet"
heat_capacity_J_K = 2e4
[[volume.exchange]]
with = "tank"
conductance_W_K = 1
[[film]]
id = "wetted"
surfaces = ["bed.rails"]
ambient = "tank"
kind = "table"
input = "axis.X.feed_mm_min"
at = [0, 30000]
film_coefficient_W_m2K = [8, 25]
[[film]]
id = "hot"
surfaces = ["bed.rails"]
kind = "free_convection"
of_temperature = true
emissivity = 0.9
radiation = "exact"
surroundings = "foundation"
[[coolant]]
id = "second"
flow_kg_s = 0.1
guide_warmed_by = "cabinet"
guide_warmed_share = 0.1
controls = "return"
control = "pi"
gain = 3
after_run_s = 600
[[coolant.segment]]
id = "one"
surface = "table.top"
film_coefficient_W_m2K = 800
cells = 4
path_mm = [[0, 0, 0], [100, 0, 0]]
[[coolant.segment]]
id = "two"
surface = "table.top"
film_coefficient_W_m2K = 800
after = ["chiller"]
share = 0.4
[[sensor]]
id = "back"
return_of = "second"
[[sensor]]
id = "in_tank"
volume = "tank"
)",
                                              "machine.toml");
  EXPECT_DOUBLE_EQ(m.volumes[0].capacity.value, 0.2 * 1000.0 * 4180.0);
  EXPECT_DOUBLE_EQ(m.volumes[0].capacity.std_percent, 5.0);
  EXPECT_EQ(m.volumes[0].exchanges[0].state, "door.front.open");
  EXPECT_EQ(m.doors, std::vector<std::string>{"front"});
  const mesh::FilmSpec &wet = m.films[m.films.size() - 2], &hot = m.films.back();
  EXPECT_EQ(wet.kind, mesh::FilmKind::table);
  EXPECT_EQ(wet.table.power, (std::vector<double>{8, 25}));
  EXPECT_TRUE(hot.of_temperature && hot.exact_radiation);
  EXPECT_EQ(hot.surroundings, "foundation");
  const mesh::CoolantSpec& second = m.coolants.back();
  EXPECT_EQ(second.control, mesh::ChillerControl::pi);
  EXPECT_TRUE(second.controls_return);
  EXPECT_DOUBLE_EQ(second.gain, 3.0);
  EXPECT_EQ(second.segments[0].cells, 4);
  EXPECT_DOUBLE_EQ(second.segments[0].path[1].x(), 0.1);
  EXPECT_TRUE(second.segments[1].after.empty());
  EXPECT_DOUBLE_EQ(mesh::flow_network(second, "").share[0], 0.6);
  EXPECT_EQ(m.sensors.back().volume, "tank");
  EXPECT_EQ(m.sensors[m.sensors.size() - 2].return_of, "second");
}

using Mistake = std::tuple<const char*, const char*, std::vector<const char*>>;
class MachineMistake : public testing::TestWithParam<Mistake> {};

TEST_P(MachineMistake, IsNamed) {
  const auto& [old, with, words] = GetParam();
  const std::string text = replaced(machine_text(), old, with);
  const std::string message = samples::message_of([&] { mesh::parse_machine(text, "machine.toml"); });
  ASSERT_FALSE(message.empty()) << "accepted: " << with;
  EXPECT_NE(message.find("machine.toml"), std::string::npos) << message;
  for (const char* word : words) EXPECT_NE(message.find(word), std::string::npos) << message << "\n  lacks: " << word;
}

INSTANTIATE_TEST_SUITE_P(
    All, MachineMistake,
    testing::Values(
        Mistake{"guide_sensor = \"T1\"\n", "guide_sensor = \"T1\"\nband_K = 1\n", {"band_K", "two_point"}},
        Mistake{"guide_sensor = \"T1\"\n",
                "guide_sensor = \"T1\"\ncontrol = \"two_point\"\nband_K = 3\npull_down_K = 1\n",
                {"pull_down_K"}},
        Mistake{"schema = 1", "schema = 2", {"schema"}}, Mistake{"[tcp]", "[tpc]", {"tcp"}},
        Mistake{"density_kg_m3 = 7200", "density_g_cm3 = 7.2", {"density"}},
        Mistake{"young_GPa = 120", "young_GPa = 120e9", {"young_GPa", "2000"}},
        Mistake{"poisson = 0.26", "poisson = 0.5", {"poisson"}},
        Mistake{"poisson = 0.26", "poisson = 0.26\ncolour = 1", {"colour"}},
        Mistake{"id = \"slide\"\nmaterial = \"iron\"", "id = \"slide\"\nmaterial = \"irn\"", {"irn", "iron"}},
        Mistake{"id = \"slide\"", "id = \"bed\"", {"bed"}},
        Mistake{"cad = \"bed.stl\"", "cad = \"bed.sat\"", {"bed.sat", ".step"}},
        Mistake{"unit = \"m\"", "unit = \"ft\"", {"ft", "mm"}},
        Mistake{"element_size_mm = 90", "element_size_mm = 0", {"element_size_mm"}},
        Mistake{"parent = \"slide\"", "parent = \"sldie\"", {"sldie", "slide"}},
        Mistake{"cad = \"bed.stl\"", "cad = \"bed.stl\"\nparent = \"table\"", {"circular chain"}},
        Mistake{"parent = \"swivel\"\naxis = \"C\"", "parent = \"swivel\"\naxis = \"B\"", {"'B'", "twice"}},
        Mistake{"direction = [2, 0, 0]", "direction = [0, 0, 0]", {"direction", "length 0"}},
        Mistake{"travel_mm = [-400, 400]", "travel_mm = [400, -400]", {"travel_mm", "low < high"}},
        Mistake{"travel_mm = [-400, 400]", "travel_deg = [-400, 400]", {"travel_mm"}},
        Mistake{"endless = true", "endless = true\ntravel_deg = [0, 1]", {"endless"}},
        Mistake{"except = [\"bed.rails\", \"bed.feet\"]", "except = [\"table.top\"]", {"table.top", "bed"}},
        Mistake{"rule = { plane_point_mm = [0, 0, 50], plane_normal = [0, 0, 1] }",
                "rule = { plane_point_mm = [0, 0, 50] }",
                {"plane_normal"}},
        Mistake{"rule = { group = \"carriages\" }", "rule = { }", {"without a condition"}},
        Mistake{"rule = { group = \"carriages\" }",
                "rule = { group = \"carriages\", normla = [1, 0, 0] }",
                {"normla", "normal"}},
        Mistake{"rule = { group = \"carriages\" }",
                "rule = { group = \"g\" }\nexcept = [\"slide.carriages\"]",
                {"excludes itself"}},
        Mistake{"master = \"bed.rails\"", "master = \"slide.carriages\"", {"same body"}},
        Mistake{"master = \"bed.rails\"\naxis = \"X\"", "master = \"bed.rails\"", {"no axis", "X"}},
        Mistake{"master = \"bed.rails\"\naxis = \"X\"", "master = \"bed.rails\"\naxis = \"B\"", {"'B'", "X"}},
        Mistake{"master = \"bed.rails\"\naxis = \"X\"", "master = \"table.top\"\naxis = \"X\"", {"B, C"}},
        Mistake{"ambient = \"foundation\"", "master = \"bed.rails\"", {"mount"}},
        Mistake{"conductance_W_m2K = 100", "conductance_W_m2K = 100\nstiffness_normal_N_mm3 = 5", {"elastic"}},
        Mistake{"divide = [2, 1, 1]", "divide = [2, 0, 1]", {"divide"}},
        Mistake{"sectors = 8", "sectors = 8\ndivide = [1, 1, 1]", {"divide"}},
        Mistake{"conductance_W_m2K = 50", "conductance_W_m2K = -50", {"conductance", "-50"}},
        Mistake{"conductance_W_m2K = 50", "conductance_W_m2K = 1e300", {"conductance", "1e+300"}},
        Mistake{"carrier = \"bed\"", "carrier = \"table\"", {"'X'", "B, C"}},
        Mistake{"follows = \"air\"", "follows = \"foundation\"", {"follows itself"}},
        Mistake{"kind = \"free_convection\"\nfactor",
                "kind = \"free_convection\"\nfilm_coefficient_W_m2K = 3\nfactor",
                {"film_coefficient_W_m2K", "constant"}},
        Mistake{"axis = \"C\"\nradius_mm", "axis = \"X\"\nradius_mm", {"rotary axis", "spindle"}},
        Mistake{
            "state = \"cutting_fluid.on\"", "state = \"cutting_fluid.off\"", {"cutting_fluid.off", "cutting_fluid.on"}},
        Mistake{"id = \"wet\"\nsurfaces = [\"table.top\"]",
                "id = \"wet\"\nsurfaces = [\"table.topp\"]",
                {"table.topp", "table.top"}},
        Mistake{"guide_sensor = \"T1\"", "guide_sensor = \"T9\"", {"T9", "T1"}},
        Mistake{"input = \"spindle.speed_rpm\"", "input = \"spindle.rpm\"", {"spindle.rpm", "spindle.speed_rpm"}},
        Mistake{"guide_sensor = \"T1\"\n",
                "guide_sensor = \"T1\"\nguide_warmed_by = \"T1\"\nguide_warmed_share = 0.1\n",
                {"guide_warmed_by", "no volume yet"}},
        Mistake{"guide_sensor = \"T1\"\n", "guide_sensor = \"T1\"\ncontrols = \"return\"\n", {"controls", "two_point"}},
        Mistake{"guide_sensor = \"T1\"\n", "guide_sensor = \"T1\"\ngain = 2\n", {"gain", "pi"}},
        Mistake{"volume_l = 0.7\n", "volume_l = 0.7\nshare = 0.5\n", {"0.5", "the sum of the inflows"}},
        Mistake{"volume_l = 0.7\n", "volume_l = 0.7\npath_mm = [[0, 0, 0], [0, 0, 0]]\n", {"path_mm", "no length"}},
        Mistake{"volume_l = 0.7\n",
                "volume_l = 0.7\n[[volume]]\nid = \"air\"\nheat_capacity_J_K = 5\n",
                {"air", "of its own"}},
        Mistake{"volume_l = 0.7\n",
                "volume_l = 0.7\n[[volume]]\nid = \"a\"\nheat_capacity_J_K = 5\n[[volume.exchange]]\nwith = "
                "\"a\"\nconductance_W_K = 1\n",
                {"itself"}},
        Mistake{"at = [0, 6000, 12000]", "at = [0, 6000]", {"3 numbers for 2"}},
        Mistake{"at = [0, 6000, 12000]", "at = [0, 12000, 6000]", {"rising"}},
        Mistake{"share = 0.4", "share = 0.5", {"1.1", "at most 1"}},
        Mistake{"{ surface = \"table.top\", share = 0.4 }", "{ share = 0.4 }", {"none of surface"}},
        Mistake{"tool_surface = \"bed.rails\"", "tool_surface = \"table.top\"", {"tool_surface", "table.top"}},
        Mistake{"X_mm = [-400, 0, 400]", "X_mm = [-500, 0, 400]", {"X_mm", "-400"}},
        Mistake{"X_mm = [-400, 0, 400]", "Q_mm = [-400, 0, 400]", {"Q_mm"}},
        Mistake{"[workspace]", "[workspaces]", {"workspaces", "workspace"}}));

}  // namespace
