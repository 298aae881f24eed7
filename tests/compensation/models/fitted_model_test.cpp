// SPDX-License-Identifier: GPL-3.0-or-later
// What every model must do, and what carries one over the workspace.
#include "compensation/models/fitted_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <limits>

#include "compensation/measurement/measures.h"
#include "compensation/models/catalogue.h"
#include "compensation/models/workspace_weights.h"
#include "core/error.h"
#include "tests/compensation/records.h"
#include "tests/compensation/scratch.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::expect_input_error;

const std::vector<std::string> poses = {"X=-400,Z=0",   "X=400,Z=0",   "X=0,Z=275",
                                        "X=-400,Z=550", "X=400,Z=550", "X=200,Z=100"};

/// How much pose j moves for what the middle moves: linear over X and Z.
double ratio(const std::string& pose) {
  std::map<std::string, double> at = pose_of_text(pose);
  return 1.0 + 0.0003 * at["X"] - 0.0004 * (at["Z"] - 275.0);
}

/// Twenty hours of a spindle that warms a housing (fast) and a column (slow), all seen by sensors
/// with noise; dz at six poses.
Dataset spindle_record(double dc_factor = 1.0) {
  constexpr Index n = 1200;
  Dataset data;
  data.source = "spindle_record";
  data.time = VectorXd::LinSpaced(n, 0.0, 60.0 * (n - 1));
  data.inputs = {{"speed", false, true, false, true},
                 {"housing", true, false, false},
                 {"column", true, false, false},
                 {"air", true, false, true}};
  data.input_values.resize(n, 4);
  test::Uniform uniform(7);
  double housing = 0.0, column = 0.0;
  std::vector<double> drift;
  for (Index i = 0; i < n; ++i) {
    const double hour = data.time[i] / 3600.0;
    const double speed = std::fmod(hour, 5.0) < 3.0 ? (hour < 10.0 ? 4000.0 : 8000.0) : 0.0;
    const double air = 20.0 + 0.8 * std::sin(hour / 3.0);
    housing += (0.002 * speed - housing) * (1.0 - std::exp(-60.0 / 2400.0));
    column += (0.3 * housing - column) * (1.0 - std::exp(-60.0 / 14400.0));
    data.input_values.row(i) << speed, air + housing + 0.02 * uniform.normal(), air + column + 0.02 * uniform.normal(),
        air;
    drift.push_back(dc_factor * (3.0 * housing + 8.0 * column));
  }
  data.target_values.resize(n, std::ssize(poses));
  for (std::size_t p = 0; p < poses.size(); ++p) {
    MeasuredChannel channel;
    channel.id = "dz@" + std::to_string(p + 1);
    channel.kind = ChannelKind::displacement;
    channel.quantity = "dz";
    channel.unit = "um";
    channel.pose_text = poses[p];
    channel.zero = Zero::first;
    data.targets.push_back(channel);
    for (Index i = 0; i < n; ++i) data.target_values(i, p) = ratio(poses[p]) * drift[i] + 0.1 * uniform.normal();
  }
  return data;
}

std::vector<bool> first_rows(const Dataset& data, Index rows) {
  std::vector<bool> training(data.rows(), false);
  std::fill(training.begin(), training.begin() + rows, true);
  return training;
}

/// RMS of the residual over that of the displacement in the rows after the training.
double left_over(const FittedModel& model, const Dataset& data, Index target, Index from) {
  const VectorXd predicted = model.predict(data).col(target);
  const Measures m =
      measure(data.target_values.col(target).tail(data.rows() - from), predicted.tail(data.rows() - from));
  return m.count > 0 ? m.rms / m.rms_before : std::numeric_limits<double>::infinity();
}

class EveryModel : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Zoo, EveryModel, testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const ModelSpec& spec : model_specs()) {
                             // The unit of rotary axes and the three modules have tests of their own: this record has
                             // neither a C axis nor programs with the machine off.
                             const bool has_modules = spec.name.starts_with("composite_modules");
                             if (spec.spatial != Spatial::together && !has_modules) names.push_back(spec.name);
                           }
                           return names;
                         }()),
                         [](const auto& of) { return of.param; });

