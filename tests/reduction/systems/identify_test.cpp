// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/systems/identify.h"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <iterator>
#include <random>

#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "reduction/systems/system_file.h"
#include "solver/campaign/recorder.h"
#include "solver/operation/layout.h"
#include "tests/core/temporary_folder.h"
#include "tests/machines/boxes.h"

namespace thermotwin::reduction {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index poses = 2, sensors = 3;

/// A chain of masses between two ambients (inputs 0 and 1) with three heat sources (inputs 2 to 4; the last one
/// never runs), exactly stepped: no pole of it is one of the identification's.
struct Chain {
  MatrixXd a, b, c;

  Chain() {
    constexpr Index n = 8;
    a = MatrixXd::Zero(n, n);
    b = MatrixXd::Zero(n, 5);
    for (Index i = 0; i + 1 < n; ++i) {
      const double g = 1.0 / (400.0 * std::pow(2.1, i));
      a(i, i) -= g, a(i, i + 1) += g;
      a(i + 1, i) += 0.6 * g, a(i + 1, i + 1) -= 0.6 * g;
    }
    a(0, 0) -= 1.0 / 3000, b(0, 0) = 1.0 / 3000;
    a(n - 1, n - 1) -= 1.0 / 20000, b(n - 1, 1) = 1.0 / 20000;
    b(1, 2) = 2e-5, b(4, 3) = 4e-6, b(6, 4) = 1e-6;
    std::mt19937 engine(5);
    std::normal_distribution<double> normal;
    c = MatrixXd::NullaryExpr(6 * poses + sensors, n, [&](Index, Index) { return normal(engine); });
    c.bottomRows(sensors).setZero();
    for (Index s = 0; s < sensors; ++s) c(6 * poses + s, 3 * s) = 1.0;
  }

  /// Inputs step to other values every hour or so; which ones move is asked for.
  Samples run(const std::string& name, unsigned seed, const std::vector<Index>& moving, double initial_K,
              int hours = 12) const {
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    constexpr double step = 300.0;
    const Index times = hours * 12 + 1, n = a.rows();
    Samples load{name,
                 VectorXd::LinSpaced(times, 0.0, step * (times - 1)),
                 MatrixXd::Zero(times, 5),
                 MatrixXd(times, c.rows()),
                 poses,
                 initial_K};
    load.inputs.leftCols(2).setConstant(initial_K);
    for (const Index k : moving) {
      double value = 0.0;
      for (Index i = 0; i < times; ++i) {
        if (i % 12 == 1 || i == 0) value = k < 2 ? initial_K + 10.0 * unit(engine) - 5.0 : 300.0 * unit(engine);
        load.inputs(i, k) = value;
      }
    }
    VectorXd x = VectorXd::Constant(n, initial_K);
    const Eigen::EigenSolver<MatrixXd> modes(a);
    const Eigen::MatrixXcd v = modes.eigenvectors(), w = v.inverse();
    const Eigen::ArrayXcd values = modes.eigenvalues().array(), decay = (step * values).exp();
    load.outputs.row(0) = (c * x).transpose();
    for (Index i = 1; i < times; ++i) {
      const VectorXd heat = b * load.inputs.row(i).transpose();
      const Eigen::VectorXcd change = (decay * (w * x).array() + (decay - 1.0) / values * (w * heat).array()).matrix();
      x = (v * change).real();
      load.outputs.row(i) = (c * x).transpose();
    }
    return load;
  }

