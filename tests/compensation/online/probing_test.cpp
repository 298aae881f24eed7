// SPDX-License-Identifier: GPL-3.0-or-later
// Probing results that arrive now and then re-identify the machine beside the control.
#include <gtest/gtest.h>

#include <sstream>

#include "compensation/measurement/virtual_measurement.h"
#include "compensation/online/compensator.h"
#include "compensation/online/stream.h"
#include "core/missing.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/reduced_simulation.h"
#include "tests/compensation/records.h"
#include "tests/compensation/scratch.h"
#include "tests/compensation/shift.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using test::expect_input_error;

using core::missing;
constexpr double um = 1e-6;

const reduction::ReducedModel& nominal() {
  static const reduction::ReducedModel model = test::lumped_model();
  return model;
}

std::vector<mesh::Pose> poses_of(std::initializer_list<const char*> texts) {
  std::vector<mesh::Pose> poses;
  for (const char* text : texts) poses.push_back(mesh::parse_pose(nominal().machine, text, "test"));
  return poses;
}

/// Two days of a machine that differs in its parameters, in what no parameter says, and in the expansion
/// of both sides; the shift of shift.h, each day.
test::Truth two_days(std::uint64_t seed, const std::vector<mesh::Pose>& poses) {
  reduction::ReducedModel structure = test::lumped_model({1.02, 0.96, 0.05});
  for (Eigen::MatrixXd& rows : structure.outputs.tool) rows *= 1.05;
  for (Eigen::MatrixXd& rows : structure.outputs.table_axis) rows *= 0.96;
  for (Eigen::MatrixXd& rows : structure.outputs.table_own) rows *= 0.96;
  return test::run_truth(perturbed(nominal().machine, seed, 2.0), structure, 60.0, 2, 48 * 3600.0, poses);
}

struct Result {
  double rms_um = 0, largest_jump_um = 0, ratio = 0;
};

/// @param probe_every_s  0: never. RMS over the second day at poses that were not probed.
Result probed_day(const test::Truth& truth, const std::vector<mesh::Pose>& probed,
                  const std::vector<mesh::Pose>& judged, double probe_every_s, bool sensors, std::uint64_t seed) {
  test::Uniform noise(seed);
  Compensator compensator(nominal());
  Result result;
  double sum = 0.0, count = 0.0, ratios = 0.0, next = probe_every_s;
  const std::size_t first = probed.size();
  for (std::size_t i = 0; i < truth.time.size(); ++i) {
    VectorXd readings = truth.readings_C[i];
    for (double& value : readings) value += 0.03 * noise.normal();
    std::vector<Vector3d> before;
    for (const mesh::Pose& pose : judged) before.push_back(compensator.tcp(pose).error.head<3>());
    const Offsets& offsets = compensator.step(truth.time[i], truth.rows[i], sensors ? readings : VectorXd());
    for (std::size_t p = 0; p < judged.size(); ++p) {
      const Vector3d predicted = compensator.tcp(judged[p]).error.head<3>(),
                     moved = truth.errors[i][first + p].error.head<3>();
      if (i > 1) result.largest_jump_um = std::max(result.largest_jump_um, (predicted - before[p]).norm() / um);
      if (truth.time[i] < 24 * 3600.0) continue;
      sum += (predicted - moved).squaredNorm();
      count += 1.0;
    }
    if (truth.time[i] >= 24 * 3600.0) {
      // The offset is that of the row's own pose, which is home here: the first of the judged.
      ratios += ((offsets.offset_um * um + truth.errors[i][first].error.head<3>()).cwiseQuotient(offsets.std_um * um))
                    .squaredNorm() /
                3.0;
    }
    if (probe_every_s > 0.0 && truth.time[i] >= next) {
      next += probe_every_s;
      for (std::size_t p = 0; p < first; ++p) {
        Vector3d value = truth.errors[i][p].error.head<3>() / um;
        for (double& v : value) v += 0.3 * noise.normal();
        compensator.probe(probed[p], value, 0.5);
      }
    }
  }
  result.rms_um = std::sqrt(sum / count) / um;
  result.ratio = std::sqrt(ratios * static_cast<double>(judged.size()) / count);
  return result;
}

