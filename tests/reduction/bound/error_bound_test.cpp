// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/bound/error_bound.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <numbers>
#include <random>

#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "mesh/machine/kinematics.h"
#include "reduction/basis/basis.h"
#include "reduction/basis/reduce.h"
#include "reduction/basis/responses.h"
#include "reduction/bound/file.h"
#include "reduction/model/reduced_simulation.h"
#include "reduction/model/trained_range.h"
#include "solver/campaign/full_model.h"
#include "solver/operation/layout.h"
#include "solver/thermal/integrator.h"
#include "tests/core/temporary_folder.h"
#include "tests/machines/boxes.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Boxes {
  solver::FullModel full;
  ReducedModel model;
  MatrixXd basis;
  std::vector<mesh::Pose> poses;
  TrainedRange range;
  MatrixXd capacity, conduction;
  std::vector<MatrixXd> terms;

  Boxes() : full(test::boxes()) {
    core::set_quiet(true);
    model = reduce(full, {}, {}, {.method = BasisMethod::krylov, .order = 24}, nullptr, nullptr, &basis);
    basis = basis.leftCols(model.system.order()).eval();
    poses = {mesh::home_pose(full.mesh.machine), mesh::home_pose(full.mesh.machine)};
    poses[1](0) = 0.13;  // off the grid: interpolation of the output rows is part of the error
    poses[1](1) = -0.04;
    const solver::OperatingModel operating(full.mesh.machine, full.thermal.layout);
    for (const OperatingPoint& point : operating_points(operating)) range.include(point.c.p);
    capacity = full.thermal.capacity;
    conduction = full.thermal.conduction;
    for (const solver::SparseMatrix& term : full.thermal.terms) terms.emplace_back(term);
  }

  MatrixXd operator_at(const VectorXd& p) const {
    MatrixXd a = conduction;
    for (Index j = 0; j < p.size(); ++j)
      if (p(j) != 0.0) a += p(j) * terms[j];
    return a;
  }
};

const Boxes& boxes() {
  static const Boxes made;
  return made;
}

struct ExactBound {
  MatrixXd space;
  BoundModel model = make_bound_model(boxes().full, boxes().basis, boxes().range, boxes().poses,
                                      {.dual = 25, .probes = {.count = 0}}, &space);
};
const ExactBound& exact() {
  static const ExactBound made;
  return made;
}
const BoundModel& exact_bound() { return exact().model; }

/// Phases of a few steps at random speeds, positions, ranges, temperatures, states; films, contacts and
/// flows off their nominal values by a third.
struct Draw {
  std::vector<RunRecord::Step> steps;
  double initial_K = 0;

  Draw(unsigned seed, int phases) {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    std::normal_distribution<double> normal;
    const solver::FullModel& full = boxes().full;
    const solver::OperatingModel operating(full.mesh.machine, full.thermal.layout);
    initial_K = 10.0 * unit(engine) - 5.0;
    VectorXd factor(std::ssize(full.thermal.terms));
    for (double& value : factor) value = std::exp(0.3 * normal(engine));
    const auto points = operating_points(operating);
    for (int phase = 0; phase < phases; ++phase) {
      VectorXd row = points[engine() % points.size()].row;
      const auto set = [&](const char* name, double value) { row(operating.channels().index(name)) = value; };
      set("spindle.speed_rpm", 12000.0 * unit(engine));
      set("axis.X.feed_mm_min", 30000.0 * unit(engine));
      set("axis.X.position_mm", 400.0 * unit(engine) - 200.0);
      set("axis.Z.position_mm", 200.0 * unit(engine) - 100.0);
      set("axis.C.feed_deg_min", unit(engine) < 0.5 ? 0.0 : 36000.0 * unit(engine));
      set("air.T_C", 15.0 + 20.0 * unit(engine));
      set("cutting_fluid.on", unit(engine) < 0.5 ? 0.0 : 1.0);
      set("coolant.main.on", unit(engine) < 0.5 ? 0.0 : 1.0);
      solver::Coefficients c = operating.coefficients(row, VectorXd::Constant(1, 10.0 * unit(engine) - 5.0));
      for (Index k = 0; k < c.q.size(); ++k)
        if (const int term = full.thermal.layout.inputs[k].term; term >= 0) c.q(k) *= factor(term);
      c.p.array() *= factor.array();
      const double step = 20.0 * std::pow(30.0, unit(engine));
      for (unsigned i = 0, count = 1 + static_cast<unsigned>(engine() % 4); i < count; ++i) steps.push_back({c, step});
    }
  }

