// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/tests/test_run.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/error.h"
#include "core/progress.h"
#include "core/range.h"
#include "core/units.h"
#include "diagnosis/causes/hypothesis.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/parameter_sizes.h"
#include "diagnosis/response/response.h"
#include "diagnosis/response/tangents.h"
#include "solver/campaign/simulation.h"

namespace thermotwin::study {

using diagnosis::Variant;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double same_time_s = 1e-6;
constexpr double prediction_every_s = 1200.0;

/// Translations at the poses, um per state: (3 poses x r).
MatrixXd translations(const reduction::ReducedModel& model, const std::vector<mesh::Pose>& poses) {
  const MatrixXd all = reduction::value_rows(model, poses);
  MatrixXd rows(3 * std::ssize(poses), model.system.order());
  for (Index p = 0; p < std::ssize(poses); ++p) rows.middleRows<3>(3 * p) = all.middleRows<3>(18 * p);
  return rows;
}

bool changes_matrices(const UncertainParameter& parameter) { return diagnosis::needs_parts(parameter.parameter.kind); }

/// One state for all that is along: of the nominal machine, and its tangents per standard deviation.
struct Along {
  diagnosis::Observations steps;
  diagnosis::MachineInTime machine;
  diagnosis::Nominal nominal;
  diagnosis::RunWithTangents run;

  Along(const reduction::ReducedModel& model, double start_C, const std::vector<Variant>& variants)
      : steps(from(start_C)),
        machine(model.machine),
        nominal{model, steps, machine, model.system.sensors, model.system.capacity},
        run(nominal, variants) {}
  void step(const VectorXd& row, double seconds) {
    steps.points = Eigen::Vector2d(0.0, seconds);
    steps.rows = row.transpose();
    run.advance(0);
  }

private:
  static diagnosis::Observations from(double start_C) {
    diagnosis::Observations observations;
    observations.start_C = start_C;
    return observations;
  }
};

}  // namespace

struct TestRun::Kept {
  diagnosis::RunWithTangents::Kept run;
  double time;
};

struct TestRun::Parts {
  reduction::ReducedModel model;  ///< of the machine about which it is linear
  TestSetup setup;
  std::vector<UncertainParameter> moved;  ///< parameters, then surroundings
  std::vector<Variant> variants;          ///< the same, then the start
  VectorXd per_std;                       ///< (variants) standard deviations per step
  MatrixXd probe;                         ///< (3 probes x r)
  std::vector<MatrixXd> probe_change;     ///< (variants) of probe per step; empty: none
  std::unique_ptr<Along> along;
  std::optional<TestReadings> first_probe;
  double time = 0;

  Parts(const reduction::ReducedModel& made, const VectorXd& values, const TestSetup& of)
      : model(diagnosis::model_of_changed(made, machine_at(made.machine, values, of))),
        setup(of),
        moved(of.parameters) {
    moved.insert(moved.end(), of.surroundings.begin(), of.surroundings.end());
    probe = translations(model, setup.probes);
    per_std.resize(std::ssize(moved) + 1);
    for (std::size_t i = 0; i < moved.size(); ++i) {
      const diagnosis::Parameter& one = moved[i].parameter;
      const double value = i < setup.parameters.size() ? values[i] : one.nominal;
      // A ratio is one to what the machine has here.
      Variant variant{.machine = diagnosis::with_parameter(
                          model.machine, one, one.ratio ? (value + one.step) / value : one.nominal + one.step)};
      variant.step = one.step;
      per_std[i] = moved[i].std;
      probe_change.emplace_back();
      if (changes_matrices(moved[i])) {
        const reduction::ReducedModel other = diagnosis::model_of_changed(model, variant.machine);
        if (const MatrixXd change = other.system.capacity - model.system.capacity; !change.isZero(0.0))
          variant.capacity_change = change;
        if (const MatrixXd change = translations(other, setup.probes) - probe; !change.isZero(0.0))
          probe_change.back() = change;
      }
      per_std[i] /= variant.step;
      variants.push_back(std::move(variant));
    }
    variants.push_back({.machine = model.machine, .start_K = 1.0});
    per_std[std::ssize(moved)] = setup.start_std_K;
    probe_change.emplace_back();
    along = std::make_unique<Along>(model, setup.start_C, variants);
    if (setup.probes.empty()) return;
    TestReadings start = of_probe();
    start.rows.rightCols(probe.rows()).setZero();
    first_probe = std::move(start);
  }

