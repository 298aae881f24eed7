// SPDX-License-Identifier: GPL-3.0-or-later
// A slide that goes to and fro: contact and friction taken as their mean over the range, on the joint's
// own grid and on a finer one, against the motion itself as a sequence of positions on the finer one.
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "solver/thermal/assembly.h"
#include "solver/thermal/integrator.h"
#include "solver/thermal/system.h"
#include "tests/machines/slide_machine.h"
#include "tests/verification/table.h"

namespace thermotwin::test {
namespace {

using Index = Eigen::Index;

mesh::Machine pendular_machine(int positions) {
  mesh::Machine machine = slide_machine();
  machine.coolants.clear();
  machine.films.pop_back();  // the disc has nothing to do with it
  machine.films[1].state.clear();
  machine.films[1].coefficient = {15.0, 0.0};
  machine.films[1].ambient = "air";
  // Friction at the contact, and heat that has to cross it.
  machine.sources = {source("friction", "axis.X.feed_mm_min", {0, 30000}, {0, 90}, {at_joint("X_guide", 1.0, 0.5)}),
                     source("motor", "machine.on", {0, 1}, {0, 40}, {on_surface("slide.left")})};
  // Workspace positions are nodes of the joint's grid.
  machine.workspace.positions[0].clear();
  for (int i = 0; i < positions; ++i) machine.workspace.positions[0].push_back(-0.2 + 0.4 * i / (positions - 1));
  return machine;
}

constexpr double low = -0.15, high = 0.15, hour = 3600.0;

struct Rig {
  mesh::MachineMesh mesh;
  solver::ThermalSystem system;
  solver::OperatingModel model;
  Eigen::VectorXd row;

  explicit Rig(int positions)
      : mesh(slide_mesh(1, pendular_machine(positions))),
        system(solver::assemble_thermal(mesh)),
        model(mesh.machine, system.layout),
        row(model.channels().defaults()) {
    at("axis.X.feed_mm_min") = 20000.0;
    at("cutting_fluid.on") = 1.0;
  }
  double& at(const std::string& name) { return row[model.channels().index(name)]; }
  solver::Coefficients now() const { return model.coefficients(row, Eigen::VectorXd()); }
};

/// After half an hour, the mean over one more period; the time average.
Eigen::VectorXd averaged(double period, int positions) {
  Rig rig(positions);
  rig.at("axis.X.low_mm") = 1e3 * low;
  rig.at("axis.X.high_mm") = 1e3 * high;
  solver::ThermalIntegrator integrator(rig.system);
  Eigen::MatrixXd state = Eigen::MatrixXd::Zero(rig.system.size, 1);
  for (int i = 0; i < 90; ++i) integrator.advance(state, {rig.now()}, hour / 2 / 90);
  const Eigen::VectorXd begin = state.col(0);
  integrator.advance(state, {rig.now()}, period);
  return 0.5 * (begin + state.col(0));
}

struct Resolved {
  Eigen::VectorXd mean;
  double swing = 0;  ///< K, largest distance of any node from its mean over the last period
};

Resolved resolved(double period) {
  constexpr int steps = 32;  // a period
  Rig rig(65);
  EXPECT_GE(rig.system.layout.grids[0].positions.size(), 65u);
  solver::ThermalIntegrator integrator(rig.system);
  Eigen::MatrixXd state = Eigen::MatrixXd::Zero(rig.system.size, 1);
  Eigen::MatrixXd last(rig.system.size, steps);
  const int periods = std::lround(hour / 2 / period) + 1;
  for (int p = 0; p < periods; ++p) {
    for (int i = 0; i < steps; ++i) {
      const double phase = (i + 0.5) / steps, way = phase < 0.5 ? 2.0 * phase : 2.0 - 2.0 * phase;
      rig.at("axis.X.position_mm") = 1e3 * (low + way * (high - low));
      const Eigen::VectorXd before = state.col(0);
      integrator.advance(state, {rig.now()}, period / steps);
      last.col(i) = 0.5 * (before + state.col(0));
    }
  }
  Resolved result;
  result.mean = last.rowwise().mean();
  result.swing = (last.colwise() - result.mean).cwiseAbs().maxCoeff();
  return result;
}

TEST(MovingContact, TimeAverageStandsForTheMotion) {
  for (const auto& [period, fine_tolerance, tolerance, ripple] :
       {std::tuple{10.0, 0.2, 1.0, 3.0}, {60.0, 1.5, 2.5, 8.0}}) {
    const Resolved motion = resolved(period);
    const double rise = motion.mean.maxCoeff();
    EXPECT_GT(rise, 5.0);
    const std::string name = "slide to and fro, " + std::to_string(std::lround(period)) + " s a period";
    const auto difference = [&](int positions) {
      return 100.0 * (averaged(period, positions) - motion.mean).cwiseAbs().maxCoeff() / rise;
    };
    expect_value({name, "fine sequence of positions",
                  "time average, fine grid: largest difference of a node's mean T, % of the rise"},
                 0.0, difference(65), fine_tolerance);
    expect_value(
        {name, "fine sequence of positions", "time average: largest difference of a node's mean T, % of the rise"}, 0.0,
        difference(3), tolerance);
    expect_value(
        {name, "fine sequence of positions", "what the average leaves out: largest swing of a node's T, % of the rise"},
        0.0, 100.0 * motion.swing / rise, ripple);
  }
}

TEST(MovingContact, StandingInTheMiddleIsSomethingElse) {
  // The test above could not tell if where the slide spends its time made no difference.
  Rig rig(3);
  rig.at("axis.X.position_mm") = 0.0;
  solver::ThermalIntegrator integrator(rig.system);
  Eigen::MatrixXd state = Eigen::MatrixXd::Zero(rig.system.size, 1);
  for (int i = 0; i < 90; ++i) integrator.advance(state, {rig.now()}, hour / 2 / 90);
  const Eigen::VectorXd mean = averaged(10.0, 3);
  EXPECT_GT((mean - state.col(0)).cwiseAbs().maxCoeff(), 0.1 * mean.maxCoeff());
}

}  // namespace
}  // namespace thermotwin::test
