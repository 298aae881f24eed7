// SPDX-License-Identifier: GPL-3.0-or-later
// Losses, contact pressures, screws and feedback in machine.toml.
#include <gtest/gtest.h>

#include <numbers>

#include "mesh/machine/file.h"
#include "mesh/machine/machine.h"
#include "tests/mesh/samples.h"

using namespace thermotwin;
using samples::machine_text;
using samples::message_of;
using samples::replaced;

namespace {

const std::string old_law = "{ input = \"axis.X.feed_mm_min\", at = [0, 1], power_W = [0, 2] }";

mesh::Machine parsed(const std::string& text) { return mesh::parse_machine(text, "/there/machine.toml"); }
std::string with_law(const std::string& law) { return replaced(machine_text(), old_law, law); }
template <class Law>
Law law_of(const std::string& law) {
  return std::get<Law>(parsed(with_law(law)).sources[0].losses.at(0).law);
}
std::string refusal(const std::string& law) {
  return message_of([&] { parsed(with_law(law)); });
}

TEST(MachineLaws, UnitsBecomeSi) {
  const auto bearing = law_of<mesh::BearingLoss>(
      R"({ kind = "bearing", motion = "spindle", f0 = 2, f1 = 0.001, mean_diameter_mm = 85, viscosity_mm2_s = 22, load_N = 500, count = 4 })");
  EXPECT_DOUBLE_EQ(bearing.mean_diameter, 0.085);
  EXPECT_DOUBLE_EQ(bearing.viscosity, 22e-6);
  EXPECT_DOUBLE_EQ(bearing.count, 4.0);
  const std::string screw_bearing =
      R"({ kind = "bearing", motion = "X", pitch_mm = 20, ratio = 2, f0 = 2, mean_diameter_mm = 40, viscosity_mm2_s = 30 })";
  EXPECT_DOUBLE_EQ(parsed(with_law(screw_bearing)).sources[0].losses[0].turns, 100.0);  // a metre
  const auto guide =
      law_of<mesh::GuideLoss>(R"({ kind = "guide", motion = "X", coulomb_N = 120, viscous_N_s_m = 40 })");
  EXPECT_DOUBLE_EQ(guide.viscous, 40.0);
  const auto screw = law_of<mesh::ScrewLoss>(
      R"({ kind = "ball_screw", motion = "X", pitch_mm = 20, mean_diameter_mm = 40, preload_N = 3000, load_N = 900, efficiency = 0.92 })");
  EXPECT_DOUBLE_EQ(screw.lead, 0.02);
  EXPECT_DOUBLE_EQ(screw.efficiency, 0.92);
  const auto motor = law_of<mesh::MotorLoss>(
      R"({ kind = "motor", motion = "C", ratio = 3, at_rpm = [0, 3000], torque_Nm = [4, 12], torque_constant_Nm_A = 1.5, resistance_ohm = 0.4, winding_C = 90, hysteresis_W = 30, eddy_W = 20, nominal_rpm = 3000 })");
  EXPECT_DOUBLE_EQ(motor.torque(25.0), 8.0);
  EXPECT_DOUBLE_EQ(motor.nominal_speed, 50.0);
  const auto held = law_of<mesh::HoldingLoss>(
      R"({ kind = "holding", motion = "B", balanced_at_deg = 90, full_power_W = 3500, linear_share = 1 })");
  EXPECT_DOUBLE_EQ(held.balanced, std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(held.full_power, 3500.0);
  EXPECT_EQ(held.friction, 0.0);
  const auto rubbing =
      law_of<mesh::HoldingLoss>(R"({ kind = "holding", motion = "B", full_power_W = 3500, friction_share = 0.14 })");
  EXPECT_DOUBLE_EQ(rubbing.friction, 0.14);
}

TEST(MachineLaws, HoldingPowerFromTheMotorsData) {
  // 400 kg at 100 mm: 392.27 N m; 12 N m/A: 32.69 A; 3 * 0.5 ohm * 270 / 255 * I^2 = 1697.2 W
  const auto held = law_of<mesh::HoldingLoss>(
      R"({ kind = "holding", motion = "B", mass_kg = 400, lever_mm = 100, torque_constant_Nm_A = 12, resistance_ohm = 0.5, winding_C = 35 })");
  EXPECT_NEAR(held.full_power, 1697.2, 0.1);
  EXPECT_EQ(held.linear_share, 0.0);
}

TEST(MachineLaws, KindsAndTablesStandTogether) {
  const mesh::Machine m = parsed(with_law(R"({ kind = "guide", motion = "X", coulomb_N = 120 })"));
  EXPECT_EQ(m.sources[0].laws.size(), 1u);
  EXPECT_EQ(m.sources[0].losses.size(), 1u);
  EXPECT_FALSE(m.has_clamp("B"));
  const mesh::Machine held = parsed(with_law(R"({ kind = "holding", motion = "B", full_power_W = 3500 })"));
  EXPECT_TRUE(held.has_clamp("B"));
  EXPECT_FALSE(held.has_direction("B"));
  EXPECT_TRUE(parsed(with_law(R"({ kind = "holding", motion = "B", full_power_W = 3500, friction_share = 0.1 })"))
                  .has_direction("B"));
}

TEST(MachineLaws, WrongLawsAreRefused) {
  for (
      const auto& [law, part] : {
          std::pair{R"({ kind = "guide", motion = "B", coulomb_N = 1 })", "linear axis: X"},
          {R"({ kind = "guide", motion = "X" })", "without friction"},
          {R"({ kind = "holding", motion = "X", full_power_W = 1 })", "rotary axis: B, C"},
          {R"({ kind = "holding", motion = "C", full_power_W = 1 })", "vertical axis 'C'"},
          {R"({ kind = "holding", motion = "B", full_power_W = 1, mass_kg = 3 })", "mass_kg"},
          {R"({ kind = "holding", motion = "B", full_power_W = 1, friction_share = 1.5 })", "friction_share"},
          {R"({ kind = "bearing", motion = "Q", f0 = 2, mean_diameter_mm = 40, viscosity_mm2_s = 30 })",
           "one of: spindle, X, B, C"},
          {R"({ kind = "bearing", motion = "X", f0 = 2, mean_diameter_mm = 40, viscosity_mm2_s = 30 })", "pitch_mm"},
          {R"({ kind = "bearing", motion = "spindle", pitch_mm = 3, f0 = 2, mean_diameter_mm = 40, viscosity_mm2_s = 30 })",
           "pitch_mm"},
          {R"({ kind = "motor", motion = "spindle", torque_Nm = 4, torque_constant_Nm_A = 0, resistance_ohm = 1 })",
           "torque_constant_Nm_A"},
          {R"({ kind = "motor", motion = "spindle", at_rpm = [0, 2], torque_Nm = [1], torque_constant_Nm_A = 1, resistance_ohm = 1 })",
           "torque_Nm"},
          {R"({ kind = "motor", motion = "spindle", eddy_W = 3 })", "nominal_rpm"},
          {R"({ kind = "motor", motion = "spindle" })", "without losses"},
          {R"({ kind = "ball_screw", motion = "X", pitch_mm = 20, mean_diameter_mm = 40, efficiency = 1.2 })",
           "efficiency"},
          {R"({ kind = "ball_screw", motion = "X", pitch_mm = 20, mean_diameter_mm = 40, preload_kN = 3 })",
           "preload_N"},
          {R"({ kind = "gear", motion = "X" })", "ball_screw"},
      })
    EXPECT_NE(refusal(law).find(part), std::string::npos) << law << "\n" << refusal(law);
}

TEST(MachineLaws, ContactPressure) {
  const std::string guide = "conductance_W_m2K = {value = 1500, std_percent = 30}";
  const auto joint = [&](const std::string& keys) {
    return parsed(replaced(machine_text(), guide, guide + "\n" + keys)).joints[0].law;
  };
  EXPECT_NEAR(joint("pressure_MPa = 2\nnominal_pressure_MPa = 1").factor(false), std::pow(2.0, 0.95), 1e-12);
  EXPECT_NEAR(joint("pressure_MPa = 2\nnominal_pressure_MPa = 1\nclamped_pressure_MPa = 4").factor(true),
              std::pow(4.0, 0.95), 1e-12);
  EXPECT_NEAR(joint("pressure_MPa = 3\npressure_at_MPa = [1, 4]\npressure_factor = [1, 2.5]").factor(false), 2.0,
              1e-12);
  for (const auto& [keys, part] :
       {std::pair{"nominal_pressure_MPa = 1", "pressure_MPa"},
        {"pressure_MPa = 2", "pressure_MPa: a pressure without a law; allowed: nominal_pressure_MPa"},
        {"pressure_MPa = 2\nnominal_pressure_MPa = 1\npressure_at_MPa = [1]\npressure_factor = [1]",
         "nominal_pressure_MPa"},
        {"pressure_MPa = 2\npressure_at_MPa = [4, 1]\npressure_factor = [1, 2]", "rising"},
        {"pressure_MPa = 9000\nnominal_pressure_MPa = 1e-4", "1e-4 to 1e4"}}) {
    const std::string said = message_of([&] { joint(keys); });
    EXPECT_NE(said.find(part), std::string::npos) << keys << "\n" << said;
  }
}

const std::string screw = R"([[screw]]
axis = "X"
body = "screw"
nut_body = "slide"
fixed_bearing_mm = [-500, 0, 10]
nut_mm = [0, 0, 10]
expansion_1_K = {value = 11.5e-6, std_percent = 3}
)";
std::string with_screw(const std::string& text) {
  return replaced(machine_text(), "[[ambient]]", text + "[[ambient]]");
}

TEST(MachineLaws, ScrewsAndFeedback) {
  const std::string x_axis = "rapid_mm_min = 60000";
  const mesh::Machine closed = parsed(with_screw(screw));
  EXPECT_EQ(closed.axes[0].feedback, "scale");
  EXPECT_EQ(closed.screws[0].carrier, "bed");
  EXPECT_DOUBLE_EQ(closed.screws[0].bearing.x(), -0.5);
  EXPECT_DOUBLE_EQ(closed.screws[0].expansion.std_percent, 3.0);
  EXPECT_FALSE(closed.screws[0].far_bearing);
  const mesh::Machine semi = parsed(replaced(with_screw(screw), x_axis, x_axis + "\nfeedback = \"screw\""));
  EXPECT_EQ(semi.axes[0].feedback, "screw");
  const mesh::Machine stretched =
      parsed(with_screw(screw + "bearings = \"fixed_fixed\"\nfar_bearing_mm = [500, 0, 10]\npretension_N = "
                                "8000\nbearing_stiffness_N_um = 900\n"));
  EXPECT_DOUBLE_EQ(stretched.screws[0].far_bearing->x(), 0.5);
  EXPECT_DOUBLE_EQ(stretched.screws[0].pretension, 8000.0);
  EXPECT_DOUBLE_EQ(stretched.screws[0].bearing_stiffness, 900e6);

  for (const auto& [text, part] : {
           std::pair{replaced(machine_text(), x_axis, x_axis + "\nfeedback = \"screw\""), "without a [[screw]]"},
           {with_screw(screw + "pretension_N = 8000\n"), "fixed_fixed"},
           {with_screw(screw + "bearings = \"fixed_fixed\"\nfar_bearing_mm = [500, 300, 10]\npretension_N = 1\n"),
            "along the axis"},
           {replaced(with_screw(screw), "nut_body = \"slide\"", "nut_body = \"swivel\""), "axis 'X'"},
           {replaced(with_screw(screw), "parent = \"bed\"\nelastic = false", "parent = \"bed\""), "elastic = false"},
           {replaced(machine_text(), "endless = true", "endless = true\nfeedback = \"screw\""), "linear axis"},
       }) {
    const std::string said = message_of([&] { parsed(text); });
    EXPECT_NE(said.find(part), std::string::npos) << part << "\n" << said;
  }
}

}  // namespace
