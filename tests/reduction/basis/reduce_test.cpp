// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis/reduce.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <iterator>
#include <optional>

#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "mesh/machine/kinematics.h"
#include "reduction/basis/error_estimate.h"
#include "reduction/model/model_file.h"
#include "reduction/model/reduced_simulation.h"
#include "reduction/model/trained_range.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"
#include "tests/core/temporary_folder.h"
#include "tests/machines/boxes.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const char* training_text = R"(
schema = 1
initial_C = 20.0
time_step_s = 120
output_s = 600
position = { X_mm = 0, Z_mm = 0 }
[[phase]]
name = "warm up"
duration_h = 3
spindle_rpm = 9000
air_C = [20, 22]
[[phase.axis]]
id = "X"
low_mm = -200
high_mm = 100
feed_mm_min = 20000
[[phase]]
name = "cooling, other end"
duration_h = 2
spindle_rpm = 0
coolant = false
[[phase.axis]]
id = "X"
position_mm = 200
[[phase.axis]]
id = "Z"
position_mm = -100
)";

/// Other speeds, ranges, ambient; cutting fluid and a turning table, which the training never saw.
const char* heldout_text = R"(
schema = 1
initial_C = 21.0
time_step_s = 60
output_s = 600
position = { X_mm = -150, Z_mm = 80 }
[[phase]]
name = "mixed"
duration_h = 2
spindle_rpm = 4500
air_C = [21, 25]
cutting_fluid = true
[[phase.axis]]
id = "X"
low_mm = -50
high_mm = 200
feed_mm_min = 30000
[[phase.axis]]
id = "C"
speed_rpm = 50
[[phase]]
name = "standing"
duration_h = 1
spindle_rpm = 12000
[[phase.axis]]
id = "Z"
position_mm = -60
)";

/// The full model of the boxes with both loads run on it, made once for all tests.
struct Campaign {
  solver::FullModel full;
  std::vector<solver::LoadProgram> loads;
  std::vector<solver::LoadResult> results;

  Campaign() : full(test::boxes(2)) {
    core::set_quiet(true);
    const core::TemporaryFolder scratch;
    const mesh::Machine& machine = full.mesh.machine;
    for (const auto& [name, text] : {std::pair{"training.toml", training_text}, {"heldout.toml", heldout_text}}) {
      core::write_file(scratch.path() / name, text);
      loads.push_back(solver::LoadProgram::read(scratch.path() / name, machine));
    }
    solver::CampaignOptions options;
    options.keep_snapshots = true;
    results = run_campaign(full, loads, options);
  }
};

const Campaign& campaign() {
  static const Campaign made;
  return made;
}

struct Reduction {
  ReducedModel model;
  ReduceSummary summary;
};

const Reduction& reduction() {
  static const Reduction made = [] {
    Reduction r;
    ReduceOptions options;
    options.tolerance_um = 0.02;
    r.model = reduce(campaign().full, {campaign().loads[0]}, {campaign().results[0]}, options, &r.summary);
    return r;
  }();
  return made;
}

MatrixXd operator_at(const ReducedSystem& system, const VectorXd& p) {
  MatrixXd a = system.conduction;
  for (Index j = 0; j < p.size(); ++j) a += p(j) * system.terms[j];
  return a;
}

TEST(Reduce, MeetsItsToleranceOnTheTrainingLoad) {
  const Reduction& r = reduction();
  std::printf("%s\n", r.summary.brief().c_str());
  ASSERT_FALSE(r.summary.order_error_um.empty());
  EXPECT_LE(r.summary.order_error_um.back().second, 0.02);
  EXPECT_EQ(r.summary.order_error_um.back().first, r.summary.order);
  EXPECT_EQ(r.model.system.order(), r.summary.order);
  EXPECT_LT(r.summary.order, campaign().full.thermal.size / 10);
  for (std::size_t i = 0; i + 1 < r.summary.order_error_um.size(); ++i) {
    EXPECT_GT(r.summary.order_error_um[i].second, 0.02) << "a smaller order would have done";
  }
}

