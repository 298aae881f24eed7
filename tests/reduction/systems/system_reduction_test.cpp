// SPDX-License-Identifier: GPL-3.0-or-later
// Systems of other programs, reduced: bounds, true errors, films, files.
#include "reduction/systems/system_reduction.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/file.h"
#include "core/matrix_market.h"
#include "core/progress.h"
#include "reduction/linear/lapack.h"
#include "reduction/systems/system_file.h"
#include "tests/core/temporary_folder.h"
#include "tests/reduction/external_systems.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;

SystemReductionOptions with_order(Index order, Method method = Method::balanced) {
  SystemReductionOptions options;
  options.order = order;
  options.method = method;
  return options;
}

MatrixXcd response(const MatrixXd& e, const MatrixXd& a, const MatrixXd& b, const MatrixXd& c, Complex at) {
  const MatrixXcd pencil = at * e.cast<Complex>() - a.cast<Complex>();
  return c * pencil.partialPivLu().solve(b.cast<Complex>());
}
MatrixXcd response(const StateSpace& s, Complex at) { return response(MatrixXd(s.E), MatrixXd(s.A), s.B, s.C, at); }
MatrixXcd response(const ReducedLinearSystem& s, Complex at) { return response(s.E, s.A, s.B, s.C, at); }

Eigen::VectorXcd poles_of(const MatrixXd& a) { return lapack::schur(a).triangular.diagonal(); }

class Quiet : public testing::Test {
protected:
  void SetUp() override { core::set_quiet(true); }
  void TearDown() override { core::set_quiet(false); }
};
using SystemReductionTest = Quiet;

// With A symmetric and C = B^T the bound is attained, at frequency 0 (W. Q. Liu, V. Sreeram, 1998).
TEST_F(SystemReductionTest, BoundIsSharpForStateSpaceSymmetricSystems) {
  LinearSystem rod = test::rod(80);
  rod.base.C = rod.base.B.transpose();
  for (const Index order : {1, 2, 4}) {
    const PointResult point = reduce_system(rod, with_order(order)).points.front();
    EXPECT_EQ(point.order, order);
    EXPECT_NEAR(point.error.value, point.bound, 1e-9 * point.norm.value) << order;
  }
}

TEST_F(SystemReductionTest, TrueErrorsKeepTheBound) {
  for (const LinearSystem& system : {test::chain(30, true), test::plate(10, 3, 5.0)}) {
    for (const Index order : {4, 10, 16}) {
      const SystemReduction reduction = reduce_system(system, with_order(order));
      const PointResult& point = reduction.points.front();
      EXPECT_TRUE(point.stable);
      EXPECT_LE(point.error.value, point.bound * (1 + 1e-8) + 1e-12 * point.norm.value) << order;
      // No reduced model of this order comes closer than the next Hankel singular value.
      EXPECT_GE(point.error.value, point.hankel(order) * (1 - 1e-3)) << order;
      EXPECT_NEAR((response(system.base, Complex(0, point.error.frequency)) -
                   response(reduction.model, Complex(0, point.error.frequency)))
                          .norm() /
                      point.error.value,
                  1.0, 0.8);
    }
  }
}

// Three resonances at 100, 200 and 400 rad/s and a diagonal that the rest of the model follows.
TEST_F(SystemReductionTest, PenzlsSystemNeedsFewStates) {
  SystemReductionOptions options;
  options.tolerance = 1e-3;
  const SystemReduction reduction = reduce_system(test::penzl(), options);
  const PointResult& point = reduction.points.front();
  EXPECT_LE(point.bound, 1e-3 * point.norm.value);
  EXPECT_LE(point.error.value, point.bound * (1 + 1e-6));
  EXPECT_GT(bound_of(point.hankel, point.order - 1), 1e-3 * point.norm.value);
  EXPECT_LE(point.order, 20);
  // At 100 rad/s: 100 * 2 * Re 1/(1 + 0 i) of its pair, and what the others add.
  const double wanted = std::abs(response(test::penzl().base, Complex(0, 100.0))(0));
  EXPECT_GE(point.norm.value, wanted * (1 - 1e-9));
  for (const double frequency : {100.0, 200.0, 400.0}) {
    const auto pole = std::min_element(point.poles.begin(), point.poles.end(), [&](Complex a, Complex b) {
      return std::abs(a - Complex(-1, frequency)) < std::abs(b - Complex(-1, frequency));
    });
    EXPECT_LT(std::abs(*pole - Complex(-1, frequency)), 0.05) << frequency;
  }
}

