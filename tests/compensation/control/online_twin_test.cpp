// SPDX-License-Identifier: GPL-3.0-or-later
// The core behind the interface of the compensator: probing, what it learns, and saved states.
#include "compensation/control/online_twin.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "compensation/measurement/virtual_measurement.h"
#include "core/error.h"
#include "core/file.h"
#include "core/missing.h"
#include "core/units.h"
#include "mesh/machine/kinematics.h"
#include "tests/compensation/control/twin_of_lumps.h"
#include "tests/compensation/scratch.h"
#include "tests/compensation/shift.h"

namespace thermotwin::compensation {
namespace {

using core::missing;
using core::units::um;
using Eigen::Vector3d;
using Eigen::VectorXd;

const reduction::ReducedModel& machine_model() {
  static const reduction::ReducedModel model = test::lumps_with_lines();
  return model;
}

ControlOptions fine() {
  ControlOptions options;
  options.tolerance = 1e-14;
  return options;
}

std::vector<mesh::Pose> poses_of(std::initializer_list<const char*> texts) {
  std::vector<mesh::Pose> poses;
  for (const char* text : texts) poses.push_back(mesh::parse_pose(machine_model().machine, text, "test"));
  return poses;
}

/// A machine that differs in its parameters and in the expansion of both sides.
test::Truth other_machine(std::uint64_t seed, double duration_s, const std::vector<mesh::Pose>& poses) {
  reduction::ReducedModel structure = machine_model();
  for (Eigen::MatrixXd& rows : structure.outputs.tool) rows *= 1.05;
  for (Eigen::MatrixXd& rows : structure.outputs.table_axis) rows *= 0.96;
  return test::run_truth(perturbed(machine_model().machine, seed, 2.0), structure, 60.0, 1, duration_s, poses);
}

VectorXd noisy(VectorXd reading, test::Uniform& noise) {
  for (double& value : reading) value += 0.03 * noise.normal();
  return reading;
}

/// Core and class on the same rows, a minute apart.
struct Both {
  explicit Both(const reduction::ReducedModel& model = machine_model()) : compensator(model), twin(model, fine()) {}
  Compensator compensator;
  OnlineTwin twin;
  double worst = 0, worst_std = 0, worst_tcp = 0;
  int others = 0;
  VectorXd last_um = VectorXd::Zero(3);