  static mesh::Machine machine_at(const mesh::Machine& nominal, const VectorXd& values, const TestSetup& setup) {
    std::vector<diagnosis::Parameter> parameters;
    for (const UncertainParameter& one : setup.parameters) parameters.push_back(one.parameter);
    return diagnosis::with_parameters(nominal, parameters, values);
  }

  Index sensors() const { return std::ssize(setup.sensors); }
  Index variant_count() const { return std::ssize(variants); }

  TestReadings of_sensors() const {
    TestReadings readings{time, false, VectorXd(sensors()), MatrixXd::Zero(sensors(), setup.unknowns()),
                          VectorXd(sensors())};
    const MatrixXd tangents = along->run.tangents();
    const VectorXd offsets = solver::sensor_offsets(model.machine, model.system.layout);
    for (Index s = 0; s < sensors(); ++s) {
      const int sensor = setup.sensors[s];
      const auto row = model.system.sensors.row(sensor);
      readings.predicted[s] = row.dot(along->run.state()) + offsets[sensor];
      readings.rows.row(s).head(variant_count()) = (row * tangents).cwiseProduct(per_std.transpose());
      readings.rows(s, variant_count() + s) = setup.bias_K;
      readings.std[s] = std::max(model.machine.sensors[sensor].uncertainty, 1e-3);
    }
    return readings;
  }

  /// Less the reading at the start, which sets the zero.
  TestReadings of_probe() const {
    const Index rows = probe.rows();
    const VectorXd& state = along->run.state();
    TestReadings readings{time, true, probe * state, MatrixXd::Zero(rows, setup.unknowns()),
                          VectorXd::Constant(rows, setup.probe_std_um)};
    readings.rows.leftCols(variant_count()) = probe * along->run.tangents();
    for (Index v = 0; v < variant_count(); ++v)
      if (probe_change[v].size() > 0) readings.rows.col(v) += probe_change[v] * state;
    readings.rows.leftCols(variant_count()) *= per_std.asDiagonal();
    if (first_probe) {
      readings.predicted -= first_probe->predicted;
      readings.rows -= first_probe->rows;
    }
    readings.rows.rightCols(rows).diagonal().setConstant(setup.probe_std_um);
    return readings;
  }
};

void TestSetup::validate() const {
  core::require_within("tests: start_std_K", start_std_K, {0.0, 100.0});
  core::require_within("tests: reading_s", reading_s, {1.0, 1e6});
  core::require_within("tests: step_s", step_s, {1.0, 1e6});
  core::require_within("tests: bias_K", bias_K, {0.0, 100.0});
  core::require_within("tests: probe_std_um", probe_std_um, {1e-6, 1e6});
  if (parameters.empty()) throw core::InputError("parameters of a test", "none", "one or more");
  if (sensors.empty() && probes.empty()) {
    throw core::InputError("readings of a test", "neither a sensor nor a probe",
                           "a [[sensor]] of machine.toml, or a probe");
  }
}

Index TestSetup::unknowns() const {
  return std::ssize(parameters) + std::ssize(surroundings) + 1 + std::ssize(sensors) + 3 * std::ssize(probes);
}

TestRun::TestRun(const reduction::ReducedModel& model, const VectorXd& values, const TestSetup& setup) {
  setup.validate();
  parts_ = std::make_unique<Parts>(model, values, setup);
}

TestRun::~TestRun() = default;

