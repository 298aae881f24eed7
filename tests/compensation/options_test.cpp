// SPDX-License-Identifier: GPL-3.0-or-later
// Options that make no sense are refused by name, value and what is allowed.

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>

#include "compensation/chain/location_offsets.h"
#include "compensation/evaluation/evaluate.h"
#include "compensation/evaluation/validation.h"
#include "compensation/measurement/virtual_measurement.h"
#include "compensation/online/compensator.h"
#include "compensation/online/offset_guard.h"
#include "core/error.h"

namespace thermotwin::compensation {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

template <class Options>
void expect_refused(const std::function<void(Options&)>& spoil, const std::string& field) {
  Options options;
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

TEST(CompensationOptions, AreChecked) {
  expect_refused<CompensatorOptions>([](auto& o) { o.step_s = 0.0; }, "step_s");
  expect_refused<CompensatorOptions>([](auto& o) { o.correction_s = nan; }, "correction_s");
  expect_refused<CompensatorOptions>([](auto& o) { o.largest_um = 1e6; }, "largest_um");
  expect_refused<CompensatorOptions>([](auto& o) { o.rate_um_s = -1.0; }, "rate_um_s");
  expect_refused<StreamOptions>([](auto& o) { o.probe_std_um = 0.0; }, "std_um");
  expect_refused<GuardOptions>([](auto& o) { o.largest_um = -1.0; }, "largest_um");
  expect_refused<GuardOptions>([](auto& o) { o.rate_um_s = 0.0; }, "rate_um_s");
  expect_refused<GuardOptions>([](auto& o) { o.hold_s = nan; }, "hold_s");
  expect_refused<OffsetOptions>([](auto& o) { o.table_radius = 0.0; }, "table radius");
}

TEST(EvaluationOptions, AreChecked) {
  expect_refused<EvaluateOptions>([](auto& o) { o.train_until_s = nan; }, "train_until_s");
  expect_refused<ValidationOptions>([](auto& o) { o.draws = 0; }, "draws");
  expect_refused<ValidationOptions>([](auto& o) { o.machine.refine = 0.0; }, "refine");
  expect_refused<VirtualOptions>([](auto& o) { o.size_factor = nan; }, "size_factor");
  expect_refused<VirtualOptions>([](auto& o) { o.sensor_noise_K = -0.1; }, "sensor_noise_K");
  expect_refused<VirtualOptions>([](auto& o) { o.probe_noise_um = -0.1; }, "probe_noise_um");
}

}  // namespace
}  // namespace thermotwin::compensation
