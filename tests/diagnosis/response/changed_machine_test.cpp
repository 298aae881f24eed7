// SPDX-License-Identifier: GPL-3.0-or-later
// Causes in matrices: what the extended machine.toml does in the full model, the parts of the reduced
// model do as well.
#include <gtest/gtest.h>

#include <vector>

#include "diagnosis/causes/hypothesis.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/causes/parameter_sizes.h"
#include "diagnosis/response/response.h"
#include "mesh/machine/file.h"
#include "reduction/model/reduced_simulation.h"
#include "solver/campaign/load_result.h"
#include "tests/machines/meshed_boxes.h"

namespace {

using namespace thermotwin;
using diagnosis::Kind;

struct Change {
  Kind kind;
  const char* where;
  double value, least_um;  ///< what it moves the TCP by at least
};
void PrintTo(const Change& change, std::ostream* out) {
  *out << name_of(change.kind) << " of " << change.where << " " << change.value;
}

/// Results of one load on the full model at the workspace's poses.
solver::LoadResult run(const mesh::Machine& machine) {
  return solver::run_campaign(meshed::full_model(machine), {meshed::load(machine, "shift", meshed::shift)}, {}).front();
}
const solver::LoadResult& nominal() {
  static const solver::LoadResult result = run(meshed::machine());
  return result;
}

class ChangedMachine : public ::testing::TestWithParam<Change> {};

TEST_P(ChangedMachine, RunsInBothModelsAlike) {
  const Change& change = GetParam();
  const diagnosis::Parameter cause = diagnosis::make_parameter(change.kind, change.where);
  const mesh::Machine machine = meshed::machine();
  const mesh::Machine extended =
      mesh::parse_machine(diagnosis::extended_text(machine, cause, change.value, 0.1, ""), machine.path);
  const solver::LoadResult full = run(extended);
  const reduction::ReducedModel model = diagnosis::model_of_changed(meshed::reduced(), extended);
  const auto poses = mesh::workspace_poses(machine);
  const auto load = meshed::load(extended, "shift", meshed::shift);
  const auto reduced = [&](const reduction::ReducedModel& of) {
    return reduction::simulate_reduced(of, extended, load, poses);
  };
  const double base =
      reduction::compare(nominal(), reduction::simulate_reduced(meshed::reduced(), machine, load, poses)).max_um;
  const double effect = reduction::compare(nominal(), full).max_um,
               error = reduction::compare(full, reduced(model)).max_um;
  std::printf(
      "%s of %s x %.2f: moves the TCP by up to %.2f um; reduced against full %.3f um, nominal machine %.3f um\n",
      name_of(change.kind).c_str(), change.where, change.value, effect, error, base);
  EXPECT_GT(effect, change.least_um);
  // Rows follow a power of the stiffness only in part.
  EXPECT_LT(error, 1.5 * base + (cause.kind == Kind::contact_stiffness ? 0.1 : 0.02) * effect);
  EXPECT_GT(reduction::compare(full, reduced(meshed::reduced())).max_um, 0.8 * effect)
      << "without its parts the model cannot know";
}

/// The program as if it had been measured.
diagnosis::Observations along(const solver::LoadProgram& load) {
  diagnosis::Observations plan;
  const std::vector<double> ends = load.step_ends(1.0);
  plan.points = Eigen::VectorXd::Zero(std::ssize(ends) + 1);
  for (Eigen::Index i = 0; i < std::ssize(ends); ++i) {
    plan.points[i + 1] = ends[i];
    const Eigen::VectorXd row = load.row(plan.points[i], ends[i]);
    plan.rows.conservativeResize(i + 1, row.size());
    plan.rows.row(i) = row.transpose();
  }
  plan.end = ends.back();
  plan.start_C = load.initial_C();
  return plan;
}

// What another measurement would show of a cause holds its effect on the output rows.
TEST_P(ChangedMachine, IsSeenElsewhere) {
  const Change& change = GetParam();
  const diagnosis::MachineInTime machine(meshed::machine());
  const diagnosis::MachineInTime changed =
      diagnosis::with_parameter(machine, diagnosis::make_parameter(change.kind, change.where), change.value);
  const diagnosis::Observations plan = along(meshed::load(machine, "shift", meshed::shift));
  const diagnosis::Response response(meshed::reduced(), plan);
  const auto poses = mesh::workspace_poses(machine);
  const auto count = 3 * std::ssize(poses);
  const Eigen::MatrixXd here = response.elsewhere(machine, poses), there = response.elsewhere(changed, poses);
  EXPECT_GT((there - here).rightCols(count).cwiseAbs().maxCoeff(), 0.8 * change.least_um);
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, ChangedMachine,
    ::testing::Values(Change{Kind::expansion_coefficient, "column", 1.3, 1},
                      Change{Kind::expansion_coefficient, "bed", 0.8, 1}, Change{Kind::heat_capacity, "head", 1.6, 1},
                      Change{Kind::heat_capacity, "column", 0.6, 1},
                      Change{Kind::expansion_coefficient, "iron", 1.3, 1}, Change{Kind::heat_capacity, "iron", 0.8, 1},
                      Change{Kind::scale_expansion, "Z", 0.4, 0.5}, Change{Kind::screw_expansion, "X", 1.3, 1},
                      Change{Kind::contact_stiffness, "feet", 0.4, 0.2},
                      Change{Kind::contact_stiffness, "X_guide", 2.0, 0.2}));

}  // namespace
