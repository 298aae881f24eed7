// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/response.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.h"
#include "core/thread_pool.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/offered_causes.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/inference/hypothesis_fit.h"
#include "diagnosis/response/problem.h"
#include "mesh/machine/kinematics.h"
#include "solver/operation/layout.h"
#include "tests/machines/rods_record.h"

namespace {

using namespace thermotwin;
using diagnosis::Kind;
using diagnosis::Observations;
using diagnosis::Parameter;
using diagnosis::Response;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Of a central difference; that of a late clock depends on it, since straight lines have corners.
double p_step(const Parameter& p) { return diagnosis::acts_on_readings(p.kind) ? p.step : p.step > 0.5 ? 0.1 : 1e-3; }

Observations observe(const compensation::Measurement& m, double interval = 600) {
  const mesh::Machine machine = lumped::machine();
  return diagnosis::observe(m, machine, solver::Channels(machine), {.interval_s = interval});
}

TEST(Response, FollowsTheStepperOfTheReducedModel) {
  const mesh::Machine machine = lumped::machine();
  const reduction::ReducedModel model = lumped::model(machine, 4);
  const compensation::Measurement measurement = lumped::measure({}, {.hours = 12, .noise_K = 0, .noise_um = 0});
  const Observations obs = observe(measurement);
  const Eigen::MatrixXd predicted = Response(model, obs).at_points(machine);

  reduction::ReducedStepper stepper(model.system);
  const solver::OperatingModel operating(machine, model.system.layout);
  VectorXd state = stepper.uniform(obs.start_C - machine.reference_C);
  VectorXd offsets = VectorXd::Zero(6);
  offsets[2] = 0.1;
  std::optional<solver::Chiller> chiller;
  for (Index s = 0; s < obs.rows.rows(); ++s) {
    const VectorXd row = obs.rows.row(s).transpose();
    const VectorXd read = model.system.sensors * state + offsets;
    if (!chiller) {
      chiller.emplace(machine, operating.layout(), operating.channels(),
                      solver::chiller_set_points(machine, operating.layout(), read, operating.guide_K(row)));
    }
    const double step = obs.points[s + 1] - obs.points[s];
    stepper.advance(state, operating.coefficients(row, chiller->advance(row, read, operating.guide_K(row), step)),
                    step);
  }
  const Index last = predicted.rows() - 1;
  const VectorXd sensors = (model.system.sensors * state + offsets).array() + machine.reference_C;
  EXPECT_LT((predicted.row(last).head(6).transpose() - sensors).cwiseAbs().maxCoeff(), 1e-7);
  const mesh::Pose low = mesh::parse_pose(machine, "Z=50", "test");
  EXPECT_NEAR(predicted(last, 7), 1e6 * model.tcp(state, low).error[2], 1e-5);
}

TEST(Response, PredictsItsOwnKindOfMachine) {
  // Same network, other steps: only the time scheme and the straight lines between steps differ.
  const compensation::Measurement measurement =
      lumped::measure({}, {.cells = 5, .model_step = 20, .hours = 24, .noise_K = 0, .noise_um = 0});
  const reduction::ReducedModel model = lumped::model(lumped::machine(), 5);
  const Observations obs = observe(measurement);
  const VectorXd difference = obs.stacked() - Response(model, obs).predict(lumped::machine());
  Index row = 0;
  for (const auto& channel : obs.channels) {
    EXPECT_LT(difference.segment(row, channel.size()).cwiseAbs().maxCoeff(), channel.is_temperature() ? 0.06 : 0.6)
        << channel.channel.id;
    row += channel.size();
  }
}

TEST(Response, TangentsEqualCentralDifferences) {
  const mesh::Machine machine = lumped::machine();
  const reduction::ReducedModel model = lumped::model(machine, 4);
  const compensation::Measurement measurement = lumped::measure({}, {.hours = 10});
  const Observations obs = observe(measurement);
  const Response response(model, obs);
  const auto parameters = diagnosis::candidate_parameters(machine, measurement);
  VectorXd values(std::ssize(parameters));
  for (Index i = 0; i < values.size(); ++i) {
    const Parameter& p = parameters[i];
    // Not at nominal; readings beside their bounds and where no clock hides another.
    values[i] = p.ratio                                                        ? 1.1
                : p.kind == Kind::sensor_lag                                   ? 400.0
                : p.kind == Kind::sensor_detached                              ? 0.2
                : p.kind == Kind::sensor_offset || p.kind == Kind::clock_shift ? 0.0
                                                                               : 0.3;
  }
  const auto linear = response.linearise(machine, parameters, values, true);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const Index at = i;
    const double h = p_step(parameters[i]);
    VectorXd up = values, down = values;
    up[at] += h;
    down[at] -= h;
    const VectorXd central = (response.predict(diagnosis::with_parameters(machine, parameters, up)) -
                              response.predict(diagnosis::with_parameters(machine, parameters, down))) /
                             (2 * h);
    const double size = central.norm() + 1e-3;
    EXPECT_LT((linear.sensitivity.col(at) - central).norm(), 3e-3 * size) << name_of(parameters[i]);
  }
}