TEST_P(EveryModel, PredictsRowsThatItDidNotSee) {
  const Dataset data = spindle_record();
  FittedModel model(model_spec(GetParam()));
  model.fit(data, first_rows(data, 800), {});
  ASSERT_FALSE(model.empty()) << (model.left_out().empty() ? "" : model.left_out().front());
  const double left = left_over(model, data, 2, 800);
  std::printf("%s: %.1f %% left\n", GetParam().c_str(), 100 * left);
  // Air is not told apart without its name, so a model of the temperatures has all it needs; speed
  // alone has too, since the machine's law is linear.
  EXPECT_LT(left, 0.2) << model.explain().front();
  EXPECT_FALSE(model.explain().empty());
}

TEST_P(EveryModel, NothingOfWhatComesLaterReachesAPrediction) {
  Dataset data = spindle_record();
  FittedModel model(model_spec(GetParam()));
  model.fit(data, first_rows(data, 500), {});
  const MatrixXd whole = model.predict(data);
  data.input_values.bottomRows(400) *= 1.7;
  data.target_values.bottomRows(700).setConstant(1e6);
  FittedModel again(model_spec(GetParam()));
  again.fit(data, first_rows(data, 500), {});
  const MatrixXd other = again.predict(data);
  EXPECT_EQ(whole.topRows(800), other.topRows(800));
  EXPECT_NE(whole.bottomRows(300), other.bottomRows(300));
}

TEST_P(EveryModel, ComesBackFromItsFile) {
  const Dataset data = spindle_record();
  FittedModel model(model_spec(GetParam()));
  model.fit(data, first_rows(data, 500), {});
  const test::Scratch scratch;
  scratch.write("models.toml", "schema = 1\n" + model.to_toml());
  const std::vector<FittedModel> read = FittedModel::read(scratch.path() / "models.toml");
  ASSERT_EQ(read.size(), 1U);
  EXPECT_EQ(read[0].name(), GetParam());
  const MatrixXd before = model.predict(data), after = read[0].predict(data);
  ASSERT_TRUE(before.col(2).allFinite());
  EXPECT_LT((before - after).col(2).cwiseAbs().maxCoeff(), 1e-9);
}

TEST_P(EveryModel, ASensorThatIsMissingLeavesGapsNotNumbers) {
  Dataset data = spindle_record();
  data.input_values.block(600, 0, 50, 4).setConstant(std::numeric_limits<double>::quiet_NaN());
  data.target_values.block(100, 0, 30, 6).setConstant(std::numeric_limits<double>::quiet_NaN());
  FittedModel model(model_spec(GetParam()));
  model.fit(data, first_rows(data, 500), {});
  const VectorXd predicted = model.predict(data).col(2);
  EXPECT_TRUE(std::isnan(predicted[620]));
  EXPECT_TRUE(std::isfinite(predicted[115]));
  EXPECT_TRUE(std::isfinite(predicted[700]));
}

TEST(ModelFile, MistakesAreNamed) {
  const Dataset data = spindle_record();
  FittedModel model(model_spec("first_order"));
  model.fit(data, first_rows(data, 500), {});
  const std::string good = "schema = 1\n" + model.to_toml();
  const test::Scratch scratch;
  const auto refused = [&](const std::string& from, const std::string& to, std::initializer_list<const char*> words) {
    std::string text = good;
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    scratch.write("models.toml", text.replace(at, from.size(), to));
    expect_input_error([&] { FittedModel::read(scratch.path() / "models.toml"); }, words);
  };
  refused("first_order", "first_ordr", {"first_ordr", "nearest: first_order"});
  refused("gains", "gain", {"models.toml", "gains"});
  refused("gains = [3.0, 1.0", "gains = [2.0, 1.0", {"models.toml", "numbers for 2 x 1"});
  refused("schema = 1\n", "", {"schema"});
}

