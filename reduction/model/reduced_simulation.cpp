// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/model/reduced_simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>

#include "core/error.h"
#include "core/progress.h"
#include "mesh/machine/kinematics.h"
#include "reduction/model/exact_stepper.h"
#include "reduction/model/trained_range.h"
#include "solver/campaign/load_result.h"
#include "solver/campaign/simulation.h"
#include "solver/operation/layout.h"
#include "solver/thermal/stepper.h"

namespace thermotwin::reduction {
namespace {

constexpr const char* translations[] = {"dx_um", "dy_um", "dz_um"};

Eigen::MatrixXd translation_columns(const core::Table& tcp) {
  Eigen::MatrixXd columns(tcp.rows(), 3);
  for (Eigen::Index i = 0; i < 3; ++i) columns.col(i) = tcp.column(translations[i]);
  return columns;
}

/// Rows of a table that grows.
struct Rows {
  core::Table table;
  Eigen::Index filled = 0;

  Rows(std::string source, std::vector<std::string> columns, std::size_t rows)
      : table{std::move(source), std::move(columns), {}} {
    table.values.resize(rows, std::ssize(table.columns));
  }
  Eigen::MatrixXd::RowXpr next() { return table.values.row(filled++); }
};

std::vector<std::string> tcp_table_columns(const mesh::Machine& machine) {
  std::vector<std::string> columns{"time_s"};
  for (const std::string& name : mesh::pose_columns(machine)) columns.push_back(name);
  for (const std::string& name : solver::tcp_columns()) columns.push_back(name);
  return columns;
}

std::vector<std::string> sensor_table_columns(const mesh::Machine& machine) {
  std::vector<std::string> columns{"time_s"};
  for (const mesh::SensorSpec& sensor : machine.sensors) columns.push_back(sensor.id + "_C");
  return columns;
}

/// Means of the channels between outputs; the first row is that of the first step.
core::Table input_table(const solver::LoadProgram& load, const solver::Channels& channels, double refine) {
  const std::vector<double> ends = load.step_ends(refine), outputs = load.output_times();
  std::vector<std::string> columns{"time_s"};
  columns.insert(columns.end(), channels.names().begin(), channels.names().end());
  Rows rows(load.name(), std::move(columns), outputs.size());
  std::size_t step = 0;
  double time = 0.0;
  for (const double output : outputs) {
    const double begin = time;
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(channels.size());
    for (; step < ends.size() && time < output - 1e-9; time = ends[step++]) {
      sum += (ends[step] - time) * load.row(time, ends[step]);
    }
    const Eigen::VectorXd mean = time > begin ? Eigen::VectorXd(sum / (time - begin)) : load.row(0.0, ends.front());
    rows.next() << output, mean.transpose();
  }
  return std::move(rows.table);
}

/// A machine.toml that was changed may have other coefficients, but no other terms.
void require_same_terms(const ReducedModel& model, const mesh::Machine& machine) {
  const solver::Layout& own = model.system.layout;
  const auto same_term = [](const solver::Term& a, const solver::Term& b) {
    return a.kind == b.kind && a.item == b.item && a.part == b.part;
  };
  const auto same_input = [](const solver::Input& a, const solver::Input& b) {
    return a.kind == b.kind && a.term == b.term && a.item == b.item && a.place == b.place && a.node == b.node;
  };
  bool same = machine.joints.size() == own.grids.size() && machine.axes.size() == model.machine.axes.size() &&
              machine.sensors.size() == model.machine.sensors.size();
  if (same) {
    const solver::Layout other = solver::make_layout(machine, own.grids);
    same = std::equal(own.terms.begin(), own.terms.end(), other.terms.begin(), other.terms.end(), same_term) &&
           std::equal(own.inputs.begin(), own.inputs.end(), other.inputs.begin(), other.inputs.end(), same_input) &&
           own.observed.size() == other.observed.size();
  }
  if (!same) {
    throw core::InputError(machine.path.string(),
                           "other films, joints, sources, coolants, volumes, axes or sensors than the reduced model's",
                           "a machine with the model's own items (write the model anew: thermotwin reduce)");
  }
}

/// Passes steps on and keeps the range of their coefficients.
class Watched final : public solver::ThermalStepper {
public:
  Watched(solver::ThermalStepper& stepper, TrainedRange& range) : stepper_(stepper), range_(range) {}
  Eigen::Index size() const override { return stepper_.size(); }
  const solver::Layout& layout() const override { return stepper_.layout(); }
  Eigen::VectorXd uniform(double temperature_K) const override { return stepper_.uniform(temperature_K); }
  Eigen::MatrixXd sensors(const Eigen::MatrixXd& state) const override { return stepper_.sensors(state); }
  void advance(Eigen::MatrixXd& state, const std::vector<solver::Coefficients>& c, double step_s) override {
    for (const solver::Coefficients& of_load : c) range_.include(of_load.p);
    stepper_.advance(state, c, step_s);
  }

private:
  solver::ThermalStepper& stepper_;
  TrainedRange& range_;
};

}  // namespace

solver::LoadResult simulate_reduced(const ReducedModel& model, const mesh::Machine& machine,
                                    const solver::LoadProgram& load, const std::vector<mesh::Pose>& poses,
                                    const ReducedRun& how) {
  require_same_terms(model, machine);
  const auto moves_on = how.exact
                            ? std::unique_ptr<solver::ThermalStepper>(std::make_unique<ExactStepper>(model.system))
                            : std::make_unique<ReducedStepper>(model.system);
  TrainedRange range;
  Watched stepper(*moves_on, range);
  const solver::OperatingModel operating(machine, model.system.layout);
  const std::size_t times = load.output_times().size();
  const auto axes = std::ssize(machine.axes);
  Rows tcp(load.name(), tcp_table_columns(machine), times * poses.size());
  Rows sensors(load.name(), sensor_table_columns(machine), times);
  solver::SimulationOptions options;
  options.refine = how.refine;
  options.progress = false;
  const Eigen::MatrixXd rows = value_rows(model, poses);
  std::vector<Eigen::VectorXd> places;
  for (const mesh::Pose& pose : poses) places.push_back(mesh::pose_values(machine, pose));
  const Eigen::Index values_of_pose = poses.empty() ? 0 : rows.rows() / std::ssize(poses);
  Eigen::VectorXd values;
  RunRecord* record = how.record;
  if (record) {
    *record = {load.initial_C() - machine.reference_C, !how.exact, {}, {}};
    options.on_step = [record](const std::vector<solver::Coefficients>& c, double step_s) {
      record->steps.push_back({c.front(), step_s});
    };
  }
  solver::simulate(stepper, operating, {&load}, options, [&](const solver::OutputState& at) {
    sensors.next() << at.time, (at.sensors_K.array() + machine.reference_C).matrix().transpose();
    values.noalias() = rows * at.state;
    if (record) record->outputs.push_back({at.time, record->steps.size(), at.state});
    for (std::size_t i = 0; i < poses.size(); ++i) {
      auto row = tcp.next();
      row(0) = at.time;
      row.segment(1, axes) = places[i].transpose();
      row.tail(values_of_pose) =
          values.segment(static_cast<Eigen::Index>(i) * values_of_pose, values_of_pose).transpose();
    }
  });
  if (how.seen && range.low.size() > 0) {
    how.seen->include(range.low);
    how.seen->include(range.high);
  }
  if (const std::string beyond = how.tell ? outside_trained(model, range) : ""; !beyond.empty()) {
    core::warn(
        fmt::format("load '{}' leaves the range that the reduced model was trained on: {}", load.name(), beyond));
  }
  solver::LoadResult result;
  result.load = load.name();
  result.tcp = std::move(tcp.table);
  result.sensors = std::move(sensors.table);
  result.inputs = input_table(load, operating.channels(), how.refine);
  return result;
}

std::vector<mesh::Pose> poses_of(const mesh::Machine& machine, const core::Table& tcp) {
  const std::vector<std::string> names = mesh::pose_columns(machine);
  const Eigen::VectorXd units = mesh::pose_values(machine, Eigen::VectorXd::Ones(std::ssize(names)));
  const Eigen::VectorXd time = tcp.column("time_s");
  Eigen::Index count = 0;
  while (count < time.size() && time(count) == time(0)) ++count;
  std::vector<mesh::Pose> poses(count, mesh::Pose(units.size()));
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Eigen::Index axis = i;
    const Eigen::VectorXd values = tcp.column(names[i]);
    for (Eigen::Index row = 0; row < count; ++row) poses[row](axis) = values(row) / units(axis);
  }
  return poses;
}