TEST(Probing, EveryFourHoursHalvesTheErrorOfAMachineThatDiffers) {
  const std::vector<mesh::Pose> probed = poses_of({"X=-300,Y=200,Z=100", "X=300,Y=-200,Z=400,B=90"});
  const std::vector<mesh::Pose> judged = poses_of({"", "X=100,Y=100,Z=300,B=45,C=90", "X=-200,Z=450"});
  std::vector<mesh::Pose> all = probed;
  all.insert(all.end(), judged.begin(), judged.end());
  double with_probing = 0.0, sensors_only = 0.0, blind = 0.0, blind_probing = 0.0;
  for (const std::uint64_t seed : {501U, 502U, 503U, 504U}) {
    const test::Truth truth = two_days(seed, all);
    const Result none = probed_day(truth, probed, judged, 0.0, true, seed),
                 some = probed_day(truth, probed, judged, 4 * 3600.0, true, seed);
    const Result no_sensors = probed_day(truth, probed, judged, 0.0, false, seed),
                 alone = probed_day(truth, probed, judged, 4 * 3600.0, false, seed);
    std::printf(
        "  machine %d: second day, poses that were not probed: %.2f um, with probing %.2f; without sensors %.2f and "
        "%.2f; residual over stated %.2f; step %.2f um\n",
        static_cast<int>(seed), none.rms_um, some.rms_um, no_sensors.rms_um, alone.rms_um, some.ratio,
        some.largest_jump_um);
    with_probing += some.rms_um * some.rms_um;
    sensors_only += none.rms_um * none.rms_um;
    blind += no_sensors.rms_um * no_sensors.rms_um;
    blind_probing += alone.rms_um * alone.rms_um;
    // What probing finds comes bit by bit: in two minutes hardly more than the drift itself.
    EXPECT_LT(some.largest_jump_um, none.largest_jump_um + 1.0);
    EXPECT_GT(some.ratio, 0.15);
    EXPECT_LT(some.ratio, 2.5);
  }
  EXPECT_LT(with_probing, 0.5 * sensors_only);
  EXPECT_LT(blind_probing, 0.25 * blind);
}

TEST(Probing, NamesWhatItFinds) {
  // Nothing differs but the motion of the tool side, and the power of the spindle's bearings.
  mesh::Machine machine = nominal().machine;
  for (mesh::SourceSpec& source : machine.sources) {
    if (source.id == "spindle_bearings") source.scale.value = 1.12;
  }
  reduction::ReducedModel structure = test::lumped_model();
  for (Eigen::MatrixXd& rows : structure.outputs.tool) rows *= 1.06;
  const std::vector<mesh::Pose> probed = poses_of({"", "X=300,Y=-200,Z=400,B=90"});
  const test::Truth truth = test::run_truth(machine, structure, 60.0, 2, 24 * 3600.0, probed);
  Compensator compensator(nominal());
  const std::vector<ErrorModel::State> at_first = compensator.learned();
  EXPECT_TRUE(at_first.empty());
  for (std::size_t i = 0; i < truth.time.size(); ++i) {
    compensator.step(truth.time[i], truth.rows[i], truth.readings_C[i]);
    if (i % 30 != 15) continue;
    for (std::size_t p = 0; p < probed.size(); ++p)
      compensator.probe(probed[p], truth.errors[i][p].error.head<3>() / um, 0.3);
  }
  EXPECT_GT(compensator.probed(), 50);
  bool power = false, motion = false;
  for (const ErrorModel::State& state : compensator.learned()) {
    if (state.name == "power of source spindle_bearings") {
      power = true;
      EXPECT_NEAR(state.value, 0.12, 0.03);
      EXPECT_LT(state.std, 0.6 * state.prior_std);
    }
    if (state.name.starts_with("motion of the tool side")) {
      motion = true;
      EXPECT_NEAR(state.value, 0.06, 2.0 * state.std) << state.name;
      EXPECT_GT(state.value, 0.02) << state.name;
      EXPECT_LT(state.std, 0.7 * state.prior_std) << state.name;
    }
  }
  EXPECT_TRUE(power && motion);
}