TEST(WorkspaceWeights, CarryPolynomialsExactly) {
  std::vector<std::string> cube, face_centred, corners;
  for (const int x : {-400, 0, 400}) {
    for (const int y : {-300, 0, 300}) {
      for (const int z : {0, 275, 550}) {
        const std::string pose = "X=" + std::to_string(x) + ",Y=" + std::to_string(y) + ",Z=" + std::to_string(z);
        const int inner = (x == 0) + (y == 0) + (z == 275);
        cube.push_back(pose);
        if (inner == 0) corners.push_back(pose);
        if (inner == 0 || inner == 2) face_centred.push_back(pose);
      }
    }
  }
  const std::string at = "X=130,Y=-210,Z=470";
  const auto carried = [&](const std::vector<std::string>& known, auto function) {
    const VectorXd weights = workspace_weights(known, at);
    double sum = 0.0;
    for (std::size_t i = 0; i < known.size(); ++i) {
      std::map<std::string, double> pose = pose_of_text(known[i]);
      sum += weights[i] * function(pose["X"] / 100, pose["Y"] / 100, pose["Z"] / 100);
    }
    return sum - function(1.3, -2.1, 4.7);
  };
  EXPECT_NEAR(carried(cube, [](double x, double y, double z) { return x * x * y * y * z * z + x * y - 3 * z; }), 0.0,
              1e-9);
  EXPECT_NEAR(carried(face_centred, [](double x, double y, double z) { return x * x - 2 * y * z + z * z + x + 4; }),
              0.0, 1e-9);
  EXPECT_NEAR(carried(corners, [](double x, double y, double z) { return x * y * z + y * z - x + 2; }), 0.0, 1e-9);
  EXPECT_NEAR(
      carried({cube[0], cube[2], cube[6], cube[18]}, [](double x, double y, double z) { return x + 2 * y - z + 5; }),
      0.0, 1e-9);
  EXPECT_NEAR(carried({cube[4]}, [](double, double, double) { return 7.0; }), 0.0, 1e-9);
}

TEST(OnePoint, ItsFactorsAreThoseOfTheMachineAndReachPosesThatNoFitSaw) {
  const Dataset data = spindle_record();
  FittedModel model(model_spec("one_point"));
  model.fit(data, first_rows(data, 800), {"dz@6"});
  // The calibration point is the one in the middle; every other pose follows it by its ratio.
  for (Index p = 0; p < 6; ++p) EXPECT_LT(left_over(model, data, p, 800), 0.12) << p;
  double b = 0.0;
  for (const std::string& line : model.explain()) {
    if (line.starts_with("one_point dz@1: b =")) b = std::stod(line.substr(20));
  }
  EXPECT_NEAR(b, ratio(poses[0]), 0.02);
  // One point for all would be wrong by what the ratio says.
  EXPECT_GT(std::abs(ratio(poses[3]) - 1.0), 0.2);
}

TEST(TransferGrid, PosesBetweenAreInterpolated) {
  const Dataset data = spindle_record();
  FittedModel model(model_spec("transfer_grid"));
  model.fit(data, first_rows(data, 800), {"dz@6"});
  EXPECT_LT(left_over(model, data, 5, 800), 0.12);
  FittedModel plain(model_spec("output_error"));
  plain.fit(data, first_rows(data, 800), {"dz@6"});
  EXPECT_TRUE(std::isnan(plain.predict(data)(900, 5))) << "a channel that no fit may use has no prediction of its own";
}

TEST(GridOfModels, PosesBetweenAreInterpolatedForRegressionAndComposite) {
  const Dataset data = spindle_record();
  for (const auto& [grid, plain] : {std::pair{"static_grid", "static_regression"}, {"composite_grid", "composite"}}) {
    FittedModel over(model_spec(grid)), each(model_spec(plain));
    over.fit(data, first_rows(data, 800), {"dz@6"});
    each.fit(data, first_rows(data, 800), {});
    // Where it was fitted it is the model of that pose; between, the mean of the poses would be off by a tenth.
    EXPECT_NEAR(left_over(over, data, 1, 800), left_over(each, data, 1, 800), 1e-12) << grid;
    EXPECT_LT(left_over(over, data, 5, 800), 0.05) << grid;
  }
}

TEST(Correction, OneFactorCarriesAModelToAnotherMachineOfTheType) {
  const Dataset first = spindle_record(), second = spindle_record(0.7);
  FittedModel model(model_spec("arx"));
  model.fit(first, first_rows(first, 800), {});
  const double as_is = left_over(model, second, 2, 200);
  const std::string words = model.correct(second, first_rows(second, 200));
  EXPECT_NE(words.find("dz@3 x 0.7"), std::string::npos) << words;
  EXPECT_GT(as_is, 0.35);
  EXPECT_LT(left_over(model, second, 2, 200), 0.12);
}

}  // namespace
}  // namespace thermotwin::compensation