  /// Temperatures after each step on the full model, solved exactly.
  MatrixXd run_full() const {
    const Boxes& b = boxes();
    const double share = (1.0 - solver::sdirk_gamma) / solver::sdirk_gamma;
    MatrixXd states(b.full.thermal.size, std::ssize(steps) + 1);
    states.col(0).setConstant(initial_K);
    Eigen::PartialPivLU<MatrixXd> lu;
    const RunRecord::Step* last = nullptr;
    for (std::size_t k = 0; k < steps.size(); ++k) {
      const RunRecord::Step& step = steps[k];
      const double scale = solver::sdirk_gamma * step.length_s;
      if (!last || last->c.p != step.c.p || last->length_s != step.length_s)
        lu.compute(b.capacity + scale * b.operator_at(step.c.p));
      last = &step;
      const Index at = k;
      const VectorXd heat = scale * (b.full.thermal.inputs * step.c.q), before = states.col(at);
      const VectorXd first = lu.solve(b.capacity * before + heat);
      states.col(at + 1) = lu.solve(b.capacity * ((1.0 - share) * before + share * first) + heat);
    }
    return states;
  }

  RunRecord run_reduced() const {
    const ReducedSystem& system = boxes().model.system;
    RunRecord record{initial_K, true, steps, {}};
    ReducedStepper stepper(system);
    VectorXd state = stepper.uniform(initial_K);
    record.outputs.push_back({0.0, 0, state});
    double time = 0.0;
    for (std::size_t k = 0; k < steps.size(); ++k) {
      stepper.advance(state, steps[k].c, steps[k].length_s);
      time += steps[k].length_s;
      if (k % 2 == 1) record.outputs.push_back({time, k + 1, state});
    }
    return record;
  }
};

struct Compared {
  std::vector<double> ratios;  // bound over error, where the error is no rounding
  std::size_t statements = 0, broken = 0;
  double worst_bound_um = 0, worst_error_um = 0;
};

