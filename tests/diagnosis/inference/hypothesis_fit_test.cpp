// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/inference/hypothesis_fit.h"

#include <gtest/gtest.h>

#include <iterator>

#include "diagnosis/causes/parameter.h"
#include "diagnosis/inference/switch_times.h"
#include "diagnosis/response/problem.h"
#include "diagnosis/response/response.h"
#include "tests/diagnosis/diagnosed_rods.h"

namespace {

using namespace thermotwin;
using diagnosis::Kind;
using diagnosis::LinearForm, diagnosis::Parameter, diagnosis::Problem;
using Eigen::Index;
using Eigen::VectorXd;

int index_of(const Problem& problem, Kind kind, const std::string& where) {
  for (std::size_t i = 0; i < problem.parameters.size(); ++i)
    if (problem.parameters[i].kind == kind && problem.parameters[i].where == where) return static_cast<int>(i);
  return -1;
}

/// How much of what a second cause does beside a strong first one a linear form about the first one misses.
class BesideAStrongCause : public ::testing::TestWithParam<Kind> {
protected:
  /// @param other  value of head.film, about which all is linearised, and which it has
  void expect_seen(double other) {
    diagnosis::Seen seen = diagnosis::see(lumped::coarse_model(), lumped::measure({}, {.hours = 18}), {});
    const mesh::Machine& machine = lumped::coarse_model().machine;
    const int film = index_of(seen.problem, Kind::film_coefficient, "head.film");
    ASSERT_GE(film, 0);
    VectorXd around = VectorXd::Zero(seen.problem.around.size());
    around[film] = other - 1.0;
    Problem problem = diagnosis::make_problem(machine, lumped::measure({}, {.hours = 18}), *seen.observations,
                                              *seen.response, {}, around);
    const Kind kind = GetParam();
    const int first = index_of(problem, Kind::source_power, "motor"),
              second = index_of(problem, kind, kind == Kind::sensor_detached ? "T5_reading" : "main.jacket");
    ASSERT_GE(first, 0);
    ASSERT_GE(second, 0);
    const double motor = 3.0, amount = problem.nominal[second] + (kind == Kind::sensor_detached ? 0.4 : 0.02);
    const auto parameter = [&](int i) { return problem.parameters[i]; };
    const mesh::Machine warm = diagnosis::with_parameter(problem.machine_around(machine, {}), parameter(first), motor);
    problem.measured = seen.response->predict(diagnosis::with_parameter(warm, parameter(second), amount));
    diagnosis::Hypothesis h;
    h.members = {first};
    h.value = VectorXd::Constant(1, motor);
    h.std = VectorXd::Constant(1, 0.1);
    diagnosis::linearise(h, problem, *seen.response, machine);
    const diagnosis::White white(problem);
    VectorXd size = VectorXd::Zero(std::ssize(problem.parameters));
    size[first] = motor - 1.0;
    size[second] = amount - problem.nominal[second];
    size[film] = other - 1.0;
    const double effect = white.of(problem, problem.measured - seen.response->predict(warm)).norm();
    const auto missed = [&](const LinearForm& form) {
      return (form.residual - form.columns.leftCols(size.size()) * size).norm() / effect;
    };
    EXPECT_LT(missed(diagnosis::form_beside(problem, *seen.response, machine, white, h)), 0.03);
    EXPECT_GT(missed(diagnosis::form_about(problem, white, h)),
              0.2);  // of what the second does to a machine that is nominal
  }
};

TEST_P(BesideAStrongCause, AnotherOneActsOnWhatThatOneMade) { expect_seen(1.0); }
TEST_P(BesideAStrongCause, AlsoWhereOthersAreOffNominal) { expect_seen(1.6); }

INSTANTIATE_TEST_SUITE_P(Kinds, BesideAStrongCause, ::testing::Values(Kind::sensor_detached, Kind::coolant_coupling),
                         [](const auto& test) { return name_of(test.param); });

}  // namespace