TEST_F(SystemReductionTest, LowRankRouteGivesTheSameModel) {
  for (const LinearSystem& system : {test::plate(12, 4), test::plate(12, 2, 10.0), test::penzl()}) {
    SystemReductionOptions options = with_order(10);
    const SystemReduction dense = reduce_system(system, options);
    options.solver = {0, 1e-13};
    const SystemReduction sparse = reduce_system(system, options);
    const PointResult &a = dense.points.front(), &b = sparse.points.front();
    EXPECT_FALSE(b.dense);
    EXPECT_FALSE(b.complete);
    EXPECT_NEAR(a.bound, b.bound, 1e-8 * a.norm.value);
    EXPECT_LT((a.hankel.head(20) - b.hankel.head(20)).norm(), 1e-9 * a.hankel(0));
    // The stand-in finds the peaks that a dense search finds.
    EXPECT_NEAR(a.norm.value, b.norm.value, 1e-6 * a.norm.value);
    EXPECT_NEAR(a.error.value, b.error.value, 1e-2 * a.error.value + 1e-9 * a.norm.value);
    for (const double w : {0.0, 1.0, 30.0}) {
      EXPECT_LT((response(dense.model, Complex(0, w)) - response(sparse.model, Complex(0, w))).norm(),
                1e-8 * a.norm.value);
    }
  }
}

TEST_F(SystemReductionTest, ModalModelsKeepTheirPoles) {
  const LinearSystem system = test::chain(30, false);
  const SystemReduction reduction = reduce_system(system, with_order(10, Method::modal));
  const Eigen::VectorXcd poles = poles_of(MatrixXd(system.base.A));
  for (const Complex& pole : reduction.points.front().poles)
    EXPECT_LT((poles.array() - pole).abs().minCoeff(), 1e-9 * std::abs(pole));
  // A system that is nothing but ten modes is reproduced.
  const SystemReduction all = reduce_system(test::chain(5, true), with_order(10, Method::modal));
  EXPECT_LT(all.points.front().error.value, 1e-10 * all.points.front().norm.value);
}

TEST_F(SystemReductionTest, KrylovModelsInterpolateAtTheirMirroredPoles) {
  LinearSystem system = test::plate(10, 1);
  system.base.C = system.base.C.topRows(1).eval();
  system.base.D = MatrixXd::Zero(1, 1);
  const SystemReduction reduction = reduce_system(system, with_order(6, Method::krylov));
  EXPECT_TRUE(reduction.converged);
  const PointResult& point = reduction.points.front();
  for (const Complex& pole : point.poles) {
    const MatrixXcd full = response(system.base, -pole), reduced = response(reduction.model, -pole);
    EXPECT_LT((full - reduced).norm(), 1e-4 * full.norm()) << pole;
  }
  EXPECT_LT(point.error.value, 5 * point.bound);
}

TEST_F(SystemReductionTest, AllMethodsAreCompared) {
  SystemReductionOptions options = with_order(12);
  options.compare = true;
  const SystemReduction reduction = reduce_system(test::chain(20, true), options);
  std::map<Method, double> last;
  for (const Comparison& row : reduction.comparison) {
    last[row.method] = row.error;
    if (row.method == Method::balanced) {
      EXPECT_LE(row.error, bound_of(reduction.points.front().hankel, row.order) * (1 + 1e-8));
    }
  }
  ASSERT_EQ(last.size(), 3U);
  for (const auto& [method, error] : last) EXPECT_LT(error, reduction.points.front().norm.value) << word(method);
}

TEST_F(SystemReductionTest, EqualValuesAreNotParted) {
  const Eigen::VectorXd values = (Eigen::VectorXd(5) << 4, 2, 2, 1, 1).finished();
  EXPECT_EQ(order_for(values, 4.0), 3);
  EXPECT_EQ(order_for(values, 3.9), 5);
  EXPECT_EQ(order_for(values, 100), 1);
  EXPECT_DOUBLE_EQ(bound_of(values, 3), 4.0);
}

// Bases made at the ends of a film's range serve between them too.
TEST_F(SystemReductionTest, FilmsStayParametersOfTheModel) {
  const LinearSystem system = test::rod_with_film(60);
  SystemReductionOptions options = with_order(6);
  options.points = {{0.0}, {100.0}};
  const SystemReduction joined = reduce_system(system, options);
  options.points = {{0.0}};
  const SystemReduction at_zero = reduce_system(system, options);
  EXPECT_TRUE(joined.joined);
  EXPECT_EQ(at_zero.model.order(), 6);
  for (const double film : {0.0, 3.0, 30.0, 100.0}) {
    const StateSpace full = system.at({film});
    double error = 0, error_of_zero = 0;
    for (const double w : {0.0, 0.3, 3.0, 30.0}) {
      const MatrixXcd g = response(full, Complex(0, w));
      error = std::max(error, (g - response(joined.model.at({film}), Complex(0, w))).norm());
      error_of_zero = std::max(error_of_zero, (g - response(at_zero.model.at({film}), Complex(0, w))).norm());
    }
    EXPECT_LT(error, 1e-4) << film;
    if (film == 100.0) {
      EXPECT_GT(error_of_zero, 10 * error);
    }
    EXPECT_TRUE((poles_of(joined.model.at({film}).A).real().array() < 0).all()) << film;
  }
}