MatrixXd TestRun::run(const TestBlock& block, const Take& take) {
  Parts& of = *parts_;
  MatrixXd information = MatrixXd::Zero(of.setup.unknowns(), of.setup.unknowns());
  const auto read = [&](const TestReadings& readings) {
    const MatrixXd weighted = readings.std.cwiseInverse().asDiagonal() * readings.rows;
    information.noalias() += weighted.transpose() * weighted;
    if (take) take(readings);
  };
  double passed = 0.0, next = of.setup.reading_s;
  for (const TestPhase& phase : block.phases) {
    double within = 0.0;
    while (phase.seconds - within > same_time_s) {
      const double left = std::min(phase.seconds - within, next - passed);
      const double length = left / std::ceil(left / of.setup.step_s - 1e-9);
      const double share = (within + 0.5 * length) / phase.seconds;
      VectorXd row = phase.from;
      for (Index i = 0; i < row.size(); ++i)
        if (phase.to[i] != phase.from[i] && std::isfinite(phase.to[i])) row[i] += share * (phase.to[i] - phase.from[i]);
      of.along->step(row, length);
      within += length;
      passed += length;
      of.time += length;
      if (next - passed > same_time_s) continue;
      if (of.sensors() > 0) read(of.of_sensors());
      next += of.setup.reading_s;
    }
    if (phase.probes && !of.setup.probes.empty()) read(of.of_probe());
  }
  if (!of.along->run.finite())
    throw core::SolverError("study tests: the reduced model's state is no longer finite in block '" + block.name + "'");
  return information;
}

std::shared_ptr<const TestRun::Kept> TestRun::keep() const {
  return std::make_shared<const Kept>(Kept{parts_->along->run.keep(), parts_->time});
}

void TestRun::take_up(const Kept& kept) {
  parts_->along->run.take_up(kept.run);
  parts_->time = kept.time;
}

MatrixXd TestRun::prediction(const std::vector<solver::LoadProgram>& loads,
                             const std::vector<mesh::Pose>& poses) const {
  const Parts& of = *parts_;
  const Index count = std::ssize(of.setup.parameters);
  std::vector<Variant> variants(of.variants.begin(), of.variants.begin() + count);
  const MatrixXd rows = translations(of.model, poses);
  std::vector<MatrixXd> change(count);
  for (Index v = 0; v < count; ++v) {
    if (!changes_matrices(of.setup.parameters[v])) continue;
    change[v] = translations(diagnosis::model_of_changed(of.model, variants[v].machine), poses) - rows;
    if (change[v].isZero(0.0)) change[v].resize(0, 0);
  }
  MatrixXd sum = MatrixXd::Zero(count, count);
  double summed = 0.0;  // times and poses
  for (const solver::LoadProgram& load : loads) {
    Along along(of.model, load.initial_C(), variants);
    const VectorXd start = along.run.state();
    core::Progress progress("sensitivities along '" + load.name() + "'",
                            std::max(1L, std::lround(load.duration() / core::units::minute)));
    double before = 0.0;
    for (const double stop : load.stops()) {
      if (stop - before < prediction_every_s - same_time_s && !load.is_corner(stop)) continue;
      const double parts = std::ceil((stop - before) / of.setup.step_s - 1e-9);
      for (double k = 0; k < parts; ++k) {
        const double from = before + (stop - before) * k / parts, to = before + (stop - before) * (k + 1) / parts;
        along.step(load.row(from, to), to - from);
      }
      progress.advance(std::lround((stop - before) / core::units::minute));
      before = stop;
      MatrixXd errors = rows * along.run.tangents();
      for (Index v = 0; v < count; ++v)
        if (change[v].size() > 0) errors.col(v) += change[v] * (along.run.state() - start);
      errors *= of.per_std.head(count).asDiagonal();
      sum.noalias() += errors.transpose() * errors;
      summed += std::ssize(poses);
    }
    if (!along.run.finite())
      throw core::SolverError("study tests: the reduced model's state is no longer finite along '" + load.name() + "'");
  }
  return sum / std::max(1.0, summed);
}

}  // namespace thermotwin::study
