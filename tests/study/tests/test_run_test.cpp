// SPDX-License-Identifier: GPL-3.0-or-later
// Readings along a test against runs of the reduced model on the test's own load program.
#include "study/tests/test_run.h"

#include <gtest/gtest.h>

#include <limits>

#include "compensation/measurement/virtual_measurement.h"
#include "core/error.h"
#include "diagnosis/causes/hypothesis.h"
#include "reduction/model/reduced_simulation.h"
#include "study/tests/stated_parameters.h"
#include "study/tests/test_choice.h"
#include "study/tests/test_estimate.h"
#include "tests/machines/rods.h"

namespace thermotwin::study {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const reduction::ReducedModel& test_rods() {
  static const reduction::ReducedModel model = lumped::model(lumped::machine(), 5);
  return model;
}

BlockOptions two_readings() {
  BlockOptions options;
  options.block_s = 3600;
  options.probe_every_s = 1800;
  options.probe_pose = mesh::home_pose(test_rods().machine);
  return options;
}

TestSetup run_setup() {
  TestSetup of;
  of.parameters = stated_parameters(test_rods().machine, false);
  for (const UncertainParameter& one : uncertain_parameters(test_rods()))
    if (one.parameter.kind == diagnosis::Kind::ambient_offset) of.surroundings.push_back(one);
  of.sensors = {0, 1, 2, 3, 4, 5};
  of.probes = {mesh::home_pose(test_rods().machine)};
  of.start_C = 20.0;
  of.step_s = 60;
  return of;
}

VectorXd ones() { return VectorXd::Ones(std::ssize(run_setup().parameters)); }

/// A test of every second standard block, and its load program.
struct Ran {
  std::vector<TestBlock> blocks = standard_blocks(test_rods().machine, two_readings());
  TestOrder order;
  std::string text;
  solver::LoadProgram load;
  Ran()
      : order(every_second()),
        text(test_text(test_rods().machine, order, "every second block", 20.0, 600.0)),
        load(solver::LoadProgram::parse(text, "test.toml", test_rods().machine)) {}

private:
  TestOrder every_second() const {
    TestOrder some;
    for (std::size_t i = 0; i < blocks.size(); i += 2) some.push_back(&blocks[i]);
    return some;
  }
};

solver::LoadResult run_of(const mesh::Machine& machine, const solver::LoadProgram& load) {
  reduction::ReducedRun how;
  how.tell = false;
  return reduction::simulate_reduced(test_rods(), machine, load, run_setup().probes, how);
}

std::vector<TestReadings> readings_of(const TestSetup& of, const TestOrder& order) {
  TestRun run(test_rods(), ones(), of);
  std::vector<TestReadings> all;
  for (const TestBlock* block : order) run.run(*block, [&](const TestReadings& one) { all.push_back(one); });
  return all;
}

Index row_at(const core::Table& table, double time) {
  Index row = 0;
  while (row + 1 < table.rows() && table.values(row, 0) < time - 1e-6) ++row;
  EXPECT_NEAR(table.values(row, 0), time, 1e-6);
  return row;
}

TEST(TestRun, ReadsWhatItsLoadProgramMakes) {
  const Ran test;
  const solver::LoadResult result = run_of(test_rods().machine, test.load);
  int probed = 0, read = 0;
  for (const TestReadings& one : readings_of(run_setup(), test.order)) {
    const Index row = row_at(one.probe ? result.tcp : result.sensors, one.time);
    for (Index i = 0; i < one.predicted.size(); ++i) {
      const std::string name =
          one.probe ? std::vector<std::string>{"dx_um", "dy_um", "dz_um"}[i] : test_rods().machine.sensors[i].id + "_C";
      const VectorXd column = (one.probe ? result.tcp : result.sensors).column(name);
      const double truth = one.probe ? column[row] - column[0] : column[row] - test_rods().machine.reference_C;
      EXPECT_NEAR(one.predicted[i], truth, 1e-6 * column.cwiseAbs().maxCoeff()) << name << " at " << one.time;
    }
    ++(one.probe ? probed : read);
  }
  EXPECT_EQ(probed, 2 * std::ssize(test.order));
  EXPECT_EQ(read, 6 * std::ssize(test.order));
}

TEST(TestRun, RowsAreChangesByOneDeviation) {
  const Ran test;
  const TestSetup of = run_setup();
  const std::vector<TestReadings> readings = readings_of(of, test.order);
  std::vector<UncertainParameter> moved = of.parameters;
  moved.insert(moved.end(), of.surroundings.begin(), of.surroundings.end());
  for (std::size_t p = 0; p < moved.size(); ++p) {
    const diagnosis::Parameter& one = moved[p].parameter;
    const double small = 0.05 * moved[p].std;
    const solver::LoadResult more =
        run_of(diagnosis::with_parameter(test_rods().machine, one, one.nominal + small), test.load);
    const solver::LoadResult less =
        run_of(diagnosis::with_parameter(test_rods().machine, one, one.nominal - small), test.load);
    double largest = 0.0, off = 0.0;
    for (const TestReadings& reading : readings) {
      const core::Table &above = reading.probe ? more.tcp : more.sensors,
                        &below = reading.probe ? less.tcp : less.sensors;
      const Index row = row_at(above, reading.time);
      for (Index i = 0; i < reading.predicted.size(); ++i) {
        const std::string name = reading.probe ? std::vector<std::string>{"dx_um", "dy_um", "dz_um"}[i]
                                               : test_rods().machine.sensors[i].id + "_C";
        const VectorXd change = (above.column(name) - below.column(name)) / 0.1;
        const double truth = reading.probe ? change[row] - change[0] : change[row];
        largest = std::max(largest, std::abs(truth));
        off = std::max(off, std::abs(reading.rows(i, static_cast<Index>(p)) - truth));
      }
    }
    EXPECT_LT(off, 0.02 * largest + 1e-6) << key_of(moved[p]);
  }
}

TEST(TestRun, InformationIsTheSumOfItsReadingsAndTheStateCanBeTakenUp) {
  const Ran test;
  TestRun run(test_rods(), ones(), run_setup());
  MatrixXd sum = MatrixXd::Zero(run_setup().unknowns(), run_setup().unknowns());
  const auto start = run.keep();
  const MatrixXd first = run.run(*test.order[1], [&](const TestReadings& one) {
    for (Index i = 0; i < one.predicted.size(); ++i)
      sum += one.rows.row(i).transpose() * one.rows.row(i) / (one.std[i] * one.std[i]);
  });
  EXPECT_LT((first - sum).norm(), 1e-9 * sum.norm());
  const MatrixXd later = run.run(*test.order[1]);
  EXPECT_GT((later - first).norm(), 1e-3 * first.norm());  // the machine is warm
  run.take_up(*start);
  EXPECT_EQ(run.run(*test.order[1]), first);
}

TEST(TestRun, PredictionIsWhatDeviationsChangeOfTheTcp) {
  const solver::LoadProgram load = solver::LoadProgram::parse(
      "schema = 1\noutput_s = 1200\ntime_step_s = 60\n[[phase]]\nduration_h = 2\nspindle_rpm = 9000\n", "load.toml",
      test_rods().machine);
  TestSetup of = run_setup();
  of.parameters.resize(2);
  const std::vector<mesh::Pose> poses = mesh::workspace_poses(test_rods().machine);
  const MatrixXd found = TestRun(test_rods(), VectorXd::Ones(2), of).prediction({load}, poses);
  std::vector<VectorXd> changes;
  for (const UncertainParameter& one : of.parameters) {
    const auto tcp = [&](double by) {
      reduction::ReducedRun how;
      how.tell = false;
      const core::Table table =
          reduction::simulate_reduced(test_rods(),
                                      diagnosis::with_parameter(test_rods().machine, one.parameter, 1.0 + by * one.std),
                                      load, poses, how)
              .tcp;
      VectorXd all(3 * table.rows());
      all << table.column("dx_um"), table.column("dy_um"), table.column("dz_um");
      return all;
    };
    changes.push_back((tcp(0.05) - tcp(-0.05)) / 0.1);
  }
  const double rows = 6.0 * static_cast<double>(poses.size());  // times after the start, poses
  for (Index i = 0; i < 2; ++i)
    for (Index j = 0; j < 2; ++j) EXPECT_NEAR(found(i, j), changes[i].dot(changes[j]) / rows, 0.02 * found.trace());
}

TEST(TestEstimate, FindsTheValuesOfAMachineThatRanTheTest) {
  const Ran test;
  const TestSetup of = run_setup();
  VectorXd truth = ones();
  mesh::Machine machine = test_rods().machine;
  for (Index p = 0; p < truth.size(); ++p) {
    truth[p] += (p % 2 == 0 ? 1.5 : -1.2) * of.parameters[p].std;
    machine = diagnosis::with_parameter(machine, of.parameters[p].parameter, truth[p]);
  }
  compensation::VirtualOptions quiet;
  quiet.sensor_noise_K = 0.003;
  quiet.probe_noise_um = 0.01;
  const compensation::Measurement measured =
      compensation::measure_run(run_of(machine, test.load), machine, of.probes, quiet);
  BlockOptions as_it_is;
  as_it_is.probe_every_s = 0.0;
  TestBlock block = program_block(test_rods().machine, test.load, as_it_is, std::numeric_limits<double>::infinity());
  for (TestPhase& phase : block.phases) phase.probes = phase.name == probe_phase;
  TestSetup sharp = of;
  sharp.bias_K = 0.001;
  sharp.start_std_K = 0.001;
  sharp.probe_std_um = 0.02;
  for (UncertainParameter& one : sharp.surroundings) one.std = 0.001;
  reduction::ReducedModel model = test_rods();
  for (mesh::SensorSpec& sensor : model.machine.sensors) sensor.uncertainty = 0.003;
  const VectorXd found = estimate(model, sharp, block, measured);
  TestRun run(model, ones(), sharp);
  const TestChoice choice(run, test.blocks, MatrixXd::Identity(truth.size(), truth.size()));
  const MatrixXd left = choice.evaluate(test.order).covariance;
  int told = 0;
  for (Index p = 0; p < truth.size(); ++p) {
    const double std = of.parameters[p].std, off = std::abs(truth[p] - found[p]) / std, stated = std::sqrt(left(p, p));
    EXPECT_LT(off, 4.0 * stated + 0.1) << key_of(of.parameters[p]);
    if (stated > 0.2) continue;
    ++told;
    EXPECT_LT(off, 0.6) << key_of(of.parameters[p]);  // it was off by 1.2 or 1.5
  }
  EXPECT_GE(told, 3);
}

TEST(TestSetup, NeedsSomethingToReadAndToTell) {
  TestSetup blind = run_setup();
  blind.sensors.clear();
  blind.probes.clear();
  EXPECT_THROW(TestRun(test_rods(), ones(), blind), core::InputError);
  TestSetup certain = run_setup();
  certain.parameters.clear();
  EXPECT_THROW(TestRun(test_rods(), VectorXd(), certain), core::InputError);
}

}  // namespace
}  // namespace thermotwin::study