  const Offsets& step(double time, const VectorXd& row, const VectorXd& readings,
                      const std::vector<mesh::Pose>& poses) {
    const Offsets& wanted = compensator.step(time, row, readings);
    const Offsets& got = twin.step(time, row, readings);
    others += got.before_um != last_um;
    last_um = got.offset_um;
    worst = std::max(worst, (got.offset_um - wanted.offset_um).cwiseAbs().maxCoeff());
    worst_std = std::max(worst_std, (got.std_um - wanted.std_um).cwiseAbs().maxCoeff());
    others += got.status != wanted.status || got.failed_sensors != wanted.failed_sensors ||
              got.failed_inputs != wanted.failed_inputs;
    for (const mesh::Pose& pose : poses) {
      worst_tcp = std::max(worst_tcp, (twin.tcp(pose).error - compensator.tcp(pose).error).norm() / um);
      worst_std = std::max(worst_std, (twin.std_um(pose) - compensator.std_um(pose)).cwiseAbs().maxCoeff());
    }
    return got;
  }
};

/// @param share  of the prior. Eigenvectors, the patterns of the start, have no sign of their own.
void expect_near(const ErrorModel::State& one, const ErrorModel::State& other, double share) {
  const bool pattern = one.name.starts_with("start, pattern");
  EXPECT_NEAR(pattern ? std::abs(one.value) : one.value, pattern ? std::abs(other.value) : other.value,
              share * other.prior_std)
      << other.name;
}

void expect_same(const Detectability& seen, const Detectability& wanted) {
  EXPECT_EQ(seen.sensors, wanted.sensors);
  EXPECT_EQ(seen.detectable, wanted.detectable);
  EXPECT_NEAR(seen.slowest_s, wanted.slowest_s, 0.02 * wanted.slowest_s);
  EXPECT_NEAR(seen.margin, wanted.margin, 0.05 * wanted.margin);
}

TEST(OnlineTwin, ProbesAndLearnsAsTheCompensatorDoes) {
  const std::vector<mesh::Pose> probed = poses_of({"X=-300,Y=200,Z=100", "X=300,Y=-200,Z=400,B=90"}),
                                judged = poses_of({"X=100,Y=100,Z=300,B=45,C=90", "X=-200,Z=450"});
  const test::Truth truth = other_machine(501, 12 * 3600.0, probed);
  test::Uniform noise(1);
  Both both;
  OnlineTwin unprobed(machine_model(), fine());
  double moved = 0.0, narrower = 0.0;
  for (std::size_t i = 0; i < truth.time.size(); ++i) {
    const VectorXd readings = noisy(truth.readings_C[i], noise);
    both.step(truth.time[i], truth.rows[i], readings, judged);
    unprobed.step(truth.time[i], truth.rows[i], readings);
    moved = std::max(moved, (both.twin.tcp(judged[0]).error - unprobed.tcp(judged[0]).error).norm() / um);
    narrower = std::max(narrower, (unprobed.std_um(judged[0]) - both.twin.std_um(judged[0])).maxCoeff());
    if (i % 120 != 100) continue;
    for (std::size_t p = 0; p < probed.size(); ++p) {
      Vector3d value = truth.errors[i][p].error.head<3>() / um;
      if (i == 220) value[1] = missing;
      const VectorXd applied = VectorXd::LinSpaced(3, -1.5, 4.0);
      for (OnlineModel* model : {static_cast<OnlineModel*>(&both.compensator), static_cast<OnlineModel*>(&both.twin)}) {
        if (i % 240 == 100)
          model->probe(probed[p], value, 0.5);
        else
          model->probe_compensated(probed[p], value + applied, applied, 0.5);
      }
    }
  }
  EXPECT_LT(both.worst, 0.02) << "um";
  EXPECT_LT(both.worst_tcp, 0.02);
  EXPECT_LT(both.worst_std, 0.02);
  EXPECT_EQ(both.others, 0);
  EXPECT_GT(moved, 2.0) << "um: probing has to matter";
  EXPECT_GT(narrower, 0.3);
  EXPECT_EQ(both.twin.probed(), both.compensator.probed());
  EXPECT_GT(both.twin.probed(), 20);
  const std::vector<ErrorModel::State> learned = both.twin.learned(), wanted = both.compensator.learned();
  ASSERT_EQ(learned.size(), wanted.size());
  for (std::size_t k = 0; k < learned.size(); ++k) {
    EXPECT_EQ(learned[k].name, wanted[k].name);
    EXPECT_EQ(learned[k].unit, wanted[k].unit);
    expect_near(learned[k], wanted[k], 0.01);
    EXPECT_NEAR(learned[k].std, wanted[k].std, 0.01 * wanted[k].prior_std) << wanted[k].name;
    EXPECT_DOUBLE_EQ(learned[k].memory_s, wanted[k].memory_s);
  }
  expect_same(both.twin.detectability(), both.compensator.detectability());
}

// Rows 40 s apart: a value comes between two steps and between two corrections, beside a model with a stated error.
TEST(OnlineTwin, ProbesBetweenStepsAndCorrectionsAsTheCompensatorDoes) {
  reduction::ReducedModel model = machine_model();
  model.errors.emplace_back().rms_um = 3.0;
  const std::vector<mesh::Pose> probed = poses_of({"X=-300,Y=200,Z=100", "X=300,Y=-200,Z=400,B=90"});
  const test::Truth truth = other_machine(502, 3 * 3600.0, probed);
  test::Uniform noise(2);
  Both both(model);
  for (std::size_t i = 0; i < truth.time.size(); ++i) {
    both.step(40.0 * static_cast<double>(i), truth.rows[i], noisy(truth.readings_C[i], noise), probed);
    if (i % 9 != 8) continue;
    for (OnlineModel* one : {static_cast<OnlineModel*>(&both.compensator), static_cast<OnlineModel*>(&both.twin)})
      one->probe(probed[i % 2], truth.errors[i][i % 2].error.head<3>() / um, 0.5);
  }
  EXPECT_LT(both.worst, 0.02) << "um";
  EXPECT_LT(both.worst_tcp, 0.02);
  EXPECT_LT(both.worst_std, 0.02);
  const std::vector<ErrorModel::State> learned = both.twin.learned(), wanted = both.compensator.learned();
  ASSERT_EQ(learned.size(), wanted.size());
  for (std::size_t k = 0; k < learned.size(); ++k) {
    expect_near(learned[k], wanted[k], 0.01);
    EXPECT_NEAR(learned[k].std, wanted[k].std, 0.01 * wanted[k].prior_std) << wanted[k].name;
  }
}

// A sensor that drifts is released: its influence leaves the offsets by and by.
TEST(OnlineTwin, ADriftingSensorLeavesTheEstimateAsInTheCompensator) {
  const test::Truth truth = other_machine(601, 36 * 3600.0, {});
  test::Uniform noise(601);
  Both both;
  std::string named;
  for (std::size_t i = 0; i < truth.time.size(); ++i) {
    VectorXd readings = noisy(truth.readings_C[i], noise);
    readings[0] += 0.12 * std::max(0.0, truth.time[i] / 3600.0 - 6.0);
    named = both.step(truth.time[i], truth.rows[i], readings, {}).failed_sensors;
  }
  EXPECT_NE(named.find("=drift"), std::string::npos) << named;
  EXPECT_LT(both.worst, 0.02);
  EXPECT_LT(both.worst_std, 0.02);
  EXPECT_EQ(both.others, 0);
  expect_same(both.twin.detectability(), both.compensator.detectability());
}

TEST(OnlineTwin, AChannelThatNobodyGivesIsLearnedUnderItsName) {
  const test::Truth truth = other_machine(5, 7 * 3600.0, {});
  Both both;
  const Eigen::Index spindle = both.twin.channels().index("spindle.speed_rpm");
  both.compensator.never_told({spindle});
  both.twin.never_told({spindle});
  test::Uniform noise(5);
  for (std::size_t i = 0; i < truth.time.size(); ++i) {
    VectorXd row = truth.rows[i];
    row[spindle] = 0.0;
    both.step(truth.time[i], row, noisy(truth.readings_C[i], noise), {});
  }
  EXPECT_LT(both.worst, 1e-4);
  bool found = false;
  const std::vector<ErrorModel::State> learned = both.twin.learned(), wanted = both.compensator.learned();
  ASSERT_EQ(learned.size(), wanted.size());
  for (std::size_t k = 0; k < learned.size(); ++k) {
    EXPECT_EQ(learned[k].name, wanted[k].name);
    expect_near(learned[k], wanted[k], 1e-3);
    found = found || learned[k].name == "unrecorded heat of spindle";
  }
  EXPECT_TRUE(found);
  expect_same(both.twin.detectability(), both.compensator.detectability());
}

TEST(OnlineTwin, WithoutObserverThereIsNoDetectability) {
  ControlOptions options;
  options.observer = false;
  OnlineTwin twin(machine_model(), options);
  for (int i = 0; i < 5; ++i) twin.step(60.0 * i, twin.channels().defaults(), {});
  EXPECT_TRUE(twin.learned().empty());
  test::expect_input_error([&] { twin.detectability(); }, {"without observer"});
}

class SavedState : public ::testing::Test {
protected:
  SavedState() : truth_(other_machine(8, 14 * 3600.0, {})) {
    for (std::size_t i = 0; i < truth_.time.size(); ++i) readings_.push_back(noisy(truth_.readings_C[i], noise_));
  }
  void run(OnlineTwin& twin, std::size_t first, std::size_t last) const {
    for (std::size_t i = first; i < last; ++i) twin.step(truth_.time[i], truth_.rows[i], readings_[i]);
  }
  std::string file(const char* name) const { return (folder_.path() / name).string(); }
  /// All ways to go on from this state are refused, and the twin stays as it is.
  void refuse(const std::string& bytes, std::initializer_list<const char*> words) const {
    folder_.write("bad", bytes);
    OnlineTwin twin(machine_model());
    run(twin, 0, 3);
    const std::string before = twin.saved();
    test::expect_input_error([&] { twin.load_file(file("bad")); }, words);
    EXPECT_EQ(twin.saved(), before);
    EXPECT_EQ(core::read_file(file("bad")), bytes);
  }