TEST_F(SystemReductionTest, BasesOfUnsymmetricSystemsAreJoinedToo) {
  LinearSystem system = test::chain(20, true);
  system.films.push_back({"damper", test::sparse(40, 40, {{25, 25, -0.1}})});
  SystemReductionOptions options = with_order(16);
  options.points = {{0.0}, {1.0}};
  const SystemReduction joined = reduce_system(system, options);
  EXPECT_GT(joined.model.order(), 16);
  for (const PointResult& point : joined.points) {
    EXPECT_TRUE(point.stable);
    EXPECT_LT(point.error.value, 2 * point.bound);
  }
}

void write(const std::filesystem::path& file, const MatrixXd& matrix) {
  core::write_file(file, core::format_matrix_market(matrix, "test"));
}

void write_folder(const std::filesystem::path& folder, const LinearSystem& system) {
  write(folder / "A.mtx", MatrixXd(system.base.A));
  write(folder / "E.mtx", MatrixXd(system.base.E));
  write(folder / "B.mtx", system.base.B);
  write(folder / "C.mtx", system.base.C);
  for (const ParameterMatrix& film : system.films)
    write(folder / ("A_film_" + film.name + ".mtx"), MatrixXd(film.matrix));
}

TEST_F(SystemReductionTest, FilesHoldTheModel) {
  const core::TemporaryFolder folder;
  write_folder(folder / "full", test::rod_with_film(20));
  write(folder / "full" / "D.mtx", (MatrixXd(2, 1) << 0.5, -2).finished());
  const LinearSystem system = read_linear_system(folder / "full");
  EXPECT_TRUE(system.base.symmetric);
  ASSERT_EQ(system.films.size(), 1U);
  EXPECT_EQ(system.films[0].name, "end");
  const SystemReduction reduction = reduce_system(system, with_order(5));
  core::write_file(folder / "out" / "A_film_old.mtx", "kept where no earlier model is beside it");
  write_system(folder / "out", system, reduction);
  EXPECT_TRUE(std::filesystem::exists(folder / "out" / "A_film_old.mtx"));
  write_system(folder / "out", system, reduction);
  EXPECT_FALSE(std::filesystem::exists(folder / "out" / "A_film_old.mtx")) << "a film that this model has not";

  std::vector<std::string> films;
  const ReducedLinearSystem stored = read_system(folder / "out" / system_file_name, &films);
  EXPECT_EQ(films, std::vector<std::string>{"end"});
  EXPECT_EQ(stored.A, reduction.model.A);
  EXPECT_EQ(stored.films[0], reduction.model.films[0]);
  const LinearSystem again = read_linear_system(folder / "out");
  EXPECT_EQ(MatrixXd(again.base.A), reduction.model.A);
  EXPECT_EQ(again.base.B, reduction.model.B);
  EXPECT_EQ(again.base.C, reduction.model.C);
  EXPECT_EQ(again.base.D, system.base.D);
  EXPECT_EQ(MatrixXd(again.base.E), MatrixXd::Identity(5, 5));
  EXPECT_EQ(MatrixXd(again.films[0].matrix), reduction.model.films[0]);
}

TEST_F(SystemReductionTest, BadFoldersAreRefused) {
  const core::TemporaryFolder folder;
  const LinearSystem good = test::rod_with_film(5);
  const auto refusal = [&](const std::string& file, const MatrixXd& matrix) {
    write_folder(folder / "m", good);
    if (matrix.size() > 0)
      write(folder / "m" / file, matrix);
    else
      std::filesystem::remove(folder / "m" / file);
    try {
      read_linear_system(folder / "m");
    } catch (const core::InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const std::vector<std::tuple<std::string, MatrixXd, std::string>> all = {
      {"A.mtx", MatrixXd::Ones(6, 5), "A.mtx: 6 x 5; allowed: a square matrix"},
      {"E.mtx", MatrixXd::Ones(5, 5), "E.mtx: 5 x 5; allowed: 6 x 6, as A.mtx"},
      {"B.mtx", MatrixXd::Ones(1, 6), "B.mtx: 1 x 6; allowed: 6 x 6, its transpose"},
      {"B.mtx", MatrixXd::Ones(4, 1), "B.mtx: 4 x 1; allowed: 6 x 1, a row for each state of A.mtx"},
      {"C.mtx", MatrixXd::Ones(6, 2), "C.mtx: 6 x 2; allowed: 6 x 6, its transpose"},
      {"C.mtx", MatrixXd::Ones(3, 5), "C.mtx: 3 x 5; allowed: 3 x 6, a column for each state of A.mtx"},
      {"B.mtx", MatrixXd::Zero(6, 1), "B.mtx: no entry other than 0"},
      {"C.mtx", MatrixXd::Zero(2, 6), "C.mtx: no entry other than 0"},
      {"D.mtx", MatrixXd::Ones(1, 2), "D.mtx: 1 x 2; allowed: 2 x 1"},
      {"A_film_end.mtx", MatrixXd::Ones(5, 5), "A_film_end.mtx: 5 x 5; allowed: 6 x 6"},
      {"A.mtx", MatrixXd(), "A.mtx: no such file"},
  };
  for (const auto& [file, matrix, said] : all) {
    std::filesystem::remove_all(folder / "m");
    const std::string message = refusal(file, matrix);
    EXPECT_NE(message.find(said), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace thermotwin::reduction
