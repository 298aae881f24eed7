// SPDX-License-Identifier: GPL-3.0-or-later
// A gradient of the air and a cabinet whose heat machine.toml states as standstill_W alone, hidden in records.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "diagnosis/causes/offered_causes.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/record/observations.h"
#include "mesh/machine/file.h"
#include "solver/operation/operating_model.h"
#include "tests/diagnosis/diagnosed_rods.h"

namespace {

using namespace thermotwin;
using diagnosis::Diagnosis;
using diagnosis::Kind;
using lumped::listed;

std::string with_gradient() {
  std::string text = lumped::machine_text();
  const std::string air = "id = \"air\"\n";
  return text.replace(text.find(air), air.size(), air + "gradient_K_m = {value = 0.5, std_percent = 40}\n");
}

std::string with_cabinet() {
  return lumped::machine_text() +
         "[[source]]\nid = \"cabinet\"\nscale = {value = 1, std_percent = 6}\nstandstill_W = 80\n"
         "place = [ { surface = \"base.skin\" } ]\n";
}

Diagnosis diagnosed(const std::string& text, const diagnosis::Parameter& hidden, double value) {
  const mesh::Machine machine = mesh::parse_machine(text, "rods/machine.toml");
  lumped::MeasureOptions measured{.seed = 21};
  measured.text = text;
  diagnosis::DiagnoseOptions how;
  how.temperature_error_percent = 3;
  return diagnosis::diagnose(lumped::model(machine, 9), lumped::measure({{hidden, value}}, measured), how);
}

TEST(Diagnose, AGradientOfTheAirIsNamed) {
  const diagnosis::Parameter gradient = diagnosis::make_parameter(Kind::ambient_gradient, "air");
  const Diagnosis d = diagnosed(with_gradient(), gradient, 2.0);
  ASSERT_EQ(d.verdict, diagnosis::Verdict::explained) << listed(d);
  ASSERT_EQ(name_of(d.causes.front().parameter), "ambient_gradient of air") << listed(d);
  EXPECT_NEAR(d.causes.front().value, 2.0, 0.3);
  EXPECT_EQ(diagnosed(with_gradient(), gradient, 0.2).verdict, diagnosis::Verdict::no_discrepancy)
      << "one stated deviation";
}

TEST(Diagnose, AGradientThatIsMeasuredIsThatOfTheRecord) {
  const mesh::Machine machine = mesh::parse_machine(with_gradient(), "rods/machine.toml");
  const solver::Channels channels(machine);
  compensation::Measurement m = lumped::measure({}, {.hours = 12});
  const int column = channels.index("air.gradient_K_m");
  EXPECT_TRUE(diagnosis::observe(m, machine, channels, {}).rows.col(column).array().isNaN().all());
  compensation::MeasuredChannel measured;
  measured.id = measured.input = "air.gradient_K_m";
  measured.kind = compensation::ChannelKind::state;
  measured.unit = "K/m";
  measured.column = m.data.values.cols();
  m.data.values.conservativeResize(Eigen::NoChange, measured.column + 1);
  m.data.values.col(measured.column).setConstant(1.5);
  m.data.columns.push_back(measured.id);
  m.channels.push_back(measured);
  EXPECT_TRUE((diagnosis::observe(m, machine, channels, {}).rows.col(column).array() == 1.5).all());
}

TEST(Diagnose, ACabinetThatStandstillAloneStatesIsNoProcess) {
  const mesh::Machine machine = mesh::parse_machine(with_cabinet(), "rods/machine.toml");
  const compensation::Measurement m = lumped::measure({}, {.hours = 0.1});
  EXPECT_TRUE(diagnosis::unrecorded_sources(machine, m).empty());
  std::vector<diagnosis::Parameter> offered = diagnosis::candidate_parameters(machine, m);
  std::erase_if(offered, [](const diagnosis::Parameter& p) { return p.where != "cabinet"; });
  ASSERT_EQ(offered.size(), 1U);
  EXPECT_EQ(offered.front().kind, Kind::standstill_power);
  EXPECT_DOUBLE_EQ(offered.front().nominal_std, 4.8) << "6 % of 80 W";
  EXPECT_DOUBLE_EQ(offered.front().low, -80.0);
}

TEST(Diagnose, MoreHeatOfACabinetThanStandstillStatesIsNamed) {
  const Diagnosis d = diagnosed(with_cabinet(), diagnosis::make_parameter(Kind::standstill_power, "cabinet"), 64.0);
  const auto unrecorded = [](const std::string& warning) { return warning.find("power_W") != std::string::npos; };
  EXPECT_TRUE(std::none_of(d.warnings.begin(), d.warnings.end(), unrecorded)) << d.warnings.front();
  ASSERT_EQ(d.verdict, diagnosis::Verdict::explained) << listed(d);
  ASSERT_TRUE(std::any_of(d.causes.begin(), d.causes.end(), [](const auto& cause) {
    return cause.parameter.kind == Kind::standstill_power && cause.parameter.where == "cabinet";
  })) << listed(d);
}

// Walls of all heights shine on a surface: their temperature is one, that of the surroundings at height_mm.
TEST(Surroundings, AGradientActsOnConvectionAlone) {
  const mesh::Machine machine = mesh::parse_machine(with_gradient(), "rods/machine.toml");
  const reduction::ReducedModel model = lumped::model(machine, 9);
  const solver::Layout& layout = model.system.layout;
  const solver::OperatingModel operating(machine, layout);
  const Eigen::VectorXd row = operating.channels().defaults();
  const solver::Coefficients c = operating.coefficients(row, Eigen::VectorXd::Zero(1));
  for (Eigen::Index k = 0; k < std::ssize(layout.inputs); ++k) {
    if (layout.inputs[k].kind != solver::InputKind::film_gradient) continue;
    const int film = layout.inputs[k].item;
    const double radiation = machine.films[film].emissivity.value * 4.0 * 5.670374419e-8 * std::pow(293.15, 3);
    EXPECT_NEAR(c.q[k], 0.5 * (c.p[layout.inputs[k].term] - radiation), 1e-9) << machine.films[film].id;
  }
}

}  // namespace