  test::Uniform noise_{8};
  test::Truth truth_;
  std::vector<VectorXd> readings_;
  test::Scratch folder_;
};

TEST_F(SavedState, GoesOnWithTheSameBits) {
  OnlineTwin whole(machine_model()), first(machine_model()), second(machine_model());
  run(whole, 0, 500);
  run(first, 0, 217);
  first.save_file(file("state"));
  second.load_file(file("state"));
  EXPECT_EQ(second.time(), truth_.time[216]);
  run(second, 217, 500);
  EXPECT_EQ(second.saved(), whole.saved());
}

TEST_F(SavedState, OfAnotherModelOrVersionOrCutOffIsRefused) {
  OnlineTwin twin(machine_model());
  run(twin, 0, 20);
  const std::string good = twin.saved();
  refuse(good.substr(0, good.size() / 2), {"bad", "cut off", "allowed: "});
  refuse(good.substr(0, 20), {"bad", "cut off"});
  refuse("", {"bad", "no saved state"});
  refuse(good + "more", {"bad", "damaged"});
  std::string other = good;
  other[8] = static_cast<char>(other[8] + 1);
  refuse(other, {"another version"});
  std::string damaged = good;
  damaged[good.size() / 2] = static_cast<char>(damaged[good.size() / 2] ^ 1);
  refuse(damaged, {"damaged"});
  ControlOptions options;
  options.compensator.step_s = 30.0;
  OnlineTwin quicker(machine_model(), options);
  test::expect_input_error([&] { quicker.load(good); }, {"another model, or of the same model with other options"});
  test::expect_input_error([&] { twin.load_file(file("none")); }, {"none", "cannot be read"});
}

/// A night with the power off: as rows of a machine that is off, with wider deviations; offsets begin at zero.
TEST_F(SavedState, APauseIsComputedAsAMachineThatIsOff) {
  constexpr double night_s = 8 * 3600.0;
  OnlineTwin twin(machine_model());
  run(twin, 0, 400);
  const std::string saved = twin.saved();
  const double evening = twin.time(), morning = evening + night_s;
  const mesh::Pose pose = twin.pose();
  const std::vector<ErrorModel::State> before = twin.learned();
  const Vector3d warm = twin.tcp(pose).error.head<3>() / um;

  OnlineTwin resumed(machine_model()), held(machine_model());
  resumed.load(saved);
  const VectorXd row = truth_.rows[400];
  const Offsets& first = resumed.step(morning, row, {});
  const std::vector<ErrorModel::State> after = resumed.learned();
  ASSERT_EQ(after.size(), before.size());
  int wider = 0;
  for (std::size_t k = 0; k < after.size(); ++k) {
    EXPECT_GE(after[k].std, before[k].std * 0.999) << after[k].name;
    wider += after[k].std > 1.05 * before[k].std;
  }
  EXPECT_GT(wider, 2) << "nobody has looked for a night";
  EXPECT_EQ(first.offset_um, VectorXd(VectorXd::Zero(3))) << "offsets begin anew";
  EXPECT_EQ(first.before_um, VectorXd(VectorXd::Zero(3)));

  held.load(saved);
  VectorXd off = row;
  for (std::size_t k = 0; k < held.channels().names().size(); ++k) {
    const std::string& name = held.channels().names()[k];
    for (const char* end : {".on", ".open", ".speed_rpm", "_min"})
      if (name.ends_with(end)) off[static_cast<Eigen::Index>(k)] = 0.0;
  }
  for (double time = evening + 60.0; time < morning; time += 60.0) held.step(time, off, {});
  held.step(morning, row, {});
  const Vector3d cold = resumed.tcp(pose).error.head<3>() / um, as_rows = held.tcp(pose).error.head<3>() / um;
  EXPECT_LT((cold - as_rows).norm(), 0.1) << "um";
  EXPECT_GT((cold - warm).norm(), 2.0) << "um: the night has to matter";
}

/// A short pause at full speed: the work ends with the power, and the axes stay where they were.
TEST_F(SavedState, APauseEndsTheWorkAndMovesNoAxis) {
  OnlineTwin twin(machine_model()), resumed(machine_model()), held(machine_model());
  run(twin, 0, 400);
  const Eigen::Index X = twin.channels().index("axis.X.position_mm");
  const double evening = truth_.time[400], morning = evening + 600.0;
  VectorXd last = truth_.rows[400];
  last[X] = 310.0;
  twin.step(evening, last, readings_[400]);
  const std::string saved = twin.saved();

  held.load(saved);
  VectorXd off = twin.channels().defaults();
  for (std::size_t k = 0; k < held.channels().names().size(); ++k) {
    const std::string& name = held.channels().names()[k];
    const auto at = static_cast<Eigen::Index>(k);
    if (name.ends_with(".on")) off[at] = 0.0;
    if (name.ends_with("T_C")) off[at] = last[at];
  }
  off[X] = 310.0;
  for (double time = evening + 60.0; time <= morning; time += 60.0) held.step(time, off, {});
  resumed.load(saved);
  off[X] = missing;
  resumed.step(morning, off, {});
  EXPECT_EQ(resumed.pose(), twin.pose());
  EXPECT_LT((resumed.state() - held.state()).cwiseAbs().maxCoeff(), 0.2) << "K";
  EXPECT_GT((resumed.state() - twin.state()).cwiseAbs().maxCoeff(), 2.0) << "K: the pause has to matter";
}

/// The machine worked on for more than an hour while nobody computed it.
TEST_F(SavedState, APauseThatTheReadingsContradictStartsAnew) {
  OnlineTwin twin(machine_model());
  run(twin, 0, 400);
  const std::string saved = twin.saved();
  std::size_t i = 400;
  while (truth_.time[i] < truth_.time[399] + 4000.0) ++i;
  OnlineTwin resumed(machine_model()), off(machine_model()), kept(machine_model());
  resumed.load(saved);
  const auto cold_at = [](double time, const VectorXd& row, const VectorXd& readings) {
    OnlineTwin cold(machine_model());
    cold.step(time, row, readings);
    return cold.saved();
  };
  resumed.step(truth_.time[i], truth_.rows[i], readings_[i]);
  EXPECT_TRUE(resumed.saved() == cold_at(truth_.time[i], truth_.rows[i], readings_[i]));
  // Readings of a machine that was off contradict nothing.
  off.load(saved);
  off.pass_pause(truth_.time[i]);
  kept.load(saved);
  const VectorXd still = noisy(off.predicted_sensors_C(), noise_);
  kept.step(truth_.time[i], truth_.rows[i], still);
  EXPECT_FALSE(kept.saved() == cold_at(truth_.time[i], truth_.rows[i], still));
  EXPECT_LT((kept.predicted_sensors_C() - off.predicted_sensors_C()).cwiseAbs().maxCoeff(), 0.5) << "goes on";
  // One sensor alone may be faulty.
  OnlineTwin beside(machine_model());
  VectorXd one = still;
  one[0] += 10.0;
  beside.load(saved);
  beside.step(truth_.time[i], truth_.rows[i], one);
  EXPECT_FALSE(beside.saved() == cold_at(truth_.time[i], truth_.rows[i], one));
}

TEST_F(SavedState, AShortGapIsNoPauseAndAVeryLongOneStartsCold) {
  OnlineTwin twin(machine_model());
  run(twin, 0, 300);
  const std::string saved = twin.saved();
  OnlineTwin on(machine_model()), again(machine_model()), cold(machine_model());
  on.load(saved);
  twin.step(truth_.time[299] + 240.0, truth_.rows[300], readings_[300]);
  on.step(truth_.time[299] + 240.0, truth_.rows[300], readings_[300]);
  EXPECT_EQ(on.saved(), twin.saved());

  again.load(saved);
  const double later = truth_.time[299] + 40 * 86400.0;
  const Offsets& offsets = again.step(later, truth_.rows[0], readings_[0]);
  const Offsets& wanted = cold.step(later, truth_.rows[0], readings_[0]);
  EXPECT_EQ(offsets.offset_um, wanted.offset_um);
  EXPECT_EQ(again.saved(), cold.saved());

  // The rows after a state may have other columns than those before it.
  OnlineTwin without(machine_model()), still(machine_model()), with(machine_model());
  const std::vector<Eigen::Index> spindle = {without.channels().index("spindle.speed_rpm")};
  const auto go_on = [&](OnlineTwin& one, std::size_t first) {
    for (std::size_t i = first; i < first + 60; ++i) one.step(truth_.time[i], truth_.rows[200], readings_[i]);
    return one.std_um(twin.pose()).norm();
  };
  without.load(saved);
  without.never_told(spindle);
  with.load(saved);
  EXPECT_GT(go_on(without, 300), 1.1 * go_on(with, 300));
  still.load(without.saved());
  still.never_told(spindle);
  with.load(without.saved());
  with.never_told({});
  EXPECT_LT(go_on(with, 360), go_on(still, 360));

  again.load(saved);
  test::expect_input_error([&] { again.step(truth_.time[299], truth_.rows[0], {}); }, {"of the saved state"});
}

}  // namespace
}  // namespace thermotwin::compensation
