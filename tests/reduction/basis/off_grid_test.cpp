// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/basis/off_grid.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/reduced_simulation.h"
#include "solver/campaign/full_model.h"
#include "solver/campaign/load_result.h"
#include "tests/core/temporary_folder.h"
#include "tests/machines/boxes.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr const char* load_text = R"(
schema = 1
initial_C = 20.0
time_step_s = 120
output_s = 600
[[phase]]
name = "warm up"
duration_h = 2
spindle_rpm = 9000
air_C = [20, 24]
)";

struct Boxes {
  solver::FullModel full;
  std::vector<solver::LoadProgram> loads;
  std::vector<solver::LoadResult> results;
  ReducedModel model;
  ReduceSummary summary;

  Boxes() : full(test::boxes()) {
    core::set_quiet(true);
    loads.push_back(solver::LoadProgram::parse(load_text, "warm_up.toml", full.mesh.machine));
    solver::CampaignOptions options;
    options.keep_snapshots = true;
    results = run_campaign(full, loads, options);
    model = reduce(full, loads, results, {.order = 20, .parts = false}, &summary);
  }
};
const Boxes& boxes() {
  static const Boxes made;
  return made;
}

TEST(OffGrid, PosesAreInTheWorkspaceAndAlwaysTheSame) {
  const mesh::Machine& machine = boxes().full.mesh.machine;
  const auto poses = random_poses(machine, 50), again = random_poses(machine, 50),
             other = random_poses(machine, 50, 21);
  EXPECT_EQ(poses, again);
  EXPECT_NE(poses, other);
  double low = 1, high = -1;
  for (const mesh::Pose& pose : poses) {
    for (std::size_t i = 0; i < machine.workspace.axes.size(); ++i) {
      const auto& positions = machine.workspace.positions[i];
      const double at = pose(machine.axis_index(machine.workspace.axes[i]));
      const double share = (at - positions.front()) / (positions.back() - positions.front());
      ASSERT_GE(share, 0.0);
      ASSERT_LE(share, 1.0);
      low = std::min(low, share), high = std::max(high, share);
    }
  }
  EXPECT_LT(low, 0.1);
  EXPECT_GT(high, 0.9);
}

TEST(OffGrid, AtStoredPosesIsTheErrorThatIsKnownThere) {
  const Boxes& b = boxes();
  const mesh::Machine& machine = b.full.mesh.machine;
  const FullRows grid = full_rows(b.full, mesh::workspace_poses(machine));
  const auto truth = off_grid_truth(machine, grid, b.results[0].snapshots);
  const OffGridErrors errors = off_grid_errors(b.model, b.summary.basis, machine, b.loads[0], truth, grid);
  const ReductionErrors known = compare(b.results[0], simulate_reduced(b.model, machine, b.loads[0], grid.poses));
  EXPECT_NEAR(errors.max_um(), known.max_um, 1e-6 * known.max_um + 1e-9);
  EXPECT_NEAR(errors.peak_um(), known.peak_um, 1e-9 * known.peak_um);
  // Stored rows are these poses' own, but for what the table's side has interpolated.
  EXPECT_NEAR(errors.own_rows_um(), errors.max_um(), 0.05 * errors.max_um());
}

TEST(OffGrid, BetweenThemInterpolationAddsToTheReduction) {
  const Boxes& b = boxes();
  const mesh::Machine& machine = b.full.mesh.machine;
  const FullRows between = full_rows(b.full, random_poses(machine, 6));
  const auto truth = off_grid_truth(machine, between, b.results[0].snapshots);
  OffGridErrors errors = off_grid_errors(b.model, b.summary.basis, machine, b.loads[0], truth, between);
  EXPECT_LT(
      errors.own_rows_um(),
      3.0 *
          compare(b.results[0], simulate_reduced(b.model, machine, b.loads[0], mesh::workspace_poses(machine))).max_um);
  // A model whose stored rows are wrong in the middle errs between the poses, its own rows do not.
  ReducedModel broken = b.model;
  for (MatrixXd& rows : broken.outputs.tool) rows *= 1.1;
  const OffGridErrors off = off_grid_errors(broken, b.summary.basis, machine, b.loads[0], truth, between);
  EXPECT_GT(off.max_um(), 0.02 * off.peak_um());
  EXPECT_EQ(off.own_rows, errors.own_rows);
  const core::TemporaryFolder scratch;
  write_off_grid(scratch.path() / "off_grid.csv", machine, between.poses, {errors});
  const std::string text = core::read_file(scratch.path() / "off_grid.csv");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 7);
  EXPECT_NE(text.find("\nwarm_up,"), std::string::npos);
  EXPECT_THROW(off_grid_errors(b.model, MatrixXd(b.summary.basis.leftCols(3)), machine, b.loads[0], truth, between),
               core::InputError);
}

}  // namespace
}  // namespace thermotwin::reduction