TEST(Probing, WhatIsLeftWithOffsetsIsTheSameKnowledge) {
  const std::vector<mesh::Pose> poses = poses_of({"X=200,Y=100,Z=200"});
  const test::Truth truth =
      test::run_truth(perturbed(nominal().machine, 7, 2.0), nominal(), 60.0, 5, 6 * 3600.0, poses);
  Compensator plain(nominal()), compensated(nominal());
  for (std::size_t i = 0; i < truth.time.size(); ++i) {
    plain.step(truth.time[i], truth.rows[i], {});
    compensated.step(truth.time[i], truth.rows[i], {});
    if (i % 12 != 6) continue;
    const Vector3d error = truth.errors[i][0].error.head<3>() / um;
    // All linear axes carry the tool: an offset moves it as it says.
    const Vector3d applied(1.5, -2.0, 4.0);
    plain.probe(poses[0], error, 0.5);
    compensated.probe_compensated(poses[0], error + applied, applied, 0.5);
  }
  EXPECT_LT((plain.tcp(poses[0]).error - compensated.tcp(poses[0]).error).norm(), 1e-12);
}

TEST(Probing, WildValuesNeitherBreakNorDriveItFar) {
  const std::vector<mesh::Pose> poses = poses_of({""});
  const test::Truth truth = test::run_truth(nominal().machine, nominal(), 60.0, 5, 12 * 3600.0, poses);
  Compensator compensator(nominal());
  double worst = 0.0;
  for (std::size_t i = 0; i < truth.time.size(); ++i) {
    compensator.step(truth.time[i], truth.rows[i], truth.readings_C[i]);
    if (i % 24 == 6) compensator.probe(poses[0], Vector3d(i % 48 == 6 ? 3000.0 : -3000.0, missing, 500.0), 0.5);
    ASSERT_TRUE(compensator.state().allFinite());
    worst = std::max(worst, (compensator.tcp(poses[0]).error - truth.errors[i][0].error).head<3>().norm() / um);
  }
  EXPECT_LT(worst, 60.0);  // 3 mm were claimed
}

TEST(Probing, ColumnsOfAStreamAndWrongCalls) {
  Compensator compensator(nominal()), blank(nominal());
  const std::string header = "time_s,spindle.speed_rpm,axis.X.position_mm,probe_dx_um,probe_dy_um,probe_dz_um\n";
  std::string with = header, without = header;
  for (int i = 0; i <= 120; ++i) {
    const std::string row = std::to_string(60 * i) + ",6000,100,";
    with += row + (i == 60 ? "12,,-8\n" : ",,\n");
    without += row + ",,\n";
  }
  std::istringstream in(with), in_blank(without);
  std::ostringstream out, out_blank;
  EXPECT_EQ(compensate_stream(compensator, nominal().machine, in, "rows", out).rows, 121);
  EXPECT_EQ(compensate_stream(blank, nominal().machine, in_blank, "rows", out_blank).rows, 121);
  EXPECT_EQ(compensator.probed(), 2);
  EXPECT_EQ(blank.probed(), 0);
  const std::string a = out.str(), b = out_blank.str();
  std::size_t lines = 0, same = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()) && a[i] == b[i]; ++i) same += a[i] == '\n';
  for (const char c : a) lines += c == '\n';
  EXPECT_GE(same, 61U);  // in effect after the row that brought it
  EXPECT_LT(same, lines - 40);
  mesh::Pose pose = mesh::home_pose(nominal().machine);
  pose[0] = 0.1;
  // Probed: x was 12 um, so it is nearer to that than the model alone.
  const double before = blank.tcp(pose).error[0] / um, after = compensator.tcp(pose).error[0] / um;
  EXPECT_LT(std::abs(after - 12.0), 0.8 * std::abs(before - 12.0));

  Compensator fresh(nominal());
  expect_input_error([&] { fresh.probe(pose, Vector3d::Zero(), 0.5); }, {"no row yet"});
  fresh.step(0.0, fresh.channels().defaults(), {});
  expect_input_error([&] { fresh.probe(pose, Vector3d::Zero(), 0.0); }, {"std_um"});
  expect_input_error([&] { fresh.probe(pose, Vector3d(1e9, 0, 0), 0.5); }, {"um"});
}

}  // namespace
}  // namespace thermotwin::compensation