ReductionErrors compare(const solver::LoadResult& full, const solver::LoadResult& reduced) {
  const std::string place = "comparison of load '" + full.load + "'";
  if (full.tcp.rows() != reduced.tcp.rows() || full.tcp.rows() == 0) {
    throw core::InputError(place, fmt::format("{} and {} rows", full.tcp.rows(), reduced.tcp.rows()),
                           "results at the same times and poses");
  }
  const Eigen::VectorXd time = full.tcp.column("time_s");
  if (!((time - reduced.tcp.column("time_s")).cwiseAbs().maxCoeff() <= 1e-6 * (1.0 + time.cwiseAbs().maxCoeff()))) {
    throw core::InputError(place, "other times", "results at the same times and poses");
  }
  const Eigen::MatrixXd truth = translation_columns(full.tcp);
  const Eigen::VectorXd off = (translation_columns(reduced.tcp) - truth).rowwise().norm();
  ReductionErrors errors;
  errors.load = full.load;
  errors.peak_um = truth.rowwise().norm().maxCoeff();
  errors.max_um = off.maxCoeff();
  errors.rms_um = std::sqrt(off.squaredNorm() / off.size());
  return errors;
}

std::vector<SensorError> compare_sensors(const solver::LoadResult& full, const solver::LoadResult& reduced) {
  const core::Table &truth = full.sensors, &model = reduced.sensors;
  if (truth.columns != model.columns || truth.rows() != model.rows() || truth.rows() == 0) {
    throw core::InputError("comparison of load '" + full.load + "'",
                           fmt::format("sensors with {} and {} rows", truth.rows(), model.rows()),
                           "results of the same sensors at the same times");
  }
  std::vector<SensorError> errors;
  const Eigen::VectorXd time = truth.column("time_s");
  for (Eigen::Index i = 0; i < truth.values.cols(); ++i) {
    const std::string& name = truth.columns[i];
    if (name == "time_s") continue;
    const Eigen::VectorXd readings = truth.values.col(i), off = model.values.col(i) - readings;
    SensorError error{full.load, name.substr(0, name.rfind("_C")), readings.maxCoeff() - readings.minCoeff()};
    Eigen::Index at = 0;
    error.max_K = off.cwiseAbs().maxCoeff(&at);
    error.rms_K = std::sqrt(off.squaredNorm() / off.size());
    error.at_s = time(at);
    errors.push_back(error);
  }
  return errors;
}

}  // namespace thermotwin::reduction
