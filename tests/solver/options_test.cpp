// SPDX-License-Identifier: GPL-3.0-or-later
// Options out of range are refused by name where they are used.
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "core/error.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/simulation.h"
#include "solver/elastic/model.h"
#include "solver/export/calculix_deck.h"
#include "solver/linear/multigrid.h"
#include "solver/linear/sparse_factor.h"
#include "solver/linear/spd_solver.h"
#include "solver/operation/time_options.h"
#include "solver/thermal/adaptive.h"
#include "solver/thermal/integrator.h"

namespace thermotwin::solver {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Message of a set of options; empty: they may be used.
template <class Options>
std::string complaint(const Options& options) {
  try {
    options.validate();
  } catch (const core::InputError& error) {
    return error.what();
  }
  return {};
}

/// Expects that the defaults may be used, and that a field's bad value is named.
template <class Options, class Value>
void expect_refused(Value Options::*field, Value bad, const std::string& name) {
  Options options;
  EXPECT_EQ(complaint(options), "");
  options.*field = bad;
  EXPECT_NE(complaint(options).find(name + ":"), std::string::npos) << complaint(options);
}

TEST(Options, BadValuesAreNamed) {
  expect_refused(&SimulationOptions::refine, 0.0, "refine");
  expect_refused(&SimulationOptions::start, Eigen::VectorXd::Constant(2, nan).eval(), "start");
  expect_refused(&CampaignOptions::refine, nan, "refine");
  expect_refused(&CampaignOptions::checkpoint_s, -1.0, "checkpoint_s");
  expect_refused(&CampaignOptions::poses, {mesh::Pose::Constant(3, nan)}, "poses");
  expect_refused(&DeckOptions::refine, -1.0, "refine");
  expect_refused(&DeckOptions::steady_at, nan, "steady_at");
  expect_refused(&ElasticOptions::tolerance, 0.0, "tolerance");
  expect_refused(&MultigridOptions::block, 0, "block");
  expect_refused(&MultigridOptions::tolerance, 2.0, "tolerance");
  expect_refused(&MultigridOptions::max_iterations, 0, "max_iterations");
  expect_refused(&SparseFactorOptions::block, 0, "block");
  expect_refused(&SparseFactorOptions::columns_at_once, 65, "columns_at_once");
  expect_refused(&IntegratorOptions::tolerance, 0.0, "tolerance");
  expect_refused(&IntegratorOptions::max_iterations, 0, "max_iterations");
  expect_refused(&IntegratorOptions::factor_memory, -1.0, "factor_memory");
  expect_refused(&AdaptiveOptions::tolerance, nan, "tolerance");
  expect_refused(&AdaptiveOptions::max_iterations, -1, "max_iterations");
}

TEST(Options, TimeIsCheckedForTheAdaptiveScheme) {
  TimeOptions time{TimeScheme::adaptive, 0.01, 10.0, 5.0};
  EXPECT_NE(complaint(time).find("longest_step: 5;"), std::string::npos) << complaint(time);
  time.scheme = TimeScheme::fixed;  // has steps of the program's own
  EXPECT_EQ(complaint(time), "");
  CampaignOptions campaign;
  campaign.time = {TimeScheme::adaptive, 0.0};
  EXPECT_NE(complaint(campaign).find("tolerance_K"), std::string::npos);
}

TEST(Options, OfASolverAreThoseOfItsKind) {
  SpdOptions options;
  options.multigrid.block = 0;
  EXPECT_EQ(complaint(options), "");
  options.kind = LinearSolver::iterative;
  EXPECT_NE(complaint(options).find("block"), std::string::npos);
}

}  // namespace
}  // namespace thermotwin::solver