TEST(Reduce, SaysWhereNoOrderReachesItsTolerance) {
  EXPECT_EQ(reduction().summary.missed_um, 0.0);
  const Campaign& c = campaign();
  ReduceOptions options;
  options.max_order = 40;
  options.tolerance_um = 1e-7;
  ReduceSummary summary;
  reduce(c.full, {c.loads[0]}, {c.results[0]}, options, &summary);
  EXPECT_EQ(summary.missed_um, 1e-7);
  EXPECT_NE(summary.brief().find("no order reaches tolerance_um = 1e-07 on the training loads; the least error is"),
            std::string::npos)
      << summary.brief();
}

TEST(Reduce, PredictsALoadThatItNeverSaw) {
  const Reduction& r = reduction();
  const Campaign& c = campaign();
  const solver::LoadResult reduced =
      simulate_reduced(r.model, c.full.mesh.machine, c.loads[1], mesh::workspace_poses(c.full.mesh.machine));
  const ReductionErrors errors = compare(c.results[1], reduced);
  std::printf("held-out load: peak %.2f um, reduced minus full at most %.4f um, rms %.4f um\n", errors.peak_um,
              errors.max_um, errors.rms_um);
  EXPECT_GT(errors.peak_um, 5.0) << "a load without error proves nothing";
  EXPECT_LT(errors.max_um, 0.1);
  EXPECT_LT(errors.rms_um, 0.03);
  EXPECT_EQ(reduced.tcp.columns, c.results[1].tcp.columns);
  EXPECT_EQ(reduced.sensors.columns, c.results[1].sensors.columns);
  EXPECT_EQ(reduced.inputs.columns, c.results[1].inputs.columns);
  ASSERT_EQ(reduced.sensors.rows(), c.results[1].sensors.rows());
  EXPECT_LT((reduced.sensors.values - c.results[1].sensors.values).cwiseAbs().maxCoeff(), 0.05) << "K";
  const MatrixXd inputs = reduced.inputs.values, expected = c.results[1].inputs.values;
  ASSERT_EQ(inputs.rows(), expected.rows());
  for (Index i = 0; i < inputs.size(); ++i) {
    if (std::isnan(expected(i))) continue;
    EXPECT_NEAR(inputs(i), expected(i), 1e-9 * (1.0 + std::abs(expected(i))));
  }
}

TEST(Reduce, RotationsAndBothSidesAgreeToo) {
  const Reduction& r = reduction();
  const Campaign& c = campaign();
  const solver::LoadResult reduced =
      simulate_reduced(r.model, c.full.mesh.machine, c.loads[1], mesh::workspace_poses(c.full.mesh.machine));
  for (const std::string& column : solver::tcp_columns()) {
    const VectorXd truth = c.results[1].tcp.column(column);
    EXPECT_LT((reduced.tcp.column(column) - truth).cwiseAbs().maxCoeff(), 0.5 + 0.01 * truth.cwiseAbs().maxCoeff())
        << column;
  }
}