/// Columns of one rod only.
reduction::ReducedOutputs only(const reduction::ReducedOutputs& all, Index first, Index count) {
  reduction::ReducedOutputs part = all;
  for (auto* rows : {&part.tool, &part.table_axis, &part.table_own}) {
    for (Eigen::MatrixXd& matrix : *rows) {
      const Eigen::MatrixXd kept = matrix.middleCols(first, count);
      matrix.setZero();
      matrix.middleCols(first, count) = kept;
    }
  }
  return part;
}

reduction::Parts parts_of(const reduction::ReducedModel& model, Index cells) {
  reduction::Parts parts;
  const Index size = model.system.order();
  for (Index rod = 0; rod < 3; ++rod) {
    parts.capacity.push_back(Eigen::MatrixXd::Zero(size, size));
    parts.capacity.back().block(rod * cells, rod * cells, cells, cells) =
        model.system.capacity.block(rod * cells, rod * cells, cells, cells);
    parts.bodies.push_back(only(model.outputs, rod * cells, cells));
  }
  parts.stiffness_exponent.setZero(std::ssize(model.machine.joints));
  return parts;
}

TEST(Response, PartsChangeAsAModelOfOtherMaterials) {
  const mesh::Machine machine = lumped::machine();
  reduction::ReducedModel model = lumped::model(machine, 4);
  model.parts = parts_of(model, 4);
  const reduction::Parts& parts = *model.parts;
  const Observations obs = observe(lumped::measure({}, {.hours = 10}));
  const Response response(model, obs);
  const Parameter heat = diagnosis::make_parameter(Kind::heat_capacity, "column"),
                  growth = diagnosis::make_parameter(Kind::expansion_coefficient, "head");
  VectorXd values(2);
  values << 1.3, 1.2;
  reduction::ReducedModel other = model;
  other.system.capacity += 0.3 * parts.capacity[1];
  for (std::size_t p = 0; p < other.outputs.tool.size(); ++p) other.outputs.tool[p] += 0.2 * parts.bodies[2].tool[p];
  const VectorXd predicted = response.predict(diagnosis::with_parameters(machine, {heat, growth}, values));
  EXPECT_LT((predicted - Response(other, obs).predict(machine)).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_GT((predicted - response.predict(machine)).cwiseAbs().maxCoeff(), 0.1);

  const auto linear = response.linearise(machine, {heat, growth}, values, false);
  for (Index i = 0; i < 2; ++i) {
    VectorXd up = values, down = values;
    up[i] += 1e-3;
    down[i] -= 1e-3;
    const VectorXd central = (response.predict(diagnosis::with_parameters(machine, {heat, growth}, up)) -
                              response.predict(diagnosis::with_parameters(machine, {heat, growth}, down))) /
                             2e-3;
    EXPECT_LT((linear.sensitivity.col(i) - central).norm(), 3e-3 * central.norm()) << i;
  }
}

TEST(Response, HeatThatEntersSpreadIsThatOfAModelWithOtherInputs) {
  const mesh::Machine machine = lumped::machine();
  const reduction::ReducedModel model = lumped::model(machine, 9);
  const Observations obs = observe(lumped::measure({}, {.hours = 8}));
  const Response response(model, obs);
  const Eigen::MatrixXd spread = response.spread_heat();
  reduction::ReducedModel other = model;
  int sources = 0;
  for (std::size_t k = 0; k < model.system.layout.inputs.size(); ++k) {
    if (model.system.layout.inputs[k].kind != solver::InputKind::source) continue;
    const Index at = k;
    other.system.inputs.col(at) = spread * model.system.inputs.col(at);
    // As much heat, in other places.
    EXPECT_NEAR(model.system.one_kelvin.dot(other.system.inputs.col(at)),
                model.system.one_kelvin.dot(model.system.inputs.col(at)), 1e-9);
    EXPECT_GT((other.system.inputs.col(at) - model.system.inputs.col(at)).norm(),
              0.1 * model.system.inputs.col(at).norm());
    ++sources;
  }
  ASSERT_GT(sources, 0);
  const std::vector<Parameter> parameters{diagnosis::make_parameter(Kind::source_power, machine.sources[0].id),
                                          diagnosis::make_parameter(Kind::contact_conductance, machine.joints[0].id)};
  const VectorXd nominal = VectorXd::Ones(2);
  const auto linear = response.linearise(machine, parameters, nominal, false, {}, true);
  const Eigen::MatrixXd there = Response(other, obs).linearise(machine, parameters, nominal, false).sensitivity;
  // Free convection is linearised about another state there.
  EXPECT_LT((there.col(0) - linear.sensitivity.col(0) - linear.spread.col(0)).norm(),
            1e-3 * linear.sensitivity.col(0).norm());
  EXPECT_GT(linear.spread.col(0).norm(), 1e-2 * linear.sensitivity.col(0).norm());
  EXPECT_EQ(linear.spread.col(1).norm(), 0.0);
}

TEST(Response, StartTangentEqualsAnotherStart) {
  const mesh::Machine machine = lumped::machine();
  const reduction::ReducedModel model = lumped::model(machine, 4);
  Observations obs = observe(lumped::measure({}, {.hours = 10}));
  const auto linear = Response(model, obs).linearise(machine, {}, VectorXd(), true);
  Observations warmer = obs;
  warmer.start_C += 0.5;
  const VectorXd change = (Response(model, warmer).predict(machine) - linear.predicted) / 0.5;
  ASSERT_EQ(linear.start.cols(), 1);
  EXPECT_LT((linear.start.col(0) - change).norm(), 1e-6 * change.norm());
  // Where the first readings differ, the machine may begin warmed by its slow modes: of 1 K each, the slowest first.
  obs.start_spread_K = 1.0;
  const Response response(model, obs);
  const Eigen::MatrixXd modes = response.start_modes(machine);
  ASSERT_GT(modes.cols(), 1);
  const auto warm = response.linearise(machine, {}, VectorXd(), true);
  EXPECT_EQ(warm.start.cols(), 1 + modes.cols() + std::ssize(obs.before));
  EXPECT_EQ(warm.start_std.size(), warm.start.cols());
  EXPECT_NEAR(warm.start_std[modes.cols()], std::hypot(0.2, 1.0), 1e-9);
  EXPECT_NEAR(warm.start_std.tail(1)[0], std::sqrt(1.0 / 3.0), 1e-9) << "of a share of what may have run";
  const Eigen::MatrixXd gram = modes.transpose() * model.system.capacity * modes;
  const double of_one_kelvin = model.system.one_kelvin.dot(model.system.capacity * model.system.one_kelvin);
  EXPECT_LT((gram / of_one_kelvin - Eigen::MatrixXd::Identity(modes.cols(), modes.cols())).norm(), 1e-9);
}

TEST(Response, DisturbedSurroundingsEqualChangedInputs) {
  const mesh::Machine machine = lumped::machine();
  const reduction::ReducedModel model = lumped::model(machine, 4);
  const Observations obs = observe(lumped::measure({}, {.hours = 10}));
  const solver::Channels channels(machine);
  for (const int ambient : {0, 1}) {
    const diagnosis::Disturbance hat{ambient, 2 * 3600.0, 4 * 3600.0, 5 * 3600.0, 1.0};
    const auto linear = Response(model, obs).linearise(machine, {}, VectorXd(), false, {hat});
    Observations changed = obs;
    for (Index s = 0; s < obs.rows.rows(); ++s) {
      const double hours = 0.5 * (obs.points[s] + obs.points[s + 1]) / 3600.0;
      const double height = hours < 4 ? std::max(0.0, (hours - 2) / 2) : std::max(0.0, 5 - hours);
      const double air = obs.rows(s, channels.index("air.T_C"));
      // The foundation follows the air; once it has a temperature of its own it no longer does.
      if (ambient == 0) changed.rows(s, channels.index("air.T_C")) = air + height;
      if (ambient == 1) changed.rows(s, channels.index("foundation.T_C")) = air - 0.5 + height;
    }
    const VectorXd difference = Response(model, changed).predict(machine) - linear.predicted;
    ASSERT_GT(difference.norm(), 0.1);
    EXPECT_LT((linear.disturbed.col(0) - difference).norm(), 1e-6 * difference.norm()) << "ambient " << ambient;
  }
}

TEST(Problem, ALinearFormElsewhereIsExactThere) {
  const reduction::ReducedModel model = lumped::model(lumped::machine(), 9);
  const compensation::Measurement measured = lumped::measure({}, {.hours = 8, .seed = 3});
  const Observations obs = observe(measured);
  const diagnosis::Response response(model, obs);
  const diagnosis::Problem nominal = diagnosis::make_problem(model.machine, measured, obs, response, {});
  const auto index = [&](Kind kind, const std::string& where) {
    for (std::size_t i = 0; i < nominal.parameters.size(); ++i)
      if (nominal.parameters[i].kind == kind && nominal.parameters[i].where == where) return static_cast<int>(i);
    throw std::logic_error("no " + name_of(kind) + " of " + where);
  };
  const int motor = index(Kind::source_power, "motor"), film = index(Kind::film_coefficient, "column.film");
  VectorXd around = VectorXd::Zero(nominal.nominal.size());
  around[motor] = 0.2;
  around[film] = -0.3;
  const diagnosis::Problem there = diagnosis::make_problem(model.machine, measured, obs, response, {}, around);
  const mesh::Machine changed = there.machine_around(model.machine, {});
  const VectorXd exact = response.predict(changed);
  const double moved = (exact - nominal.predicted).norm();
  EXPECT_LT((there.predicted + there.moved_around({}) - exact).norm(), 1e-9 * exact.norm());
  EXPECT_GT((nominal.predicted + nominal.columns.leftCols(around.size()) * around - exact).norm(), 0.002 * moved)
      << "it is not linear";
  // A hypothesis is fitted with all others where they are, and told with these at nominal.
  diagnosis::Hypothesis hypothesis;
  hypothesis.members = {motor};
  hypothesis.value = VectorXd::Constant(1, 1.2);
  const diagnosis::White white(there);
  diagnosis::refine(hypothesis, there, response, model.machine, white, 0.0, 3, 1.0);
  const mesh::Machine fitted = diagnosis::with_parameters(there.machine_around(model.machine, {motor}),
                                                          {there.parameters[motor]}, hypothesis.value);
  EXPECT_LT((hypothesis.predicted + there.moved_around({motor}) - response.predict(fitted)).norm(),
            1e-9 * exact.norm());
}

/// A machine that is symmetric in a direction hardly moves in it, but its mesh turns a share of the whole motion there.
TEST(Problem, AMeshErrsLittleBeforeAnythingMoves) {
  const compensation::Measurement measured = lumped::measure({}, {.hours = 8, .seed = 3});
  diagnosis::DiagnoseOptions how;
  how.temperature_error_percent = 10;
  const reduction::ReducedModel model = lumped::model(lumped::machine(), 9);
  const Observations obs = observe(measured);
  const diagnosis::Response response(model, obs);
  const diagnosis::Problem problem = diagnosis::make_problem(model.machine, measured, obs, response, how);
  const auto motor = std::find_if(obs.channels.begin(), obs.channels.end(),
                                  [](const auto& c) { return c.is_temperature() && c.value.maxCoeff() > 24; });
  ASSERT_NE(motor, obs.channels.end());
  const diagnosis::ChannelCovariance& error = problem.covariance[motor - obs.channels.begin()];
  const auto of_mesh = std::find_if(error.wander.begin(), error.wander.end(),
                                    [](const auto& term) { return term.course.size() > 0 && term.std > 0.0; });
  ASSERT_NE(of_mesh, error.wander.end());
  EXPECT_LT(of_mesh->course[0], 0.5);
  EXPECT_EQ(of_mesh->course.tail(1)[0], 1.0);
}

TEST(Problem, AMeshErrsInADirectionByAShareOfTheWholeMotion) {
  reduction::ReducedModel model = lumped::model(lumped::machine(), 9);
  model.mesh_error = reduction::MeshError{VectorXd::Constant(std::ssize(model.machine.sensors), 0.02),
                                          VectorXd::Constant(6, 0.02), "made up"};
  const compensation::Measurement measured = lumped::measure({}, {.hours = 8, .seed = 3});
  const Observations obs = observe(measured);
  const diagnosis::Response response(model, obs);
  const diagnosis::Problem problem = diagnosis::make_problem(model.machine, measured, obs, response, {});
  int beside = 0;
  for (std::size_t k = 0; k < obs.channels.size(); ++k) {
    const diagnosis::ObservedChannel& channel = obs.channels[k];
    if (channel.is_temperature()) continue;
    double squares = 0.0, own = 0.0;
    for (std::size_t other = 0; other < obs.channels.size(); ++other) {
      if (obs.channels[other].is_temperature() || obs.channels[other].channel.unit != channel.channel.unit ||
          obs.channels[other].channel.pose_text != channel.channel.pose_text)
        continue;
      const VectorXd at = problem.predicted.segment(problem.first_row(other), obs.channels[other].size());
      const double square = (at.array() - at[0]).square().mean();
      squares += square;
      if (other == k) own = square;
    }
    beside += own < 0.5 * squares ? 1 : 0;
    const std::vector<diagnosis::OrnsteinUhlenbeck>& wander = problem.covariance[k].wander;
    const double slowest = std::max_element(wander.begin(), wander.begin() + 4, [](const auto& a, const auto& b) {
                             return a.std < b.std;
                           })->std;
    EXPECT_GT(slowest, 0.99 * 0.02 * std::sqrt(squares)) << channel.channel.id;
  }
  EXPECT_GT(beside, 0) << "no channel moves less than the others at its pose";
}

TEST(Response, IsBitwiseTheSameForAnyThreads) {
  const mesh::Machine machine = lumped::machine();
  const reduction::ReducedModel model = lumped::model(machine, 4);
  const compensation::Measurement measurement = lumped::measure({}, {.hours = 5});
  const Observations obs = observe(measurement);
  const Response response(model, obs);
  const auto parameters = diagnosis::candidate_parameters(machine, measurement);
  VectorXd values(std::ssize(parameters));
  for (Index i = 0; i < values.size(); ++i) values[i] = parameters[i].nominal;
  core::set_thread_count(1);
  const auto one = response.linearise(machine, parameters, values, true);
  core::set_thread_count(3);
  const auto three = response.linearise(machine, parameters, values, true);
  core::set_thread_count(0);
  EXPECT_EQ(one.sensitivity, three.sensitivity);
  EXPECT_EQ(one.predicted, three.predicted);
}

TEST(Observations, GapsAndOtherSamplingChangeNoMean) {
  compensation::Measurement m = lumped::measure({}, {.hours = 6, .noise_K = 0, .noise_um = 0});
  const Observations full = observe(m);
  // Every second row lost in one channel, an hour lost in another.
  for (Index i = 0; i < m.data.rows(); i += 2) m.data.values(i, 1) = std::nan("");
  for (Index i = 0; i < m.data.rows(); ++i)
    if (m.data.values(i, 0) > 7200 && m.data.values(i, 0) <= 10800) m.data.values(i, 2) = std::nan("");
  const Observations holes = observe(m);
  EXPECT_EQ(holes.channels[0].size(), full.channels[0].size());
  EXPECT_LT(holes.channels[1].size(), full.channels[1].size());
  const reduction::ReducedModel model = lumped::model(lumped::machine(), 5);
  const VectorXd a = full.stacked() - Response(model, full).predict(lumped::machine());
  const VectorXd b = holes.stacked() - Response(model, holes).predict(lumped::machine());
  // Measured and predicted means are taken at the same samples, so residuals hardly change.
  EXPECT_LT((a.head(full.channels[0].size()) - b.head(full.channels[0].size())).cwiseAbs().maxCoeff(), 0.01);
}

/// (8492.005 - 692.005) / 600 rounds to below 13, but 692.005 + 13 * 600 is not above it.
TEST(Observations, AStartWithDecimalsEnds) {
  compensation::Measurement m = lumped::measure({}, {.hours = 23});
  ASSERT_GE(m.data.rows(), 660);
  for (Index i = 0; i < m.data.rows(); ++i) m.data.values(i, 0) = 692.005 + 60.0 * i;
  const Observations seen = observe(m);
  double samples = 0;
  for (const auto& channel : seen.channels)
    if (channel.is_temperature()) samples = std::max(samples, channel.samples.sum());
  EXPECT_EQ(samples, m.data.rows());
}

TEST(Observations, NoMeanReachesOverTheSplit) {
  const compensation::Measurement m = lumped::measure({}, {.hours = 6});
  for (const double share : {0.05, 0.17, 0.3, 0.86}) {
    const mesh::Machine machine = lumped::machine();
    const Observations seen = diagnosis::observe(m, machine, solver::Channels(machine), {.heldout_share = share});
    EXPECT_EQ(seen.split, diagnosis::split_between(seen, share));
    const double intervals = (seen.split - seen.start) / seen.interval;
    EXPECT_NEAR(intervals, std::round(intervals), 1e-9);
    EXPECT_GE(intervals, 4.0 - 1e-9) << "enough to be fitted";
    EXPECT_GE(seen.end - seen.split, share * (seen.end - seen.start) * (share < 0.8 ? 1.0 : 0.5));
    for (const auto& channel : seen.channels) EXPECT_LT(channel.interval[channel.fitted - 1], std::lround(intervals));
  }
}

compensation::Measurement without_rows(compensation::Measurement m, const std::vector<double>& times) {
  std::vector<Index> kept;
  for (Index i = 0; i < m.data.rows(); ++i) {
    if (std::none_of(times.begin(), times.end(), [&](double t) { return std::abs(m.data.values(i, 0) - t) < 1.0; }))
      kept.push_back(i);
  }
  m.data.values = MatrixXd(m.data.values(kept, Eigen::all));
  return m;
}

TEST(Observations, AChangeInAGapIsHalfWayAndUncertain) {
  // Speeds change at 3 h; of rows every minute the one there is lost, and four where nothing changes.
  const compensation::Measurement whole =
                                      lumped::measure({}, {.hours = 8, .sample_s = 60, .noise_K = 0, .noise_um = 0}),
                                  holed = without_rows(whole, {3 * 3600, 3600, 3660, 6000, 9000});
  const mesh::Machine machine = lumped::machine();
  const solver::Channels channels(machine);
  const Observations all = observe(whole), obs = observe(holed);
  EXPECT_TRUE(all.may_hold.empty());
  const double change = 3 * 3600, early = obs.may_hold.at(0).from;
  ASSERT_EQ(obs.may_hold.size(), 2U);
  EXPECT_NEAR(early, change, 1e-9);
  EXPECT_NEAR(obs.may_hold[0].to, change + 30, 1e-9);
  EXPECT_NEAR(obs.may_hold[1].from, change + 30, 1e-9);
  EXPECT_NEAR(obs.may_hold[1].to, change + 60, 1e-9);
  EXPECT_LT((obs.points.array() - (change + 30)).abs().minCoeff(), 1e-6);
  const int rpm = channels.index("spindle.speed_rpm");
  EXPECT_NE(obs.may_hold[0].row[rpm], obs.may_hold[1].row[rpm]) << "what comes after, and what was before";
  // A pause is no lost row: what was logged before it holds until the next, or for a part of it.
  std::vector<double> pause;
  for (double t = 3 * 3600 - 1800; t < 3 * 3600 + 1800; t += 60) pause.push_back(t);
  const Observations paused = observe(without_rows(whole, pause));
  ASSERT_GT(paused.may_hold.size(), 1U);
  EXPECT_TRUE(paused.may_hold[1].in_pause) << "or anything else ran";
  EXPECT_TRUE(paused.may_hold[0].earlier && !paused.may_hold[0].in_pause);
  EXPECT_NEAR(paused.may_hold[0].to, 3 * 3600 + 1800, 1e-9);
  EXPECT_NEAR(paused.may_hold[0].from, 3 * 3600 - 1800, 1e-9);
  EXPECT_LT((paused.points.array() - (3 * 3600 + 1800)).abs().minCoeff(), 1e-6);
  // Of slow rows two may be lost, longer than an interval of means; and each change may have come up to a row before it
  // was seen.
  const compensation::Measurement slow =
      lumped::measure({}, {.hours = 8, .sample_s = 300, .noise_K = 0, .noise_um = 0});
  const Observations seen = observe(without_rows(slow, {3 * 3600, 3 * 3600 + 300}));
  ASSERT_GE(seen.may_hold.size(), 2U);
  EXPECT_NEAR(seen.may_hold[0].to - seen.may_hold[0].from, 300.0, 1e-9);
  EXPECT_NEAR(seen.may_hold[0].std, 1 / std::sqrt(6.0), 1e-9);
  const Observations rows = observe(slow);
  ASSERT_FALSE(rows.may_hold.empty());
  for (const Observations::MayHold& may : rows.may_hold) {
    EXPECT_TRUE(may.earlier);
    EXPECT_NEAR(may.to - may.from, 300.0, 1e-9);
    EXPECT_NEAR(may.std, 1 / std::sqrt(3.0), 1e-9);
  }
}

TEST(Observations, AChangeComesWhenItIsSaidTo) {
  const compensation::Measurement m = lumped::measure({}, {.hours = 8, .sample_s = 300, .noise_K = 0, .noise_um = 0});
  const mesh::Machine machine = lumped::machine();
  const double shown = 3 * 3600, came = shown - 210;
  const auto with = [&](double when) {
    return diagnosis::observe(m, machine, solver::Channels(machine), {.changes = {{shown, when}}});
  };
  const Observations obs = with(came);
  EXPECT_LT((obs.points.array() - came).abs().minCoeff(), 1e-6);
  std::vector<Observations::MayHold> whiles;
  for (const Observations::MayHold& may : obs.may_hold)
    if (may.shown == shown) whiles.push_back(may);
  ASSERT_EQ(whiles.size(), 2U);
  EXPECT_TRUE(whiles[0].earlier && !whiles[1].earlier);
  EXPECT_NEAR(whiles[0].from, shown - 300, 1e-9);
  EXPECT_NEAR(whiles[0].to, came, 1e-9);
  EXPECT_NEAR(whiles[1].from, came, 1e-9);
  EXPECT_NEAR(whiles[1].to, shown, 1e-9);
  EXPECT_EQ(obs.told_row_s, 300);
  // Anywhere alike from 90 s before it to 210 s after it: what the two together are off, in the mean square.
  const double a = 90, b = 210, squares = whiles[0].std * whiles[0].std * a * a + whiles[1].std * whiles[1].std * b * b;
  EXPECT_NEAR(squares, (a * a * a + b * b * b) / (3 * (a + b)), 1e-6 * squares);
  EXPECT_EQ(observe(m).may_hold.size() + 1, obs.may_hold.size()) << "the other changes are as the log says";
  // Not before the row before, nor after it is seen.
  int seen = 0;
  for (const Observations::MayHold& may : with(0).may_hold) {
    if (may.shown == shown) {
      EXPECT_NEAR(may.earlier ? may.to : may.from, shown - 294, 1e-6);
      ++seen;
    }
  }
  EXPECT_EQ(seen, 2);
  EXPECT_EQ(with(1e9).may_hold.size(), observe(m).may_hold.size());
}

TEST(Observations, WhatTheLastRowSaysHoldsForNothing) {
  // Speeds change at 6 h, which is the last row, behind one that is lost: all of the record has its step.
  const compensation::Measurement m =
      without_rows(lumped::measure({}, {.hours = 6, .sample_s = 300}), {6 * 3600 - 300});
  const Observations obs = observe(m);
  EXPECT_EQ(obs.points[obs.points.size() - 1], obs.end);
  for (const auto& channel : obs.channels) {
    VectorXd sums = VectorXd::Zero(channel.size());
    for (const auto& weight : channel.weights) sums[weight.row] += weight.value;
    EXPECT_NEAR(sums.maxCoeff(), channel.is_temperature() ? 1.0 : 0.0, 1e-9) << channel.channel.id;
  }
}

TEST(Observations, MoreChangesThanHaveTimesLeaveTheClocksInDoubt) {
  compensation::Measurement m = lumped::measure({}, {.hours = 12, .sample_s = 300});
  const auto rpm =
      std::find_if(m.channels.begin(), m.channels.end(), [](const auto& c) { return c.input == "spindle.speed_rpm"; });
  EXPECT_EQ(observe(m).told_row_s, 300);
  for (Index i = 0; i < m.data.rows(); ++i) m.data.values(i, rpm->column) = i / 4 % 2 ? 6000 : 0;
  const Observations obs = observe(m);
  EXPECT_EQ(obs.may_hold.size(), 24U);
  EXPECT_EQ(obs.told_row_s, 0);
  EXPECT_EQ(observe(lumped::measure({}, {.hours = 12, .sample_s = 60})).told_row_s, 0) << "rows that say when";
}

TEST(Observations, WhatMayHaveChangedElsewhereEndsAStep) {
  // Steps of two rows of 150 s, a speed that changes with each: too often to be a switch.
  compensation::Measurement m = lumped::measure({}, {.hours = 12, .sample_s = 150});
  const auto rpm =
      std::find_if(m.channels.begin(), m.channels.end(), [](const auto& c) { return c.input == "spindle.speed_rpm"; });
  for (Index i = 0; i < m.data.rows(); ++i) m.data.values(i, rpm->column) = i % 2 ? 6000 : 0;
  const Observations obs = observe(m);
  ASSERT_EQ(obs.may_hold.size(), 24U);
  for (const Observations::MayHold& may : obs.may_hold)
    EXPECT_LT((obs.points.array() - may.to).abs().minCoeff(), 1e-6) << may.to;
}

TEST(Response, InputsThatHoldEarlierAreWhatAnEarlierChangeDoes) {
  // The change at 3 h, logged a row of 300 s late: what may have been is among the nuisances.
  const mesh::Machine machine = lumped::machine();
  const reduction::ReducedModel model = lumped::model(machine, 9);
  const compensation::Measurement m = lumped::measure({}, {.hours = 8, .sample_s = 300, .noise_K = 0, .noise_um = 0});
  compensation::Measurement late = m;
  Index row = 0;
  while (m.data.values(row, 0) < 3 * 3600 - 1) ++row;
  for (const auto& channel : m.channels) {
    if (!channel.input.empty() && channel.kind != compensation::ChannelKind::temperature)
      late.data.values(row, channel.column) = m.data.values(row - 1, channel.column);
  }
  const Observations right = observe(m), wrong = observe(late);
  const auto may = std::find_if(wrong.may_hold.begin(), wrong.may_hold.end(),
                                [](const auto& h) { return std::abs(h.from - 3 * 3600) < 1; });
  ASSERT_NE(may, wrong.may_hold.end());
  const Response response(model, wrong);
  const diagnosis::Problem problem = diagnosis::make_problem(machine, late, wrong, response, {});
  const auto held = std::ssize(wrong.may_hold);
  const VectorXd column = problem.columns.rightCols(held).col(may - wrong.may_hold.begin()),
                 truth = Response(model, right).predict(machine) - problem.predicted;
  EXPECT_GT(truth.cwiseAbs().maxCoeff(), 0.05);
  EXPECT_LT((column - truth).norm(), 0.03 * truth.norm());
  EXPECT_NEAR(problem.prior_std.tail(held)[may - wrong.may_hold.begin()], 0.577, 1e-3);
}

/// The pump of the coolant starts in the row. @param row  of the first row with a running pump
compensation::Measurement with_pump(compensation::Measurement m, Index row) {
  const mesh::Machine machine = lumped::machine();
  compensation::MeasuredChannel pump;
  pump.id = pump.input = "coolant." + machine.coolants.front().id + ".on";
  pump.kind = compensation::ChannelKind::state;
  pump.unit = "1";
  pump.column = std::ssize(m.data.columns);
  m.channels.push_back(pump);
  m.data.columns.push_back(pump.id);
  m.data.values.conservativeResize(Eigen::NoChange, pump.column + 1);
  m.data.values.col(pump.column).setOnes();
  m.data.values.col(pump.column).head(row).setZero();
  return m;
}

// Fluid that stands is as warm as the wall. A tangent would carry off heat at that temperature all the while.
TEST(Response, APumpThatRunsEarlierIsComputedExactly) {
  const mesh::Machine machine = lumped::machine();
  const reduction::ReducedModel model = lumped::model(machine, 9);
  const compensation::Measurement m = lumped::measure({}, {.hours = 8, .sample_s = 300, .noise_K = 0, .noise_um = 0});
  Index row = 0;
  while (m.data.values(row, 0) < 5 * 3600 - 1) ++row;
  const Observations right = observe(with_pump(m, row)), wrong = observe(with_pump(m, row + 1));
  const auto may = std::find_if(wrong.may_hold.begin(), wrong.may_hold.end(),
                                [](const auto& h) { return std::abs(h.from - 5 * 3600) < 1; });
  ASSERT_NE(may, wrong.may_hold.end());
  const Response response(model, wrong);
  const diagnosis::Problem problem = diagnosis::make_problem(machine, with_pump(m, row + 1), wrong, response, {});
  const auto held = std::ssize(wrong.may_hold);
  const VectorXd column = problem.columns.rightCols(held).col(may - wrong.may_hold.begin()),
                 truth = Response(model, right).predict(machine) - problem.predicted;
  EXPECT_GT(truth.cwiseAbs().maxCoeff(), 0.1);
  EXPECT_LT((column - truth).norm(), 0.05 * truth.norm());
}

TEST(Observations, NoStepReachesOverASwitch) {
  // Rows each 50 s, which go into steps of 300 s; the spindle is switched 50 s after the last multiple.
  const compensation::Measurement m = lumped::measure({}, {.hours = 8, .sample_s = 50});
  const Observations obs = observe(m);
  const mesh::Machine machine = lumped::machine();
  const int rpm = solver::Channels(machine).index("spindle.speed_rpm");
  for (const auto& [step, parts] : obs.mixed)
    for (const auto& part : parts) EXPECT_EQ(part.row[rpm], parts.front().row[rpm]) << step;
  compensation::Measurement jumping = m;  // what is another in every row is averaged all the same
  for (const auto& channel : m.channels) {
    if (channel.input == "spindle.speed_rpm")
      for (Index i = 0; i < m.data.rows(); ++i) jumping.data.values(i, channel.column) = 1000.0 * (1 + i % 7);
  }
  EXPECT_LT(observe(jumping).rows.rows(), 120);
  // One switch in the middle of a step ends it.
  compensation::Measurement switched = m;
  for (const auto& channel : m.channels) {
    if (channel.input == "spindle.speed_rpm") {
      for (Index i = 0; i < m.data.rows(); ++i)
        switched.data.values(i, channel.column) = m.data.values(i, 0) < 7250 - 1 ? 0.0 : 9000.0;
    } else if (channel.input == "axis.Z.position_mm")
      for (Index i = 0; i < m.data.rows(); ++i) switched.data.values(i, channel.column) = 100.0 + 10.0 * (i % 9);
  }
  EXPECT_LT((observe(switched).points.array() - 7250).abs().minCoeff(), 1e-6);
}

TEST(Observations, StepsFollowTheOperation) {
  const Observations obs = observe(lumped::measure({}, {.hours = 12}));
  EXPECT_EQ(obs.rows.rows() + 1, obs.points.size());
  EXPECT_LE((obs.points.tail(obs.rows.rows()) - obs.points.head(obs.rows.rows())).maxCoeff(), 300 + 1e-9);
  // A change of speed at 3 h is met by an end of a step.
  EXPECT_LT((obs.points.array() - 3 * 3600).abs().minCoeff(), 1e-6);
  const solver::Channels channels(lumped::machine());
  for (Index i = 0; i < obs.rows.rows(); ++i) {
    const double rpm = obs.rows(i, channels.index("spindle.speed_rpm"));
    EXPECT_TRUE(rpm == 0 || rpm == 6000 || rpm == 9000) << rpm;
  }
}

TEST(Observations, AnAxisThatIsLoggedAsItMovesMakesNoMoreSteps) {
  compensation::Measurement m = lumped::measure({}, {.hours = 12, .sample_s = 60});
  const mesh::Machine machine = lumped::machine();
  const solver::Channels channels(machine);
  for (const auto& channel : m.channels) {
    if (channel.input != "axis.Z.position_mm") continue;
    for (Index i = 0; i < m.data.rows(); ++i)
      m.data.values(i, channel.column) = i % 7 < 3 ? 30.0 + i % 5 : 320.0 + 10 * (i % 4);
  }
  const Observations joined = diagnosis::observe(m, machine, channels, {}),
                     each = diagnosis::observe(m, machine, channels, {.longest_step_s = 60});
  EXPECT_EQ(each.rows.rows(), 720);
  EXPECT_TRUE(each.mixed.empty());
  EXPECT_EQ(joined.rows.rows(), 144);
  EXPECT_EQ(joined.mixed.size(), 144U);
  const reduction::ReducedModel model = lumped::model(machine, 6);
  // Of the axis's mean place nothing is left in the record: it is never there.
  Observations placed = joined;
  placed.mixed.clear();
  const VectorXd exact = Response(model, each).predict(machine);
  const auto farthest = [&](const Observations& obs) {
    const VectorXd apart = (Response(model, obs).predict(machine) - exact).cwiseAbs();
    double worst = 0.0;
    Index at = 0;
    for (const auto& channel : obs.channels) {
      const VectorXd values = exact.segment(at, channel.size());
      worst = std::max(worst, apart.segment(at, channel.size()).maxCoeff() / (values.maxCoeff() - values.minCoeff()));
      at += channel.size();
    }
    return worst;
  };
  EXPECT_LT(farthest(joined), 0.01);
  EXPECT_GT(farthest(placed), 0.03);
}

TEST(Observations, TooLittleDataIsRefused) {
  EXPECT_THROW(observe(lumped::measure({}, {.hours = 1})), core::InputError);
  compensation::Measurement m = lumped::measure({}, {.hours = 6});
  for (auto& channel : m.channels) {
    if (!channel.sensor.empty() || !channel.quantity.empty())
      m.data.values.col(channel.column).setConstant(std::nan(""));
  }
  EXPECT_THROW(observe(m), core::InputError);
}

}  // namespace