void compare(const BoundModel& bound, unsigned seed, Compared& all) {
  const Draw draw(seed, 3);
  const Boxes& b = boxes();
  const MatrixXd truth = draw.run_full();
  const RunRecord run = draw.run_reduced();
  const ErrorBound made = error_bound(b.model, bound, b.full.mesh.machine, run);
  ASSERT_EQ(made.table.rows(), std::ssize(run.outputs) * std::ssize(bound.poses));
  const MatrixXd own = value_rows(b.model, bound.poses);
  const Index values = own.rows() / std::ssize(bound.poses);
  static const std::vector<MatrixXd> rows = {error_rows(b.full, b.poses[0]), error_rows(b.full, b.poses[1])};
  Index row = 0;
  for (const RunRecord::Output& output : run.outputs) {
    for (std::size_t i = 0; i < bound.poses.size(); ++i, ++row) {
      const VectorXd full = 1e6 * (rows[i].transpose() * truth.col(output.steps));
      const VectorXd error = (full - own.middleRows(i * values, 6) * output.state).cwiseAbs();
      const VectorXd stated = made.table.values.row(row).tail(6);
      for (Index k = 0; k < 6; ++k) {
        ++all.statements;
        if (!(error(k) <= stated(k) + 1e-8)) ++all.broken;
        if (error(k) > 1e-4) all.ratios.push_back(stated(k) / error(k));
        all.worst_bound_um = std::max(all.worst_bound_um, stated(k));
        all.worst_error_um = std::max(all.worst_error_um, error(k));
      }
    }
  }
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

TEST(ErrorBound, HoldsForEveryOutputOfHundredsOfDraws) {
  Compared all;
  for (unsigned seed = 1; seed <= 200; ++seed) compare(exact_bound(), seed, all);
  std::printf(
      "order %d, bound on order %d with %d duals: %zu statements, bound over error: least %.2f, median %.2f; largest "
      "error %.3f, bound %.3f um\n",
      static_cast<int>(boxes().model.system.order()), static_cast<int>(exact_bound().terms.order()),
      static_cast<int>(exact_bound().terms.dual()), all.statements,
      *std::min_element(all.ratios.begin(), all.ratios.end()), median(all.ratios), all.worst_error_um,
      all.worst_bound_um);
  EXPECT_EQ(all.broken, 0u);
  EXPECT_GT(all.ratios.size(), 1000u);
  EXPECT_LT(median(all.ratios), 10.0);
}

TEST(ErrorBound, HoldsWithRandomProbes) {
  const BoundModel bound = make_bound_model(boxes().full, boxes().basis, boxes().range, boxes().poses,
                                            {.dual = 25, .probes = {.count = 60}});
  Compared all;
  for (unsigned seed = 1; seed <= 60; ++seed) compare(bound, seed, all);
  std::printf("60 probes: %zu statements, bound over error: least %.2f, median %.2f\n", all.statements,
              *std::min_element(all.ratios.begin(), all.ratios.end()), median(all.ratios));
  EXPECT_EQ(all.broken, 0u);
  EXPECT_LT(median(all.ratios), 30.0);
}

/// The model's own part taken off, sums over the stages of both schemes, one by one, give the same.
TEST(ErrorBound, RemainderIsTheProductOfBothResidualNorms) {
  const Boxes& b = boxes();
  const BoundModel& bound = exact_bound();
  const Draw draw(77, 5);
  const RunRecord run = draw.run_reduced();
  const ErrorBound made = error_bound(b.model, bound, b.full.mesh.machine, run);

  BoundSum sum(bound.terms);
  const Index dual_order = bound.terms.dual();
  const double g = solver::sdirk_gamma, share = (1.0 - g) / g, r2 = std::numbers::sqrt2;
  const Index last = run.outputs.back().steps;

  // Norms by their definitions, in coordinates of U: residuals through exact probes.
  VectorXd state = bound.one_kelvin * run.initial_K;
  const Index mark = run.outputs[run.outputs.size() - 2].steps;
  ASSERT_GT(mark, 0);
  ASSERT_LT(mark, last);
  double primal[2] = {0.0, 0.0};  // before the last window and in it
  double smallest = 1.0;
  for (Index k = 0; k < last; ++k) {
    const RunRecord::Step& step = run.steps[k];
    for (Index j = 0; j < step.c.p.size(); ++j) {
      if (bound.least(j) > 0.0 && bound.layout.terms[j].kind != solver::TermKind::coolant_flow)
        smallest = std::min(smallest, step.c.p(j) / bound.least(j));
    }
    const double scale = g * step.length_s;
    sum.set(step.c.p);
    const MatrixXd a = sum.conduction();
    const Eigen::PartialPivLU<MatrixXd> lu(MatrixXd::Identity(a.rows(), a.rows()) + scale * a);
    const VectorXd heat = scale * (bound.inputs * step.c.q);
    const VectorXd x1 = lu.solve(state + heat), x2 = lu.solve((1.0 - share) * state + share * x1 + heat);
    MatrixXd r(bound.primal_inputs.rows(), 2);
    r << sum.residual() * x1 - bound.primal_inputs * step.c.q, sum.residual() * x2 - bound.primal_inputs * step.c.q;
    Eigen::Matrix2d pairing;
    pairing << 4 - 2 * r2, 2 - 2 * r2, 2 - 2 * r2, 4;
    primal[k >= mark] += scale * (pairing.inverse() * (r.transpose() * r)).trace();
    state = x2;
  }
  for (Index output = 0; output < 6; ++output) {
    double dual[2] = {0.0, 0.0};
    VectorXd row = bound.rows[1].row(output).head(dual_order);
    for (Index k = last - 1; k >= 0; --k) {
      const RunRecord::Step& step = run.steps[k];
      const double scale = g * step.length_s;
      sum.set(step.c.p);
      const MatrixXd of_dual = sum.dual_residual();
      const Eigen::PartialPivLU<MatrixXd> lu(MatrixXd::Identity(dual_order, dual_order) +
                                             scale *
                                                 sum.conduction().topLeftCorner(dual_order, dual_order).transpose());
      const VectorXd second = lu.solve(row), first = lu.solve(share * second);
      MatrixXd rho(bound.primal_inputs.rows(), 2);
      rho << scale * (of_dual * first), scale * (of_dual * second);
      if (k == last - 1) rho.col(1) += bound.rest[1].col(output);
      Eigen::Matrix2d pairing;
      pairing << 4 - 2 * r2, 2 - 2 * r2, 2 - 2 * r2, 4;
      dual[k >= mark] += (pairing * (rho.transpose() * rho)).trace() / scale;
      row = (1.0 - share) * second + first;
    }
    const double own = (value_rows(b.model, {b.poses[1]}).row(output)).dot(run.outputs.back().state);
    const double beside = std::abs(1e6 * bound.rows[1].row(output).dot(state) - own);
    const double stated = made.table.values(made.table.rows() - 1, made.table.values.cols() - 6 + output);
    const double product = std::sqrt((dual[0] + dual[1]) * (primal[0] + primal[1])) + std::sqrt(dual[0] * primal[0]) +
                           std::sqrt(dual[1] * primal[1]);
    EXPECT_NEAR(stated - beside, 1e6 * 0.5 * product / smallest, 1e-5 * stated) << output;
  }
  EXPECT_NEAR(made.scale, 1.0 / smallest, 1e-9 / smallest);
}

/// What the spaces leave of every term and of its transpose, in the dual norm of the least conduction.
TEST(ErrorBound, ResidualsAreThoseOfEachTermAndOfItsTranspose) {
  const Boxes& b = boxes();
  const BoundModel& bound = exact_bound();
  const MatrixXd &u = exact().space, w = u.leftCols(bound.terms.dual());
  MatrixXd parts;
  const Eigen::LLT<MatrixXd> least(MatrixXd(least_conduction(b.full.thermal, bound.least, parts)));
  bool one_way = false;
  BoundSum none(bound.terms);
  for (std::size_t j = 0; j <= b.terms.size(); ++j) {
    BoundSum with(bound.terms);
    if (j > 0) with.set(VectorXd::Unit(bound.terms.count(), static_cast<Index>(j) - 1));
    const auto alone = [&](const MatrixXd& sum, const MatrixXd& of_base) {
      return j == 0 ? sum : MatrixXd(sum - of_base);
    };
    const MatrixXd& k = j == 0 ? b.conduction : b.terms[j - 1];
    const auto expect_gram = [&](const MatrixXd& residual, const MatrixXd& seen) {
      const MatrixXd gram = residual.transpose() * least.solve(residual);
      EXPECT_LT((seen.transpose() * seen - gram).norm(), 1e-8 * gram.norm() + 1e-18) << "term " << j;
    };
    const MatrixXd on_u = u.transpose() * k * u;
    EXPECT_LT((alone(with.conduction(), none.conduction()) - on_u).norm(), 1e-9 * on_u.norm() + 1e-15) << "term " << j;
    expect_gram(b.capacity * u * on_u - k * u, alone(with.residual(), none.residual()));
    expect_gram(b.capacity * w * (w.transpose() * k.transpose() * w) - k.transpose() * w,
                alone(with.dual_residual(), none.dual_residual()));
    one_way = one_way || (k - k.transpose()).norm() > 0.1 * k.norm();
  }
  EXPECT_TRUE(one_way) << "a machine with a coolant";
}

TEST(ErrorBound, FileGivesTheSameBound) {
  const Boxes& b = boxes();
  const core::TemporaryFolder scratch;
  const auto path = scratch.path() / "bound.rom.h5";
  write_bound(path, exact_bound());
  const BoundModel read = read_bound(path, b.model);
  const RunRecord run = Draw(5, 2).run_reduced();
  const ErrorBound before = error_bound(b.model, exact_bound(), b.full.mesh.machine, run),
                   after = error_bound(b.model, read, b.full.mesh.machine, run);
  EXPECT_EQ(before.table.values, after.table.values);
  EXPECT_EQ(before.table.columns, after.table.columns);
  ReducedModel other = b.model;
  other.machine.hash = "another";
  EXPECT_THROW(read_bound(path, other), core::InputError);
  EXPECT_THROW(read_bound(scratch.path() / "none.h5", b.model), core::InputError);
  core::write_file(path, "no HDF5");
  EXPECT_THROW(read_bound(path, b.model), core::InputError);
}

TEST(ErrorBound, RefusesWhatItDoesNotHoldFor) {
  const Boxes& b = boxes();
  RunRecord run = Draw(6, 2).run_reduced();
  run.sdirk = false;
  EXPECT_THROW(error_bound(b.model, exact_bound(), b.full.mesh.machine, run), core::InputError);
  run.sdirk = true;
  ReducedModel other = b.model;
  other.full_size += 1;
  EXPECT_THROW(error_bound(other, exact_bound(), b.full.mesh.machine, run), core::InputError);
  run.steps.front().c.p.conservativeResize(3);
  EXPECT_THROW(error_bound(b.model, exact_bound(), b.full.mesh.machine, run), core::InputError);
}

/// A film that always cooled and does no longer: nothing is known of how heat leaves.
TEST(ErrorBound, KnowsNoEndWhereAFilmVanishes) {
  const Boxes& b = boxes();
  RunRecord run = Draw(7, 2).run_reduced();
  Index always = 0;
  while (exact_bound().least(always) <= 0.0) ++always;
  EXPECT_LT(error_bound(b.model, exact_bound(), b.full.mesh.machine, run).largest_um, 1e3);
  for (RunRecord::Step& step : run.steps) step.c.p(always) *= 1e-3;
  const double scale = error_bound(b.model, exact_bound(), b.full.mesh.machine, run).scale;
  EXPECT_GT(scale, 100.0);
  for (RunRecord::Step& step : run.steps) step.c.p(always) = 0.0;
  EXPECT_TRUE(std::isinf(error_bound(b.model, exact_bound(), b.full.mesh.machine, run).largest_um));
}

}  // namespace
}  // namespace thermotwin::reduction
