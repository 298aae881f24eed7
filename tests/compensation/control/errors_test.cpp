// SPDX-License-Identifier: GPL-3.0-or-later
// The filter of the online core beside the class that it restates, on the same inputs.
#include "compensation/control/errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "compensation/online/error_model.h"
#include "core/missing.h"
#include "solver/operation/operating_model.h"
#include "tests/compensation/control/observer_parts.h"
#include "tests/compensation/control/unit_capacity.h"
#include "tests/compensation/shift.h"

namespace thermotwin::compensation {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const reduction::ReducedModel& nominal() {
  static const reduction::ReducedModel model = test::unit_capacity(test::lumped_model());
  return model;
}

/// Both filters, with the same calls.
class Pair {
public:
  Pair() : classic(nominal()), parts(nominal(), {}, drives()), core(tt_errors_lay, parts.sensors()) {
    classic.work_ends_at(operating.channels().defaults());
  }

  int drives() const { return static_cast<int>(classic.drives().size()); }
  const tt_sensor_model& model() const { return parts.sensors(); }

  void start(double uniform_K, const std::vector<FirstReading>& readings, double air_gap_K = 0.0) {
    VectorXd gap = VectorXd::Zero(std::ssize(nominal().machine.ambients));
    gap[0] = air_gap_K;
    classic.start(uniform_K, readings, gap);
    const MatrixXd patterns = classic.before().patterns(uniform_K, readings);
    tt_errors_start(core.get(), uniform_K, static_cast<int>(patterns.cols()), patterns.data(), gap.data());
    shapes = patterns.cols();
  }

  /// An interval of the shift that ends at this time.
  void advance(double time, double duration) {
    const VectorXd row = test::shift_row(operating.channels(), time - 0.5 * duration);
    const VectorXd inlet = VectorXd::Zero(std::ssize(nominal().machine.coolants));
    const solver::Coefficients c = operating.coefficients(row, inlet);
    ErrorModel::Interval interval{duration, c.p, c.q, nominal().system.one_kelvin * (0.001 * time / 60.0), {}};
    for (Index i = 0; i < interval.state.size(); ++i) interval.state[i] *= 1.0 + 0.3 * std::sin(i + time / 3000.0);
    interval.operator_matrix = operator_at(c.p);
    classic.advance(interval);
    const tt_interval same = {duration, interval.p.data(), interval.q.data(), interval.state.data(),
                              interval.operator_matrix.data()};
    tt_errors_begin_advance(core.get(), &same);
    run_slices();
    tt_errors_finish_advance(core.get());
  }

  void foresee(double duration) {
    const VectorXd inlet = VectorXd::Zero(std::ssize(nominal().machine.coolants));
    const solver::Coefficients c = operating.coefficients(operating.channels().defaults(), inlet);
    ErrorModel::Interval ahead;
    ahead.duration = duration;
    ahead.operator_matrix = operator_at(c.p);
    classic.foresee(ahead);
    tt_sensitivities_begin_foresight(&core->sensitivities, duration, ahead.operator_matrix.data());
    run_slices();
    tt_sensitivities_finish(&core->sensitivities);
  }

  void update(const std::vector<ErrorModel::Innovation>& innovations, double independent_s) {
    classic.update(innovations, independent_s);
    for (const ErrorModel::Innovation& one : innovations) {
      const tt_innovation same = {static_cast<std::int32_t>(one.sensor), one.value, one.moment, one.deviation_K};
      tt_errors_observe(core.get(), &same, independent_s);
    }
    tt_errors_settle(core.get());
  }

  void untold(int drive, bool is_untold, double speed) {
    const VectorXd heat = is_untold ? VectorXd(0.7 * classic.drives()[drive].heat) : VectorXd();
    classic.set_untold(drive, heat, speed);
    tt_errors_set_untold(core.get(), drive, is_untold ? heat.data() : nullptr, speed);
    if (is_untold && std::find(known.begin(), known.end(), drive) == known.end()) known.push_back(drive);
  }

  void learn(const Eigen::Vector3d& error) {
    ErrorModel::ErrorRows rows;
    rows.tool = nominal().outputs.tool[3].topRows(3);
    rows.table = -nominal().outputs.table_axis[1].topRows(3);
    const VectorXd state = 2.0 * nominal().system.one_kelvin;
    classic.learn(rows, state, error, 0.5e-6);
    const MatrixXd tool = rows.tool.transpose(), table = rows.table.transpose();
    tt_errors_learn(core.get(), tool.data(), table.data(), state.data(), error.data(), 0.5e-6);
  }

  /// Where the numbers of the class are among those of the core.
  std::vector<Index> places() const {
    std::vector<Index> at;
    for (Index k = 0; k < model().quantities; ++k) at.push_back(k);
    for (const int drive : known) at.push_back(model().quantities + drive);
    for (Index k = 0; k <= shapes; ++k) at.push_back(tt_first_start(&model()) + k);
    for (Index k = tt_errors_first_bias(&model()); k < tt_errors_count(&model()); ++k) at.push_back(k);
    return at;
  }

