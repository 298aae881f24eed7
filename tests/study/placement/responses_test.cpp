// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/placement/responses.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "compensation/online/uncertain_quantities.h"
#include "diagnosis/causes/hypothesis.h"
#include "reduction/model/reduced_simulation.h"
#include "tests/machines/rods.h"

namespace thermotwin::study {
namespace {

const reduction::ReducedModel& rods() {
  static const reduction::ReducedModel model = lumped::model(lumped::machine(), 5);
  return model;
}

/// The machine's states at the outputs of a load, by their time in s.
std::map<double, Eigen::VectorXd> states(const mesh::Machine& machine, const solver::LoadProgram& load) {
  reduction::RunRecord record;
  reduction::ReducedRun how;
  how.tell = false;
  how.record = &record;
  reduction::simulate_reduced(rods(), machine, load, {mesh::home_pose(machine)}, how);
  std::map<double, Eigen::VectorXd> found;
  for (const auto& output : record.outputs) found[output.time] = output.state;
  return found;
}

TEST(UncertainParameters, AreThoseWithADeviationAndTheSurroundings) {
  const std::vector<UncertainParameter> found = uncertain_parameters(rods());
  const auto of = [&](diagnosis::Kind kind, const std::string& id) {
    const diagnosis::Parameter wanted = diagnosis::make_parameter(kind, id);
    return std::find_if(found.begin(), found.end(), [&](const UncertainParameter& one) {
      return one.parameter.kind == kind && one.parameter.where == wanted.where;
    });
  };
  const auto motor = of(diagnosis::Kind::source_power, "motor"), air = of(diagnosis::Kind::ambient_offset, "air");
  ASSERT_NE(motor, found.end());
  EXPECT_DOUBLE_EQ(motor->std, 0.05);
  EXPECT_EQ(motor->memory, compensation::machine_memory_s);
  EXPECT_EQ(of(diagnosis::Kind::source_power, "pump"), found.end());  // its power is certain
  EXPECT_NE(of(diagnosis::Kind::contact_conductance, "mounts"), found.end());
  ASSERT_NE(air, found.end());
  for (const compensation::UncertainQuantity& quantity : compensation::uncertain_quantities(rods())) {
    if (quantity.ambient != rods().machine.ambient_index("air")) continue;
    EXPECT_EQ(air->std, quantity.std);
    EXPECT_EQ(air->memory, quantity.memory);
  }
}

// A hall at 32 degC for long: the control is told of the air, but not of the foundation, whose default it takes.
TEST(Responses, AnAmbientThatNobodyTellsMayBeAsWarmAsTheMachine) {
  mesh::Machine machine = lumped::machine();
  mesh::AmbientSpec& foundation = machine.ambients[machine.ambient_index("foundation")];
  foundation.follows.clear();
  foundation.default_C.value = 20.0;
  const reduction::ReducedModel model = lumped::model(machine, 5);
  const solver::LoadProgram load = solver::LoadProgram::parse(
      "schema = 1\ninitial_C = 32\noutput_s = 600\ntime_step_s = 120\n[[phase]]\nduration_h = 1\nair_C = 32\n",
      "load.toml", machine);
  int untold = 0;
  for (const UncertainParameter& one : uncertain_parameters(model)) {
    const double share = responses(model, {one}, load, 3600.0).prior[0];
    if (one.parameter.kind == diagnosis::Kind::ambient_offset && one.parameter.where == "foundation") {
      ++untold;
      EXPECT_NEAR(one.std * share, std::hypot(one.std, 6.0), 1e-9);
    } else {
      EXPECT_EQ(share, 1.0) << one.parameter.where;
    }
  }
  EXPECT_EQ(untold, 1);
}

TEST(Responses, AreChangesOfTheStateByOneDeviation) {
  const solver::LoadProgram load = solver::LoadProgram::parse(
      "schema = 1\noutput_s = 600\ntime_step_s = 120\n[[phase]]\nduration_h = 1\nair_C = [20, 24]\nspindle_rpm = "
      "9000\n",
      "load.toml", rods().machine);
  UncertainParameter power{diagnosis::make_parameter(diagnosis::Kind::source_power, "motor"), 0.2, 1e6};
  UncertainParameter film{diagnosis::make_parameter(diagnosis::Kind::film_coefficient, "column.film"), 0.01, 1e6};
  const LoadResponses found = responses(rods(), {power, film}, load, 1200.0);
  ASSERT_EQ(found.times, (std::vector<double>{1200.0, 2400.0, 3600.0}));
  ASSERT_EQ(found.states.size(), 3U);
  const mesh::Machine &nominal = rods().machine, more = diagnosis::with_parameter(nominal, power.parameter, 1.2),
                      windy = diagnosis::with_parameter(nominal, film.parameter, 1.01);
  const auto before = states(nominal, load), hot = states(more, load), cool = states(windy, load);
  for (std::size_t t = 0; t < found.times.size(); ++t) {
    const Eigen::VectorXd of_power = hot.at(found.times[t]) - before.at(found.times[t]),
                          of_film = cool.at(found.times[t]) - before.at(found.times[t]);
    // The column's temperatures are linear in the power but for the free convection, and in a small change of a film.
    EXPECT_LT((found.states[t].col(0) - of_power).norm(), 0.02 * of_power.norm()) << t;
    EXPECT_LT((found.states[t].col(1) - of_film).norm(), 0.02 * of_film.norm()) << t;
    EXPECT_GT(of_power.norm(), 0.01) << t;
  }
}

}  // namespace
}  // namespace thermotwin::study