TEST(Reduce, UniformTemperatureIsExactInStateAndOutputs) {
  const ReducedSystem& system = reduction().model.system;
  const VectorXd& one = system.one_kelvin;
  EXPECT_LT((system.sensors * one - VectorXd::Ones(system.sensors.rows())).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((system.conduction * one).norm(), 1e-9 * system.conduction.norm() * one.norm());
  const VectorXd ones = VectorXd::Ones(campaign().full.thermal.size);
  const double heat_capacity = ones.dot(campaign().full.thermal.capacity * ones);
  EXPECT_NEAR(one.squaredNorm(), heat_capacity, 1e-9 * heat_capacity);
  const solver::OutputRows rows = campaign().full.elastic.output_rows(reduction().model.outputs.tool_poses[4]);
  EXPECT_LT((reduction().model.outputs.tool[4] * one - rows.tool * ones).norm(), 1e-9 * (rows.tool * ones).norm());
}

TEST(Reduce, KeepsStability) {
  const ReducedSystem& system = reduction().model.system;
  EXPECT_EQ(system.capacity, MatrixXd::Identity(system.order(), system.order()));
  const auto smallest = [](const MatrixXd& m) {
    return Eigen::SelfAdjointEigenSolver<MatrixXd>(0.5 * (m + m.transpose())).eigenvalues()(0);
  };
  EXPECT_GT(smallest(system.conduction), -1e-12 * system.conduction.norm());
  for (std::size_t j = 0; j < system.terms.size(); ++j) {
    EXPECT_GT(smallest(system.terms[j]), -1e-10 * system.terms[j].norm()) << "term " << j;
  }
  const solver::OperatingModel operating(campaign().full.mesh.machine, system.layout);
  const VectorXd inlet = VectorXd::Zero(1);
  for (const double on : {0.0, 1.0}) {
    VectorXd row = operating.channels().defaults();
    row(operating.channels().index("coolant.main.on")) = on;
    row(operating.channels().index("cutting_fluid.on")) = on;
    EXPECT_GT(smallest(operator_at(system, operating.coefficients(row, inlet).p)), 0.0);
  }
}

// Three positions over 400 mm do not follow the bed's bend under the hot slide more closely; the
// table side alone moves by 18 um here.
TEST(Reduce, PoseBetweenTheGridIsClose) {
  const Reduction& r = reduction();
  const Campaign& c = campaign();
  mesh::Pose pose = mesh::home_pose(c.full.mesh.machine);
  pose(0) = 0.11;
  pose(1) = -0.045;
  pose(2) = 0.4;
  solver::CampaignOptions options;
  options.poses = {pose};
  const solver::LoadResult full = solver::run_campaign(c.full, {c.loads[1]}, options)[0];
  const ReductionErrors errors = compare(full, simulate_reduced(r.model, c.full.mesh.machine, c.loads[1], {pose}));
  std::printf("off the grid: peak %.2f um, at most %.3f um\n", errors.peak_um, errors.max_um);
  EXPECT_LT(errors.max_um, 0.6);
  EXPECT_GT(errors.peak_um, 5.0);
}

TEST(Reduce, WithoutTrainingTheKrylovBasisAloneIsGood) {
  const Campaign& c = campaign();
  ReduceOptions options;
  options.order = 60;
  ReduceSummary summary;
  const ReducedModel model = reduce(c.full, {}, {}, options, &summary);
  EXPECT_EQ(model.system.order(), 60);
  EXPECT_TRUE(summary.order_error_um.empty());
  for (std::size_t i = 0; i < 2; ++i) {
    const ReductionErrors errors = compare(c.results[i], simulate_reduced(model, c.full.mesh.machine, c.loads[i],
                                                                          mesh::workspace_poses(c.full.mesh.machine)));
    std::printf("Krylov only, order 60, load %s: at most %.4f um of %.1f\n", errors.load.c_str(), errors.max_um,
                errors.peak_um);
    EXPECT_LT(errors.max_um, 0.3);
  }
}

TEST(Reduce, AChangedMachineNeedsNoNewReduction) {
  // Half the contact, three times the cutting fluid's film, less coolant: only coefficients change.
  const Campaign& c = campaign();
  solver::FullModel changed = test::boxes(2);
  for (mesh::JointSpec& joint : changed.mesh.machine.joints) joint.conductance.value *= 0.5;
  for (mesh::FilmSpec& film : changed.mesh.machine.films) film.coefficient.value *= 3.0;
  changed.mesh.machine.coolants[0].flow.value *= 0.6;
  const solver::LoadResult full = solver::run_campaign(changed, {c.loads[1]}, {})[0];
  const ReductionErrors errors = compare(full, simulate_reduced(reduction().model, changed.mesh.machine, c.loads[1],
                                                                mesh::workspace_poses(changed.mesh.machine)));
  std::printf("changed machine: peak %.2f um, at most %.4f um\n", errors.peak_um, errors.max_um);
  EXPECT_LT(errors.max_um, 0.01 * errors.peak_um + 0.2);
}

TEST(Reduce, TheFileKeepsThePrediction) {
  const core::TemporaryFolder scratch;
  const Campaign& c = campaign();
  write_model(scratch.path() / "model.rom.h5", reduction().model);
  const ReducedModel back = read_model(scratch.path() / "model.rom.h5");
  const std::vector<mesh::Pose> poses{mesh::home_pose(back.machine)};
  const solver::LoadResult first = simulate_reduced(reduction().model, c.full.mesh.machine, c.loads[1], poses);
  const solver::LoadResult second = simulate_reduced(back, back.machine, c.loads[1], poses);
  EXPECT_EQ(first.tcp.values, second.tcp.values);
}

/// A small model with its reference, from the training load alone.
struct Estimated {
  ReducedModel model, reference;
  Estimated(Index order, BasisMethod method = BasisMethod::combined) {
    ReduceOptions options;
    options.order = order;
    options.method = method;
    model = reduce(campaign().full, {campaign().loads[0]}, {campaign().results[0]}, options, nullptr, &reference);
  }
};

TEST(ErrorEstimate, IsWithinAFactorOfTwoOnALoadThatItNeverSaw) {
  const Campaign& c = campaign();
  const std::vector<mesh::Pose> poses = mesh::workspace_poses(c.full.mesh.machine);
  for (const Index order : {20, 30, 45}) {
    const Estimated made(order);
    ASSERT_EQ(made.reference.system.order(), reference_order(order));
    const EstimatedRun run = simulate_with_estimate(made.model, made.reference, c.full.mesh.machine, c.loads[1], poses);
    const Effectivity judged = effectivity(c.results[1], run);
    const double truth = compare(c.results[1], run.result).max_um;
    std::printf(
        "order %td: error %.4f um, estimated %.4f um; estimated/true median %.3f, 5..95 %% %.3f..%.3f, within two %.0f "
        "%%\n",
        order, truth, judged.max_um, judged.median, judged.low, judged.high, 100 * judged.within_two);
    EXPECT_GT(judged.median, 0.5);
    EXPECT_LT(judged.median, 2.0);
    EXPECT_GT(judged.within_two, 0.8);
    EXPECT_EQ(run.estimate.columns.back(), "rc_um_per_m");
    EXPECT_EQ(run.estimate.rows(), run.result.tcp.rows());
  }
}

TEST(ErrorEstimate, SmallerOrForeignReferencesAreRefused) {
  const Campaign& c = campaign();
  const Estimated made(20);
  const auto run = [&](const ReducedModel& reference) {
    simulate_with_estimate(made.model, reference, c.full.mesh.machine, c.loads[1],
                           {mesh::home_pose(c.full.mesh.machine)});
  };
  EXPECT_THROW(run(made.model), core::InputError);
  ReducedModel foreign = made.reference;
  foreign.machine.hash += "x";
  EXPECT_THROW(run(foreign), core::InputError);
}

TEST(TrainedRange, SaysWhatLeavesIt) {
  const Campaign& c = campaign();
  const Estimated made(20);
  ASSERT_EQ(made.model.trained.low.size(), std::ssize(made.model.system.terms));
  TrainedRange seen;
  simulate_reduced(made.model, c.full.mesh.machine, c.loads[0], {mesh::home_pose(c.full.mesh.machine)},
                   {.seen = &seen});
  EXPECT_EQ(outside_trained(made.model, seen), "") << "a load of the training";
  seen.high(0) *= 3.0;
  const std::string text = outside_trained(made.model, seen);
  EXPECT_NE(text.find("'" + c.full.mesh.machine.films[0].id + "'"), std::string::npos) << text;
}

TEST(Reduce, ExactStepsAreWhatFineStepsComeTo) {
  const Campaign& c = campaign();
  const mesh::Machine& machine = c.full.mesh.machine;
  const std::vector<mesh::Pose> pose{mesh::home_pose(machine)};
  const auto z = [&](const ReducedRun& how) {
    return simulate_reduced(reduction().model, machine, c.loads[0], pose, how).tcp.column("dz_um");
  };
  const VectorXd truth = z({.refine = 0.05});
  const double stepped = (z({}) - truth).cwiseAbs().maxCoeff(),
               exact = (z({.exact = true}) - truth).cwiseAbs().maxCoeff();
  std::printf("time error of dz: SDIRK2 %.2e um, exact steps %.2e um\n", stepped, exact);
  EXPECT_GT(stepped, 0.0);
  EXPECT_LT(exact, 0.5 * stepped);
}

TEST(Reduce, AMachineWithOtherTermsIsRefused) {
  const Campaign& c = campaign();
  mesh::Machine other = c.full.mesh.machine;
  other.films.pop_back();
  EXPECT_THROW(simulate_reduced(reduction().model, other, c.loads[1], {mesh::home_pose(other)}), core::InputError);
}

TEST(BasisMethods, OfOneOrderCompareOnTheSameLoad) {
  const Campaign& c = campaign();
  const std::vector<mesh::Pose> poses = mesh::workspace_poses(c.full.mesh.machine);
  const auto error = [&](BasisMethod method) {
    const Estimated made(40, method);
    EXPECT_LE(made.model.system.order(), 40) << "snapshots of one load may span less";
    const double worst =
        compare(c.results[1], simulate_reduced(made.model, c.full.mesh.machine, c.loads[1], poses)).max_um;
    std::printf("%s, order 40: %.4f um\n", name_of(method), worst);
    return worst;
  };
  const double combined = error(BasisMethod::combined), modal = error(BasisMethod::modal);
  EXPECT_LT(combined, modal) << "modes know nothing of inputs and outputs";
  EXPECT_LT(error(BasisMethod::krylov), modal);
  EXPECT_GT(error(BasisMethod::pod), combined) << "one load does not show all";
  EXPECT_LT(modal, compare(c.results[1], c.results[1]).peak_um);
  EXPECT_EQ(basis_method("pod"), BasisMethod::pod);
  EXPECT_THROW(basis_method("magic"), core::UsageError);
}

TEST(Reduce, ResultsThatDoNotFitAreRefused) {
  const Campaign& c = campaign();
  EXPECT_THROW(reduce(c.full, {}, {c.results[0]}, {}), core::InputError);
  EXPECT_THROW(compare(c.results[0], c.results[1]), core::InputError);
}

TEST(Reduce, PosesComeBackFromATable) {
  const mesh::Machine& machine = campaign().full.mesh.machine;
  const std::vector<mesh::Pose> poses = poses_of(machine, campaign().results[0].tcp),
                                expected = mesh::workspace_poses(machine);
  ASSERT_EQ(poses.size(), expected.size());
  for (std::size_t i = 0; i < poses.size(); ++i) EXPECT_LT((poses[i] - expected[i]).norm(), 1e-12);
}

TEST(ReduceSummary, AnOrderThatDivergesIsNoNumber) {
  reduction::ReduceSummary summary;
  summary.order_error_um = {{40, 2.4e129}, {100, 3.3263}};
  EXPECT_NE(summary.brief().find("order  40: diverges on the training loads"), std::string::npos) << summary.brief();
  EXPECT_NE(summary.brief().find("order 100: 3.3263 um"), std::string::npos) << summary.brief();
}

}  // namespace
}  // namespace thermotwin::reduction