  void expect_equal(const char* after) {
    const std::vector<Index> at = places();
    const int all = tt_errors_count(&model()), order = model().order, columns = tt_columns(&model());
    const Eigen::Map<const MatrixXd> sigma(core->sigma, all, all);
    ASSERT_EQ(classic.all_covariance().rows(), std::ssize(at)) << after;
    for (Index i = 0; i < std::ssize(at); ++i) {
      for (Index j = 0; j < std::ssize(at); ++j) {
        const double size = core->prior[at[i]] * core->prior[at[j]];
        EXPECT_NEAR(classic.all_covariance()(i, j), sigma(at[i], at[j]), tolerance * size) << after << i << " " << j;
      }
    }
    const Eigen::Map<const MatrixXd> directions(core->sensitivities.directions, order, columns);
    const MatrixXd wanted =
        directions(Eigen::all, std::vector<Index>(at.begin(), at.begin() + classic.directions().cols()));
    for (Index k = 0; k < wanted.cols(); ++k) {
      const double size = classic.directions().col(k).norm();
      EXPECT_LE((wanted.col(k) - classic.directions().col(k)).norm(), tolerance * size) << after << k;
    }
    EXPECT_NEAR(directions.norm(), wanted.norm(), 1e-12 * wanted.norm()) << after << ": columns of nothing";
    expect_states_equal(after, at);
    expect_corrections_equal(after);
  }

  solver::OperatingModel operating{nominal().machine, nominal().system.layout};
  ErrorModel classic;
  test::ObserverParts parts;
  test::InArena<tt_errors, tt_sensor_model> core;
  Index shapes = 0;
  std::vector<int> known;  ///< drives, in the order in which they were first untold
  static constexpr double tolerance = 1e-9;

private:
  static MatrixXd operator_at(const VectorXd& p) {
    MatrixXd matrix = nominal().system.conduction;
    for (Index j = 0; j < p.size(); ++j) matrix += p[j] * nominal().system.terms[j];
    return matrix;
  }

  void run_slices() {
    int slices = 1;
    while (tt_sensitivities_slice(&core->sensitivities) == 0) ++slices;
    EXPECT_LE(slices, tt_sensitivities_slices(&model()));
  }

  void expect_states_equal(const char* after, const std::vector<Index>& at) const {
    std::size_t i = 0;
    for (const ErrorModel::State& state : classic.states()) {
      // The class leaves out what is observed beside the sensors.
      const Index first_beside = tt_errors_first_bias(&model()) + model().measured;
      if (at[i] == first_beside) i += model().sensors - model().measured;
      EXPECT_NEAR(state.value, (*core_ptr()).theta[at[i]], tolerance * state.prior_std) << after << state.name;
      EXPECT_NEAR(state.prior_std, (*core_ptr()).prior[at[i]], 1e-14 * state.prior_std) << after << state.name;
      EXPECT_EQ(state.memory_s, (*core_ptr()).memory[at[i]]) << after << state.name;
      ++i;
    }
  }

  void expect_corrections_equal(const char* after) {
    const int order = model().order;
    VectorXd value(order), seen(model().sensors);
    const auto near = [&](const VectorXd& classic_value, const VectorXd& own, double size) {
      EXPECT_LE((classic_value - own).norm(), tolerance * (classic_value.norm() + size)) << after;
    };
    tt_errors_correction(core.get(), value.data());
    near(classic.correction(), value, 1e-3);
    tt_errors_correction_rate(core.get(), value.data());
    near(classic.correction_rate(), value, 1e-6);
    tt_errors_sensor_correction(core.get(), seen.data());
    near(classic.sensor_correction(), seen, 1e-3);
    tt_errors_sensor_correction_rate(core.get(), seen.data());
    near(classic.sensor_correction_rate(), seen, 1e-6);
    tt_errors_sensor_rate_std(core.get(), seen.data());
    near(classic.sensor_rate_std(), seen, 1e-6);
    VectorXd shares(tt_outputs);
    tt_errors_output_shares(core.get(), shares.data());
    const ErrorModel::OutputShares classic_shares = classic.output_shares();
    EXPECT_LE((shares.head<3>() - classic_shares.tool).norm(), tolerance * 0.03) << after;
    EXPECT_LE((shares.segment<3>(3) - classic_shares.table).norm(), tolerance * 0.03) << after;
    EXPECT_LE((shares.tail<3>() - classic_shares.rest).norm(), tolerance * 1e-6) << after;
    for (int s = 0; s < model().measured; ++s) {
      const ErrorModel::SensorOffset offset = classic.offset(s);
      const tt_sensor_offset own = tt_errors_offset(core.get(), s);
      EXPECT_NEAR(own.value, offset.value, 1e-6 * (std::abs(offset.value) + model().sensor_std[s])) << after << s;
      if (std::isfinite(offset.std))
        EXPECT_NEAR(own.std, offset.std, 1e-6 * offset.std) << after << s;
      else
        EXPECT_EQ(own.std, offset.std) << after << s;
    }
  }

