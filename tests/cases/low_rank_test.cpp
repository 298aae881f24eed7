// SPDX-License-Identifier: GPL-3.0-or-later
// The core of `compensate`, with terms in low rank, beside the class with dense terms, on a held-out load.
#include <gtest/gtest.h>

#include <cmath>

#include "compensation/control/online_twin.h"
#include "compensation/online/compensator.h"
#include "core/table.h"
#include "reduction/model/model_file.h"
#include "tests/cases/toy.h"

namespace thermotwin::cases {
namespace {

using Eigen::VectorXd;

TEST(LowRank, OffsetsOfAHeldOutLoadAreThoseOfTheDenseModel) {
  const reduction::ReducedModel model = reduction::read_model(toy_model());
  const core::Table inputs = core::read_csv(toy_run() / "campaign/mixed/inputs.csv"),
                    readings = core::read_csv(toy_run() / "campaign/mixed/sensors.csv");
  ASSERT_EQ(inputs.rows(), readings.rows());
  for (const bool sensors : {false, true}) {
    compensation::ControlOptions options;
    options.observer = true;
    options.compensator.use_sensors = sensors;
    compensation::OnlineTwin core(model, options);
    compensation::Compensator dense(model, options.compensator);
    double apart_um = 0.0, most_um = 0.0;
    for (Eigen::Index i = 0; i < inputs.rows(); ++i) {
      VectorXd row = core.channels().defaults(), sensed(readings.values.cols() - 1);
      for (std::size_t c = 1; c < inputs.columns.size(); ++c)
        row[core.channels().index(inputs.columns[c])] = inputs.values(i, static_cast<Eigen::Index>(c));
      sensed = readings.values.row(i).tail(sensed.size()).transpose();
      const double time = inputs.values(i, 0);
      const VectorXd offsets = core.step(time, row, sensed).offset_um, truth = dense.step(time, row, sensed).offset_um;
      apart_um = std::max(apart_um, (offsets - truth).cwiseAbs().maxCoeff());
      most_um = std::max(most_um, truth.cwiseAbs().maxCoeff());
    }
    EXPECT_GT(most_um, 10.0) << sensors;
    EXPECT_LE(apart_um, 0.01) << sensors;
    std::printf("  offsets up to %.1f um differ by at most %.2g um\n", most_um, apart_um);
  }
}

}  // namespace
}  // namespace thermotwin::cases
