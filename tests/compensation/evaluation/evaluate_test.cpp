// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/evaluation/evaluate.h"

#include <fmt/format.h>

#include <cstdlib>
#include <iterator>

#include "compensation/evaluation/reduced_models.h"
#include "compensation/evaluation/result.h"
#include "compensation/evaluation/scoring.h"
#include "mesh/machine/kinematics.h"
#include "tests/compensation/scratch.h"
#include "tests/compensation/shift.h"

namespace thermotwin::compensation {
namespace {

using test::expect_input_error;

std::filesystem::path data_folder(const std::string& name) {
  const char* given = std::getenv("THERMOTWIN_DATA");
  const std::filesystem::path root =
      given != nullptr ? std::filesystem::path(given)
                       : std::filesystem::path(THERMOTWIN_SOURCE_DIR).parent_path() / "shared" / "data";
  return root / name;
}

const EvaluationRow& row_of(const Evaluation& evaluation, const std::string& model, const std::string& channel,
                            const std::string& segment) {
  for (const EvaluationRow& row : evaluation.rows) {
    if (row.model == model && row.channel == channel && row.segment == segment) return row;
  }
  throw std::runtime_error("no row " + model + " " + channel + " " + segment);
}

TEST(Evaluate, MeasuredDriftIsJudgedOnDaysThatTheFitDidNotSee) {
  const std::filesystem::path folder = data_folder("measured_drift");
  if (!std::filesystem::exists(folder / "data.csv")) GTEST_SKIP() << "no measured data: " << folder;
  const Measurement measurement = read_measurement(folder);
  EvaluateOptions options;
  options.models = {"static_regression", "first_order", "grey_box"};
  const Evaluation evaluation = evaluate(measurement, nullptr, options);
  std::printf("%s", (evaluation.brief() + evaluation.tables()).c_str());
  ASSERT_EQ(evaluation.rows.size(), 3U * 3U * 3U);
  EXPECT_EQ(evaluation.predictions.rows(), measurement.data.rows());
  for (const EvaluationRow& row : evaluation.rows) {
    EXPECT_GT(row.measures.count, 3000) << row.model << row.channel << row.segment;
    EXPECT_EQ(row.unit, "um");
    EXPECT_EQ(row.training, row.segment == "training");
    if (row.training) {
      EXPECT_LE(row.to_s, 86400.0);
    } else {
      EXPECT_GE(row.from_s, 86400.0);
    }
  }
  for (const char* channel : {"x", "y", "z"}) {
    // The first-order model contains the static one (tau towards 0), so it fits its own data no worse.
    EXPECT_LE(row_of(evaluation, "first_order", channel, "training").measures.rms,
              row_of(evaluation, "static_regression", channel, "training").measures.rms * 1.01);
  }
  // The rows without temperatures (20 at the end of each recorded day) are left out, not guessed.
  const Eigen::VectorXd predicted = evaluation.predictions.column("x_static_regression");
  const Eigen::VectorXd t1 = measurement.data.column("T1");
  for (Eigen::Index i = 0; i < t1.size(); ++i) EXPECT_EQ(std::isnan(predicted[i]), std::isnan(t1[i])) << i;
  // On days that no fit saw the grey box stays at least 30 % below the static regression.
  ASSERT_EQ(evaluation.leaderboard.front().model, "grey_box");
  EXPECT_GT(evaluation.leaderboard.front().against_static_percent, 30.0);
}

TEST(Evaluate, LaterDataDoNotReachTheFit) {
  const test::Scratch scratch;
  std::string data = "time_s,T,x\n", spoiled = data;
  for (int i = 0; i < 200; ++i) {
    const double t = 20 + std::sin(0.1 * i);
    const std::string head = std::to_string(1000 * i) + "," + std::to_string(t) + ",";
    data += head + std::to_string(3 * t - 60) + "\n";
    spoiled += head + std::to_string(i < 87 ? 3 * t - 60 : 1000.0 * i) + "\n";
  }
  scratch.write("channels.toml",
                "[[channel]]\nid='T'\nkind='temperature'\nunit='degC'\nuncertainty=0.1\nsensor='T'\n"
                "[[channel]]\nid='x'\nkind='displacement'\nunit='um'\nuncertainty=0.1\ndirection='x'\n");
  scratch.write("data.csv", data);
  EvaluateOptions options;
  options.models = {"static_regression"};
  const Evaluation clean = evaluate(read_measurement(scratch.path()), nullptr, options);
  scratch.write("data.csv", spoiled);
  const Evaluation other = evaluate(read_measurement(scratch.path()), nullptr, options);
  EXPECT_EQ(clean.predictions.column("x_static_regression"), other.predictions.column("x_static_regression"));
  EXPECT_GT(row_of(clean, "static_regression", "x", "day 1").measures.fit, 99.9);
  EXPECT_LT(row_of(other, "static_regression", "x", "day 1").measures.fit, 0.0);
}

TEST(Evaluate, AFewLastRowsAreNoDayOfTheirOwn) {
  const test::Scratch scratch;
  scratch.write("channels.toml",
                "[[channel]]\nid='T'\nkind='temperature'\nunit='degC'\nuncertainty=0.1\nsensor='T'\n"
                "[[channel]]\nid='x'\nkind='displacement'\nunit='um'\nuncertainty=0.1\ndirection='x'\n");
  const auto parts = [&](int rows) {
    std::string data = "time_s,T,x\n";
    for (int i = 0; i < rows; ++i)
      data += fmt::format("{},{},{}\n", 600 * i, 20 + std::sin(0.1 * i), std::sin(0.1 * i));
    scratch.write("data.csv", data);
    EvaluateOptions options;
    options.train_until_s = 43200;
    return segments_of(read_measurement(scratch.path()), options);
  };
  const auto short_rest = parts(2 * 144 + 1), long_rest = parts(2 * 144 + 8);
  ASSERT_EQ(short_rest.size(), 3U);
  EXPECT_EQ(short_rest.back().name, "day 1");
  EXPECT_GT(short_rest.back().to, 2 * 86400.0) << "the last row belongs to it";
  ASSERT_EQ(long_rest.size(), 4U);
  EXPECT_EQ(long_rest.back().name, "day 2");
}

TEST(Evaluate, AClockMayStartAnywhere) {
  const test::Scratch scratch;
  scratch.write("channels.toml",
                "[[channel]]\nid='T'\nkind='temperature'\nunit='degC'\nuncertainty=0.1\nsensor='T'\n"
                "[[channel]]\nid='x'\nkind='displacement'\nunit='um'\nuncertainty=0.1\ndirection='x'\n");
  EvaluateOptions options;
  options.models = {"static_regression"};
  std::vector<Evaluation> found;
  for (const double start : {0.0, 1.7e9}) {
    std::string data = "time_s,T,x\n";
    for (int i = 0; i < 200; ++i) {
      const double t = 20 + std::sin(0.1 * i);
      data += std::to_string(start + 1000.0 * i) + "," + std::to_string(t) + "," + std::to_string(3 * t * t) + "\n";
    }
    scratch.write("data.csv", data);
    found.push_back(evaluate(read_measurement(scratch.path()), nullptr, options));
  }
  ASSERT_EQ(found[0].rows.size(), 3U) << "a day of training, two to judge on";
  ASSERT_EQ(found[1].rows.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(found[0].rows[i].segment, found[1].rows[i].segment);
    EXPECT_EQ(found[0].rows[i].measures.count, found[1].rows[i].measures.count);
    EXPECT_NEAR(found[0].rows[i].measures.rms, found[1].rows[i].measures.rms, 1e-9);
  }
}

double observed(const mesh::Machine& machine, const std::string& quantity, const std::string& pose_text,
                const solver::Vector6& tool, const solver::Vector6& axis, const solver::Vector7& own,
                const std::string& frame = "machine") {
  MeasuredChannel channel;
  channel.id = channel.quantity = quantity;
  channel.frame = frame;
  const mesh::Pose pose = mesh::parse_pose(machine, pose_text, "test");
  const ObservedQuantity of(machine, channel, pose);
  std::vector<solver::TcpError> errors;
  for (const mesh::Pose& at : of.poses()) errors.push_back(solver::tcp_error(machine, at, tool, axis, own));
  return of(errors);
}

TEST(ObservedQuantity, ComponentsOfTheErrorAtThePose) {
  const mesh::Machine machine = test::five_axis_machine();
  solver::Vector6 tool;
  tool << 1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6;
  const auto value = [&](const char* quantity, const char* frame = "machine") {
    return observed(machine, quantity, "B=90", tool, solver::Vector6::Zero(), solver::Vector7::Zero(), frame);
  };
  EXPECT_NEAR(value("dx"), 1.0, 1e-12);
  EXPECT_NEAR(value("dz"), 3.0, 1e-12);
  EXPECT_NEAR(value("rc"), 6.0, 1e-12);
  EXPECT_NEAR(std::abs(value("dx", "table")), 3.0, 1e-9) << "B has turned the table's x to the machine's z";
  for (const char* error : {"X0C", "Z0T", "A0C", "X0B", "R0T"})
    EXPECT_NEAR(value(error), 0.0, 1e-9) << error << ": the tool's side is no location error";
}

// The seat of the table's bearing moves by d and w at the table's point, in the frame of the swivel body; the table
// grows. Errors of C stand in this frame, those of B in the machine's, each at a point of its own axis.
TEST(ObservedQuantity, LocationErrorsHaveTheirOwnFrameAndPoint) {
  mesh::Machine machine = test::five_axis_machine();
  const Eigen::Vector3d b_origin(0.03, 0.0, -0.12), c_origin(0.01, -0.02, 0.0);
  machine.axes[machine.axis_index("B")].origin = b_origin;
  machine.axes[machine.axis_index("C")].origin = c_origin;
  const Eigen::Vector3d d(10e-6, -20e-6, 30e-6), w(50e-6, -60e-6, 70e-6);
  solver::Vector6 axis;
  axis << d, w;
  solver::Vector7 own = solver::Vector7::Zero();
  own[6] = 12e-6;
  const double um = 1e-6;
  for (const char* pose : {"X=40,Y=-30", "X=-60,Y=20,B=35,C=80", "B=-90,C=10"}) {
    const auto value = [&](const char* quantity) {
      return observed(machine, quantity, pose, solver::Vector6::Constant(1e-6), axis, own);
    };
    const Eigen::Vector3d at_c = d + w.cross(c_origin - machine.tcp.table_point);
    EXPECT_NEAR(value("X0C"), at_c[0] / um, 1e-6) << pose;
    EXPECT_NEAR(value("Y0C"), at_c[1] / um, 1e-6) << pose;
    EXPECT_NEAR(value("Z0C"), at_c[2] / um, 1e-6) << pose;
    EXPECT_NEAR(value("A0C"), w[0] / um, 1e-6) << pose;
    EXPECT_NEAR(value("B0C"), w[1] / um, 1e-6) << pose;
    EXPECT_NEAR(value("Z0T"), d[2] / um, 1e-6) << pose;
    EXPECT_NEAR(value("R0T"), 12.0, 1e-6) << pose;
    const mesh::Pose at = mesh::parse_pose(machine, pose, "test");
    const Eigen::Isometry3d swivel = mesh::body_transform(machine, machine.body_index("swivel"), at);
    const Eigen::Vector3d at_b = swivel.linear() * (d + w.cross(b_origin - machine.tcp.table_point));
    const Eigen::Vector3d turn_b = swivel.linear() * w;
    EXPECT_NEAR(value("X0B"), at_b[0] / um, 1e-6) << pose;
    EXPECT_NEAR(value("Z0B"), at_b[2] / um, 1e-6) << pose;
    EXPECT_NEAR(value("A0B"), turn_b[0] / um, 1e-6) << pose;
    EXPECT_NEAR(value("C0B"), turn_b[2] / um, 1e-6) << pose;
  }
}

TEST(ObservedQuantity, QuantitiesThatTheMachineDoesNotHaveAreRefused) {
  const mesh::Machine machine = test::five_axis_machine();
  for (const char* quantity : {"X0A", "R0C", "Q0C", "dq", "X1C"}) {
    MeasuredChannel channel;
    channel.id = channel.quantity = quantity;
    expect_input_error([&] { ObservedQuantity(machine, channel, mesh::home_pose(machine)); }, {quantity, "location"});
  }
}

/// A measurement of the lumped machine made without writing files.
Measurement measured(const reduction::ReducedModel& model, const test::Truth& truth,
                     const std::vector<std::string>& pose_texts) {
  Measurement m;
  const solver::Channels channels(model.machine);
  const auto times = std::ssize(truth.time);
  std::vector<Eigen::VectorXd> columns{Eigen::Map<const Eigen::VectorXd>(truth.time.data(), times)};
  m.data.columns = {"time_s"};
  const auto add = [&](MeasuredChannel channel, const auto& value) {
    channel.column = std::ssize(columns);
    Eigen::VectorXd values(times);
    for (Eigen::Index i = 0; i < times; ++i) values[i] = value(i);
    m.data.columns.push_back(channel.id);
    columns.push_back(values);
    m.channels.push_back(std::move(channel));
  };
  for (const auto& [name, kind, unit] : {std::tuple{"air.T_C", ChannelKind::temperature, "degC"},
                                         {"spindle.speed_rpm", ChannelKind::speed, "rpm"},
                                         {"axis.X.feed_mm_min", ChannelKind::speed, "mm_min"},
                                         {"axis.X.low_mm", ChannelKind::position, "mm"},
                                         {"axis.X.high_mm", ChannelKind::position, "mm"},
                                         {"axis.C.feed_deg_min", ChannelKind::speed, "deg_min"},
                                         {"cutting_fluid.on", ChannelKind::state, "1"}}) {
    MeasuredChannel channel;
    channel.id = channel.input = name;
    channel.kind = kind;
    channel.unit = unit;
    const int index = channels.index(name);
    add(channel, [&, index](std::size_t i) { return truth.rows[std::min(i + 1, truth.rows.size() - 1)][index]; });
  }
  for (std::size_t s = 0; s < model.machine.sensors.size(); ++s) {
    MeasuredChannel channel;
    channel.id = channel.sensor = model.machine.sensors[s].id;
    channel.kind = ChannelKind::temperature;
    channel.unit = "degC";
    channel.uncertainty = 0.05;
    add(channel, [&, s](std::size_t i) { return truth.readings_C[i][s]; });
  }
  for (std::size_t p = 0; p < pose_texts.size(); ++p) {
    for (int k = 0; k < 3; ++k) {
      static constexpr const char* names[] = {"dx", "dy", "dz"};
      MeasuredChannel channel;
      channel.quantity = names[k];
      channel.id = channel.quantity + "@" + std::to_string(p + 1);
      channel.kind = ChannelKind::displacement;
      channel.unit = "um";
      channel.uncertainty = 0.3;
      channel.pose_text = pose_texts[p];
      channel.zero = Zero::first;
      add(channel, [&, p, k](std::size_t i) { return 1e6 * truth.errors[i][p].error[k] + 50.0; });  // an arbitrary zero
    }
  }
  m.data.values.resize(times, std::ssize(columns));
  for (std::size_t i = 0; i < columns.size(); ++i) m.data.values.col(i) = columns[i];
  return m;
}

TEST(Evaluate, AReducedModelMeetsItsOwnMachineWithAndWithoutSensors) {
  const reduction::ReducedModel model = test::lumped_model();
  const std::vector<std::string> texts{"", "X=200,Z=100,B=45,C=90"};
  std::vector<mesh::Pose> poses;
  for (const std::string& text : texts) poses.push_back(mesh::parse_pose(model.machine, text, "test"));
  const test::Truth truth = test::run_truth(model.machine, model, 60.0, 5, 10 * 3600.0, poses);
  const Measurement measurement = measured(model, truth, texts);
  const Evaluation evaluation =
      evaluate(measurement, &model,
               {.train_until_s = 5 * 3600.0, .train_programs = {}, .models = {"static_regression"}, .check = {}});
  std::printf("%s", (evaluation.brief() + evaluation.tables()).c_str());
  for (const char* channel : {"dx@1", "dz@1", "dx@2", "dy@2", "dz@2"}) {
    for (const char* name : {"reduced_model", "reduced_model_sensors"}) {
      EXPECT_GT(row_of(evaluation, name, channel, "day 0").measures.fit, 97.0) << name << " " << channel;
    }
  }
}

// Two rows fit no model: an empty table would say nothing of that.
TEST(Evaluate, ATrainingTimeWithFewerThanThreeRowsIsRefused) {
  const reduction::ReducedModel model = test::lumped_model();
  const test::Truth truth =
      test::run_truth(model.machine, model, 60.0, 5, 10 * 3600.0, {mesh::parse_pose(model.machine, "", "test")});
  const Measurement measurement = measured(model, truth, {""});
  EvaluateOptions options;
  options.models = {"static_regression"};
  const Eigen::VectorXd time = measurement.time();
  options.train_until_s = time[2] - time[0];  // two rows before it
  EXPECT_THROW(evaluate(measurement, nullptr, options), core::InputError);
  options.train_until_s = time[3] - time[0];
  EXPECT_NO_THROW(evaluate(measurement, nullptr, options));
}

TEST(Evaluate, AReducedModelIsJudgedOnAWithheldChannelOfTrainingFolders) {
  const reduction::ReducedModel model = test::lumped_model();
  const test::Truth truth =
      test::run_truth(model.machine, model, 60.0, 5, 10 * 3600.0, {mesh::parse_pose(model.machine, "", "test")});
  const Measurement measurement = measured(model, truth, {""});
  Measurement training = measurement;
  training.folder = "training";
  EvaluateOptions options;
  options.models = {"static_regression"};
  options.check = {"dz@1"};
  const Evaluation evaluation = evaluate(measurement, &model, options, {}, {training});
  for (const Standing& standing : evaluation.leaderboard) {
    if (standing.model == "reduced_model") {
      EXPECT_EQ(standing.predicted_percent, 100.0);
      EXPECT_GT(standing.reduction_percent, 95.0);
    }
  }
}

TEST(Evaluate, AnExtendedModelIsJudgedBesideTheNominalOne) {
  const reduction::ReducedModel nominal = test::lumped_model();
  reduction::ReducedModel right = nominal;
  right.machine.sources.front().scale.value *= 1.6;
  const std::vector<std::string> texts{"", "X=200,Z=100,B=45,C=90"};
  std::vector<mesh::Pose> poses;
  for (const std::string& text : texts) poses.push_back(mesh::parse_pose(nominal.machine, text, "test"));
  const Measurement measurement =
      measured(nominal, test::run_truth(right.machine, right, 60.0, 5, 10 * 3600.0, poses), texts);
  const Evaluation evaluation = evaluate(measurement, &nominal,
                                         {.train_until_s = 5 * 3600.0,
                                          .train_programs = {},
                                          .models = {"static_regression"},
                                          .check = {},
                                          .extended = &right});
  for (const char* channel : {"dz@1", "dz@2"}) {
    const double as_stated = row_of(evaluation, "reduced_model", channel, "day 0").measures.rms,
                 extended = row_of(evaluation, "extended_model", channel, "day 0").measures.rms;
    EXPECT_LT(extended, 0.1 * as_stated) << channel;
    EXPECT_GT(row_of(evaluation, "extended_model_sensors", channel, "day 0").measures.fit, 97.0) << channel;
  }
}

TEST(Evaluate, AnEmptyComparisonIsRefused) {
  Measurement measurement;
  measurement.data.columns = {"time_s"};
  measurement.data.values = Eigen::MatrixXd::Zero(1, 1);
  expect_input_error([&] { evaluate(measurement, nullptr, {}); }, {"displacement"});
}

}  // namespace
}  // namespace thermotwin::compensation