  const tt_errors* core_ptr() const { return const_cast<Pair*>(this)->core.get(); }
};

std::vector<ErrorModel::Innovation> innovations(const Pair& pair, double time) {
  std::vector<ErrorModel::Innovation> all;
  for (Index s = 0; s < pair.model().measured; ++s) {
    if (std::fmod(time / 300.0 + s, 5.0) < 1.0) continue;  // one that is missing now and then
    const double value = 0.2 * std::sin(0.7 * s + time / 5000.0) + (s == 2 ? time * 2e-5 : 0.0);
    all.push_back({s, value, 0.4 + 0.02 * s, 3.0 + 0.1 * s});
  }
  return all;
}

TEST(ControlErrors, HasTheQuantitiesOfTheClass) {
  Pair pair;
  EXPECT_GT(pair.model().quantities, 10);
  EXPECT_GT(pair.drives(), 2);
  EXPECT_GE(pair.model().air, 0);
  pair.start(0.1, {{0, 0.5}, {1, 0.2}, {3, -0.1}}, 1.5);
  pair.expect_equal("start ");
}

TEST(ControlErrors, LearnsWhatTheClassLearns) {
  Pair pair;
  pair.start(0.2, {{0, 0.5}, {1, 0.2}, {3, -0.1}});
  pair.update(innovations(pair, 0.0), 0.0);
  pair.foresee(60.0);
  pair.expect_equal("foresight ");
  double time = 0.0;
  for (int i = 0; i < 60; ++i) {
    const double duration = i < 10 ? 60.0 : 300.0;
    time += duration;
    if (i == 20 || i == 45) pair.untold(1, true, 0.8);
    if (i == 25) pair.untold(0, true, 0.0);
    if (i == 40) pair.untold(1, false, 0.0);
    pair.advance(time, duration);
    pair.update(innovations(pair, time), duration);
    if (i % 12 == 0) pair.expect_equal("advance ");
  }
  pair.expect_equal("end ");
}

TEST(ControlErrors, LearnsFromProbingAndReleasesASensor) {
  Pair pair;
  pair.start(0.2, {});
  double time = 0.0;
  for (int i = 0; i < 12; ++i) {
    time += 300.0;
    pair.advance(time, 300.0);
    pair.update(innovations(pair, time), 300.0);
    if (i == 4) pair.learn({12e-6, core::missing, -5e-6});
    if (i == 5) pair.expect_equal("probed ");
    if (i == 8) pair.learn({400e-6, 3e-6, 2e-6});
    pair.classic.show(100.0);
    tt_errors_show(pair.core.get(), 100.0);
  }
  pair.classic.release(2);
  tt_errors_release(pair.core.get(), 2);
  pair.expect_equal("released ");
}

TEST(ControlErrors, AnAirThatNobodyTellsIsLessCertain) {
  Pair pair;
  pair.classic.air_is_untold();
  tt_errors_air_is_untold(pair.core.get());
  pair.start(0.2, {});
  EXPECT_EQ(pair.core->prior[pair.model().air], 2.0);
  pair.expect_equal("start ");
}

// An equal interval needs no new factor: fewer slices, the same bits.
TEST(ControlErrors, UsesAFactorAgain) {
  Pair pair;
  pair.start(0.2, {});
  const VectorXd p = VectorXd::Constant(pair.model().terms, 0.3), q = VectorXd::Ones(pair.model().inputs),
                 state = nominal().system.one_kelvin;
  MatrixXd a = nominal().system.conduction;
  for (const MatrixXd& term : nominal().system.terms) a += 0.3 * term;
  const tt_interval interval = {300.0, p.data(), q.data(), state.data(), a.data()};
  const auto advance = [&] {
    tt_errors_begin_advance(pair.core.get(), &interval);
    int slices = 1;
    while (tt_sensitivities_slice(&pair.core->sensitivities) == 0) ++slices;
    tt_errors_finish_advance(pair.core.get());
    return slices;
  };
  const int first = advance();
  const std::vector<double> kept = pair.core.block();
  const int second = advance();
  EXPECT_LT(second, first);
  const MatrixXd once =
      Eigen::Map<MatrixXd>(pair.core->sensitivities.directions, pair.model().order, tt_columns(&pair.model()));
  pair.core.block() = kept;  // the state is the block: it goes on from a copy with the same bits
  pair.core->sensitivities.numbers[1] = 0.0;
  EXPECT_EQ(advance(), first);
  const MatrixXd again =
      Eigen::Map<MatrixXd>(pair.core->sensitivities.directions, pair.model().order, tt_columns(&pair.model()));
  EXPECT_TRUE(once == again);
}

}  // namespace
}  // namespace thermotwin::compensation
