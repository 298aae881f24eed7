// SPDX-License-Identifier: GPL-3.0-or-later
// Options that make no sense are refused by name, value and what is allowed.

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>

#include "core/error.h"
#include "reduction/basis/observer_noise.h"
#include "reduction/basis/reduce.h"
#include "reduction/basis/responses.h"
#include "reduction/bound/model.h"
#include "reduction/model/exact_stepper.h"
#include "reduction/systems/identify.h"
#include "reduction/systems/low_rank_adi.h"
#include "reduction/systems/system_reduction.h"

namespace thermotwin::reduction {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

template <class Options>
void expect_refused(Options options, const std::function<void(Options&)>& spoil, const std::string& field) {
  EXPECT_NO_THROW(options.validate());
  spoil(options);
  try {
    options.validate();
    ADD_FAILURE() << field << " was accepted";
  } catch (const core::InputError& error) {
    EXPECT_NE(std::string(error.what()).find(field + ": "), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("; allowed: "), std::string::npos) << error.what();
  }
}

TEST(ReductionOptions, AreChecked) {
  expect_refused<StepperOptions>(
      {}, [](auto& o) { o.refresh_tolerance = nan; }, "refresh_tolerance");
  expect_refused<ExactOptions>(
      {}, [](auto& o) { o.passing.refresh_tolerance = -1.0; }, "refresh_tolerance");
  expect_refused<ReduceOptions>(
      {}, [](auto& o) { o.tolerance_um = 0.0; }, "tolerance_um");
  expect_refused<ReduceOptions>(
      {}, [](auto& o) { o.max_order = 0; }, "max_order");
  expect_refused<ReduceOptions>(
      {}, [](auto& o) { o.order = -1; }, "order");
  expect_refused<ReduceOptions>(
      {}, [](auto& o) { o.patches = -1; }, "patches");
  expect_refused<CandidateOptions>(
      default_candidates(), [](auto& o) { o.shifts.clear(); }, "shifts");
  expect_refused<CandidateOptions>(
      default_candidates(), [](auto& o) { o.adjoint_shifts = {-1.0}; }, "shifts");
  expect_refused<ObserverOptions>(
      {}, [](auto& o) { o.interval_s = 0.0; }, "interval_s");
  expect_refused<ObserverOptions>(
      {}, [](auto& o) { o.unstated_share = nan; }, "unstated_share");
}

TEST(SystemOptions, AreChecked) {
  expect_refused<SolverOptions>(
      {}, [](auto& o) { o.dense_limit = -1; }, "dense_limit");
  expect_refused<SolverOptions>(
      {}, [](auto& o) { o.residual = 0.0; }, "residual");
  expect_refused<AdiOptions>(
      {}, [](auto& o) { o.residual = 2.0; }, "residual");
  expect_refused<AdiOptions>(
      {}, [](auto& o) { o.most_steps = 0; }, "most_steps");
  expect_refused<SystemReductionOptions>(
      {}, [](auto& o) { o.tolerance = nan; }, "--tolerance");
  expect_refused<SystemReductionOptions>(
      {}, [](auto& o) { o.order = -2; }, "--order");
  expect_refused<IdentifyOptions>(
      {}, [](auto& o) { o.order = -1; }, "order");
  expect_refused<IdentifyOptions>(
      {}, [](auto& o) { o.lags = 0; }, "lags");
}

TEST(BoundOptions, AreChecked) {
  expect_refused<ProbeOptions>(
      {}, [](auto& o) { o.count = -1; }, "count");
  expect_refused<ProbeOptions>(
      {}, [](auto& o) { o.failure = 1.0; }, "failure");
  expect_refused<BoundOptions>(
      {}, [](auto& o) { o.dual = -1; }, "dual");
  expect_refused<BoundOptions>(
      {}, [](auto& o) { o.most_dual = 0; }, "most_dual");
  expect_refused<BoundOptions>(
      {},
      [](auto& o) {
        o.steps_s = {60.0, 0.0};
      },
      "steps_s");
  expect_refused<BoundOptions>(
      {}, [](auto& o) { o.probes.failure = 0.0; }, "failure");
}

}  // namespace
}  // namespace thermotwin::reduction