  std::vector<Samples> training() const {
    return {run("air", 1, {0}, 1.0, 48), run("ground", 2, {1}, 0.0, 48), run("first", 3, {2}, 0.0),
            run("second", 4, {3}, 2.0), run("all", 5, {0, 1, 2, 3}, -1.0)};
  }
};

const std::vector<bool> even{true, true, false, false, false};

const Identification& identified() {
  static const Identification made = [] {
    core::set_quiet(true);
    return Identification(Chain().training(), even, {});
  }();
  return made;
}

double worst_of(const ReducedLinearSystem& model, const Samples& load) {
  const MatrixXd off = identified().predict(model, load) - load.outputs;
  return off.leftCols(6 * poses).cwiseAbs().maxCoeff() / load.outputs.leftCols(6 * poses).cwiseAbs().maxCoeff();
}

TEST(Identify, PredictsALoadThatItNeverSaw) {
  const Samples unseen = Chain().run("unseen", 99, {0, 1, 2, 3}, 3.0, 30);
  const ReducedLinearSystem model = identified().model(identified().order());
  fmt::print("order {} of {}, ridge {:.0e}, on {}: off by {:.2f} % of the largest\n", model.order(),
             identified().lags().base.size(), identified().ridge(), identified().kept_out(),
             100 * worst_of(model, unseen));
  EXPECT_LT(worst_of(model, unseen), 0.03);
  EXPECT_GT(worst_of(identified().model(2), unseen), 0.06) << "two states cannot do";
}

TEST(Identify, KeepsOutTheLoadThatMovesMostOfWhatOthersMove) {
  EXPECT_EQ(identified().kept_out(), "load 'all'");
  const auto& tried = identified().order_error_um();
  ASSERT_GT(tried.size(), 2U);
  double least = tried.front().second;
  for (const auto& [order, error] : tried) least = std::min(least, error);
  for (const auto& [order, error] : tried) {
    if (order < identified().order()) {
      EXPECT_GT(error, 1.02 * least) << order;
    }
    if (order == identified().order()) {
      EXPECT_LE(error, 1.02 * least);
    }
  }
  // Without it, no load moves what others do.
  std::vector<Samples> apart = Chain().training();
  apart.pop_back();
  EXPECT_EQ(Identification(apart, even, {}).kept_out(), "the last quarter of each load");
}

TEST(Identify, IsStableAtEveryOrder) {
  // Data of no linear system: noise, and a response that grows.
  std::mt19937 engine(11);
  std::normal_distribution<double> normal;
  std::vector<Samples> wild = Chain().training();
  for (Samples& load : wild) {
    for (Index i = 1; i < load.outputs.rows(); ++i) {
      for (Index j = 0; j < load.outputs.cols(); ++j)
        load.outputs(i, j) = 30.0 * normal(engine) + std::exp(3e-5 * load.time(i));
    }
  }
  const Identification made(wild, even, {});
  for (const Identification* of : {&identified(), &made}) {
    for (Index order = 1; order <= std::min<Index>(of->largest_order(), 25); ++order) {
      const VectorXd growth = of->model(order).A.eigenvalues().real();
      ASSERT_EQ(growth.size(), order);
      EXPECT_LT(growth.maxCoeff(), 0.0) << order;
    }
  }
}

TEST(Identify, AnEvenMachineStaysEven) {
  Samples rest = Chain().run("rest", 1, {}, 4.0, 20);
  const ReducedLinearSystem model = identified().model(identified().order());
  const MatrixXd at = identified().predict(model, rest);
  EXPECT_LT((at.rowwise() - at.row(0)).cwiseAbs().maxCoeff(), 1e-9 * at.cwiseAbs().maxCoeff());
  EXPECT_LT((at - rest.outputs).cwiseAbs().maxCoeff(), 0.01 * rest.outputs.cwiseAbs().maxCoeff());
}

TEST(Identify, NamesWhatTheCampaignNeverMoved) {
  EXPECT_EQ(identified().never_moved(), std::vector<Index>{4});
  EXPECT_EQ(identified().beyond(Chain().run("new", 3, {2, 4}, 0.0)), std::vector<Index>{4});
  EXPECT_TRUE(identified().beyond(Chain().run("old", 3, {2, 3}, 0.0)).empty());
  EXPECT_EQ(identified().model(10).B.col(4), VectorXd::Zero(10));
  EXPECT_THROW(Identification({Chain().run("still", 1, {}, 1.0)}, even, {}), core::InputError);
  EXPECT_THROW(Identification({}, even, {}), core::InputError);
}

TEST(Identify, OrderAskedForIsTheOrderGiven) {
  const Identification made(Chain().training(), even, {.order = 7});
  EXPECT_EQ(made.order(), 7);
  EXPECT_EQ(made.model(made.order()).A.rows(), 7);
}

/// Tables as a campaign writes them, with numbers that say where they came from.
CampaignTables tables_of(const mesh::Machine& machine) {
  CampaignTables tables{"load", {}, {}, {}};
  const solver::Channels channels(machine);
  tables.inputs.columns = {"time_s"};
  tables.inputs.columns.insert(tables.inputs.columns.end(), channels.names().begin(), channels.names().end());
  tables.inputs.values.resize(3, channels.size() + 1);
  for (Index i = 0; i < 3; ++i) tables.inputs.values.row(i) << 60.0 * i, channels.defaults().transpose();
  tables.sensors.columns = {"time_s"};
  for (const mesh::SensorSpec& sensor : machine.sensors) tables.sensors.columns.push_back(sensor.id + "_C");
  tables.sensors.values = MatrixXd::Constant(3, std::ssize(tables.sensors.columns), 23.0);
  tables.sensors.values.col(0) << 0, 60, 120;
  tables.tcp.columns = {"time_s"};
  for (const std::string& name : mesh::pose_columns(machine)) tables.tcp.columns.push_back(name);
  for (const char* name : {"dx_um", "dy_um", "dz_um", "ra_um_per_m", "rb_um_per_m", "rc_um_per_m"})
    tables.tcp.columns.push_back(name);
  tables.tcp.values.resize(6, std::ssize(tables.tcp.columns));
  for (Index i = 0; i < 6; ++i) {
    for (Index j = 0; j < tables.tcp.values.cols(); ++j)
      tables.tcp.values(i, j) = j == 0 ? 60.0 * (i / 2) : 100.0 * i + j;
  }
  return tables;
}

TEST(CampaignTables, AreReadAsInputsAndOutputs) {
  const mesh::Machine machine = test::small_machine_mesh().machine;
  CampaignTables tables = tables_of(machine);
  const auto column = [&](const char* name) { return tables.inputs.values.col(*tables.inputs.find(name)); };
  column("air.T_C")(1) = 25.0;
  column("cutting_fluid.on")(1) = 1.0;
  column("cutting_fluid.T_C")(1) = 30.0;
  column("spindle.speed_rpm")(2) = 6000.0;
  const CampaignInputs inputs(machine);
  const MatrixXd u = inputs.of(tables);
  const auto input = [&](const std::string& name) {
    const auto at = std::find(inputs.names().begin(), inputs.names().end(), name);
    EXPECT_NE(at, inputs.names().end()) << name;
    return VectorXd(u.col(at - inputs.names().begin()));
  };
  EXPECT_EQ(input("air.T_K")(1), 5.0);
  EXPECT_EQ(input("cutting_fluid.on x (cutting_fluid.T_K - air.T_K)"), Eigen::Vector3d(0, 5, 0));
  const solver::OperatingModel operating(
      machine, solver::make_layout(machine, std::vector<solver::JointGrid>(machine.joints.size(), {-1, false, {0.0}})));
  VectorXd row = operating.channels().defaults();
  row(operating.channels().index("spindle.speed_rpm")) = 6000.0;
  ASSERT_GT(operating.source_powers(row).maxCoeff(), 0.0);
  EXPECT_EQ(u.row(2).head(operating.source_powers(row).size()).transpose(), operating.source_powers(row));
  EXPECT_EQ(inputs.initial_K(tables), 3.0);
  const MatrixXd y = campaign_outputs(tables, machine.reference_C);
  const Index first = std::ssize(mesh::pose_columns(machine)) + 1;
  EXPECT_EQ(campaign_poses(tables), 2);
  EXPECT_EQ(y.rows(), 3);
  EXPECT_EQ(y(1, 6 + 2), 300.0 + (first + 2)) << "dz of the second pose at the second time: row 3";
  EXPECT_EQ(y(2, y.cols() - 1), 3.0);
  EXPECT_EQ(std::ssize(campaign_output_names(machine, tables)), y.cols());
  tables.tcp.values(3, 0) = 7.0;
  EXPECT_THROW(campaign_poses(tables), core::InputError);
}

TEST(CampaignTables, MissingOnesAreNamed) {
  const core::TemporaryFolder scratch;
  try {
    read_campaign_tables(scratch.path(), "warm_up");
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("warm_up/inputs.csv: no such file"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace thermotwin::reduction
