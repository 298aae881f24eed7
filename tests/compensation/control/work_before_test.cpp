// SPDX-License-Identifier: GPL-3.0-or-later
// Earlier work in the online core beside the class that it restates.
#include "compensation/control/work_before.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "compensation/online/error_model.h"
#include "tests/compensation/control/day_of_work.h"
#include "tests/compensation/control/observer_parts.h"
#include "tests/compensation/control/unit_capacity.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::Day;

const reduction::ReducedModel& nominal() {
  static const reduction::ReducedModel model = test::unit_capacity(test::lumped_model());
  return model;
}

/// Both, with the modes of the machine at its default positions.
class Both {
public:
  Both()
      : parts_(nominal(), {}, 0),
        before(nominal(), test::ambients_of(nominal())),
        heats_(day_.heats()),
        model_{&parts_.sensors(), static_cast<std::int32_t>(heats_.cols())},
        core(tt_past_lay, model_) {
    before.ends_at(day_.rest());
    tt_past_set_heats(core.get(), heats_.data());
    for (const auto& [kind, row] :
         {std::pair{TT_MODES_COOLING, &day_.off()}, {TT_MODES_STILL, &day_.rest()}, {TT_MODES_SWEPT, &day_.swept()}}) {
      const MatrixXd matrix = day_.operator_at(*row);
      tt_past_begin_modes(core.get(), kind, matrix.data());
      run();
    }
  }

  void run() {
    int slices = 1;
    while (tt_past_slice(core.get()) == 0) ++slices;
    EXPECT_EQ(tt_past_slice(core.get()), 1);
    EXPECT_LE(slices, tt_past_slices(&model_));
  }

  void offer(const std::vector<FirstReading>& readings, const UniformStart& start, bool predicts = false, int at = 0) {
    std::vector<std::int32_t> sensor;
    std::vector<double> value;
    for (const FirstReading& reading : readings) {
      sensor.push_back(static_cast<std::int32_t>(reading.sensor));
      value.push_back(reading.value);
    }
    const tt_first_readings same = {static_cast<std::int32_t>(sensor.size()), sensor.data(), value.data(), start.middle,
                                    start.std};
    tt_past_begin_offers(core.get(), &same, predicts, at);
    run();
  }

  /// Patterns are the same up to their signs, and up to a turn of those of equal size: their squares are compared.
  void expect_patterns(const MatrixXd& wanted) {
    tt_past_begin_patterns(core.get());
    run();
    ASSERT_EQ(tt_past_shapes(core.get()), wanted.cols());
    const Eigen::Map<const MatrixXd> own(core->patterns, wanted.rows(), wanted.cols());
    const MatrixXd square = wanted * wanted.transpose();
    EXPECT_LT((own * own.transpose() - square).norm(), 1e-9 * square.norm());
    for (Index k = 0; k < wanted.cols(); ++k) {
      EXPECT_NEAR(own.col(k).norm(), wanted.col(k).norm(), 1e-9 * wanted.col(0).norm()) << k;
    }
  }

private:
  Day day_{nominal()};
  test::ObserverParts parts_;

public:
  WorkBefore before;

private:
  MatrixXd heats_;
  tt_past_model model_;

public:
  test::InArena<tt_past, tt_past_model> core;
};

const std::vector<FirstReading> warm = {{0, 0.4}, {1, 1.7}, {2, 0.9}, {3, 0.1}, {4, 3.0}};

TEST(ControlWorkBefore, WeighsReadingsAsTheClassDoes) {
  Both both;
  for (const std::size_t count : {1U, 3U, 5U}) {
    for (const double uniform_K : {0.03, 0.5}) {
      const std::vector<FirstReading> readings(warm.begin(), warm.begin() + count);
      both.offer(readings, {0.0, uniform_K});
      EXPECT_NEAR(tt_past_weigh(both.core.get()), both.before.log_evidence(uniform_K, readings), 1e-8);
      both.expect_patterns(both.before.patterns(uniform_K, readings));
    }
  }
}

TEST(ControlWorkBefore, WithoutReadingsTakesWhatSensorsDifferByUsually) {
  Both both;
  tt_past_unmeasured(both.core.get());
  both.expect_patterns(both.before.patterns(0.5, {}));
}

TEST(ControlWorkBefore, JudgesAReadingByTheOthers) {
  Both both;
  const std::vector<UniformStart> starts = {{0.2, 0.1}, {0.0, 0.5}, {1.0, 0.05}};
  for (const double value : {0.3, 2.0, 8.0, 25.0}) {
    const FirstReading reading{3, value};
    std::vector<FirstReading> others{warm[0], warm[1], warm[2], warm[4]}, all = others;
    all.push_back(reading);
    for (int i = 0; i < std::ssize(starts); ++i) both.offer(all, starts[i], true, i);
    const double chance = both.before.chance(starts, others, reading), own = tt_past_chance(both.core.get(), 3);
    EXPECT_NEAR(own, chance, 1e-8 * chance + 1e-16) << value;
  }
}

}  // namespace
}  // namespace thermotwin::compensation
