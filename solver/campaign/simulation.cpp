// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/simulation.h"

#include <fmt/format.h>
#include <iterator>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/error.h"
#include "core/progress.h"
#include "solver/operation/layout.h"
#include "solver/thermal/stepper.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// What drives one load: its program, its chillers, what they and the machine are told.
struct Drive {
  const LoadProgram* program;
  std::optional<Chiller> chiller;
  VectorXd row;
};

/// A step whose coefficients follow the temperatures that come out of it: solved with what they are
/// expected to be at its end, until that is what they are. Coefficients are those of the means of
/// start and end, so that the scheme stays of second order.
class FollowingStep {
public:
  FollowingStep(ThermalStepper& stepper, const OperatingModel& model, std::vector<Drive>& drives,
                const VectorXd& offsets)
      : stepper_(stepper),
        model_(model),
        drives_(drives),
        offsets_(offsets),
        returns_(std::any_of(drives.begin(), drives.end(),
                             [](const Drive& drive) { return drive.chiller->follows_return(); })) {}

  bool needed() const { return returns_ || model_.follows_temperature() || stepper_.is_nonlinear(); }

  void advance(Eigen::MatrixXd& state, Eigen::MatrixXd& readings, double step, std::vector<Coefficients>& c,
               RunSummary& summary) {
    const Index observed = std::ssize(model_.layout().observed);
    const bool fresh = slope_.cols() != readings.cols();
    Eigen::MatrixXd expected = fresh ? readings : Eigen::MatrixXd(readings + step * slope_), found;
    Eigen::MatrixXd end = state, next;
    if (stepper_.is_nonlinear() && !fresh) end += step * state_slope_;
    const std::vector<Drive> before = drives_;
    double change = 0.0;
    for (int pass = 0; pass < most_passes; ++pass) {
      for (std::size_t l = 0; l < drives_.size(); ++l) {
        const Index column = l;
        Drive& drive = drives_[l];
        drive.chiller = before[l].chiller;
        Chiller::Readings over{readings.col(column), {}, {}, model_.guide_K(drive.row), {}};
        if (returns_) over.slope = (expected.col(column) - readings.col(column)) / step;
        const VectorXd middle = 0.5 * (readings.col(column) + expected.col(column));
        model_.coefficients(drive.row, drive.chiller->advance(drive.row, over, step), middle, c[l]);
      }
      if (stepper_.is_nonlinear()) stepper_.linearise(state, end, c);
      next = state;
      stepper_.advance(next, c, step);
      found = stepper_.sensors(next).colwise() + offsets_;
      change = observed > 0 ? (found - expected).bottomRows(observed).cwiseAbs().maxCoeff() : 0.0;
      if (returns_) change = std::max(change, (found - expected).cwiseAbs().maxCoeff());
      if (stepper_.is_nonlinear()) change = std::max(change, (next - end).cwiseAbs().maxCoeff());
      ++summary.passes;
      expected = found;
      end = next;
      if (change <= iteration_K) break;
    }
    if (!(change <= iteration_K)) ++summary.unconverged;
    slope_ = (found - readings) / step;
    if (stepper_.is_nonlinear()) state_slope_ = (next - state) / step;
    state = std::move(next);
    readings = std::move(found);
  }

  void save(core::BinaryWriter& out) const {
    out.matrix(slope_);
    out.matrix(state_slope_);
  }
  void load(core::BinaryReader& in) {
    slope_ = in.matrix();
    state_slope_ = in.matrix();
  }

private:
  ThermalStepper& stepper_;
  const OperatingModel& model_;
  std::vector<Drive>& drives_;
  const VectorXd& offsets_;
  const bool returns_;
  Eigen::MatrixXd slope_, state_slope_;  // of the last step, K/s
};

std::string label(const std::vector<const LoadProgram*>& programs) {
  return programs.size() == 1 ? "thermal run '" + programs.front()->name() + "'"
                              : fmt::format("thermal run of {} loads", programs.size());
}

}  // namespace

int air_index(const mesh::Machine& machine) {
  for (std::size_t i = 0; i < machine.ambients.size(); ++i)
    if (machine.ambients[i].id == "air") return static_cast<int>(i);
  return -1;
}

VectorXd sensor_offsets(const mesh::Machine& machine, const Layout& layout) {
  const auto sensors = std::ssize(machine.sensors);
  VectorXd offsets = VectorXd::Zero(sensors + std::ssize(layout.observed));
  for (Index s = 0; s < sensors; ++s) offsets[s] = machine.sensors[s].offset;
  return offsets;
}

std::string RunSummary::brief() const {
  std::string text = fmt::format("{} steps of {:.4g} to {:.4g} s, {} factorisations, {} iterations", steps,
                                 shortest_step, longest_step, factorisations, iterations);
  if (rejected > 0) text += fmt::format(", {} tries repeated", rejected);
  if (over_tolerance > 0) text += fmt::format(", {} shortest steps above the tolerance", over_tolerance);
  if (passes > 0) text += fmt::format(", {:.2f} passes a step", static_cast<double>(passes) / (std::max(1L, steps)));
  if (unconverged > 0)
    text += fmt::format(", {} steps whose coefficients did not settle to {:.0e} K", unconverged, iteration_K);
  if (!switches.empty()) text += fmt::format(", {} compressor switches", switches.size());
  if (resumed_at > 0) text += fmt::format("; resumed at {:.0f} s", resumed_at);
  return text;
}

RunSummary simulate(ThermalStepper& stepper, const OperatingModel& model,
                    const std::vector<const LoadProgram*>& programs, const SimulationOptions& options,
                    const std::function<void(const OutputState&)>& on_output) {
  RunSummary summary;
  if (programs.empty()) return summary;
  const mesh::Machine& machine = model.machine();
  const std::vector<double> ends = programs.front()->step_ends(options.refine);
  const std::vector<double> outputs = programs.front()->output_times();
  for (const LoadProgram* program : programs)
    if (program->step_ends(options.refine) != ends || program->output_times() != outputs)
      throw core::InputError("load '" + program->name() + "'",
                             "another time grid than '" + programs.front()->name() + "'",
                             "programs of equal phases, time_step_s and output_s in one block");

  const VectorXd offsets = sensor_offsets(machine, stepper.layout());
  const auto sensors = std::ssize(machine.sensors);
  const auto read = [&](const Eigen::MatrixXd& of) { return Eigen::MatrixXd(stepper.sensors(of).colwise() + offsets); };

  const auto loads = std::ssize(programs);
  Eigen::MatrixXd state(stepper.size(), loads);
  for (Index l = 0; l < loads; ++l)
    state.col(l) =
        options.start.size() > 0 ? options.start : stepper.uniform(programs[l]->initial_C() - machine.reference_C);
  Eigen::MatrixXd readings = read(state);

  std::vector<Drive> drives;
  for (Index l = 0; l < loads; ++l) {
    Drive drive{programs[l], std::nullopt, {}};
    drive.row = drive.program->row(0.0, ends.front());
    drive.chiller.emplace(machine, stepper.layout(), model.channels(),
                          chiller_set_points(machine, stepper.layout(), readings.col(l), model.guide_K(drive.row)));
    drives.push_back(std::move(drive));
  }
  FollowingStep following(stepper, model, drives, offsets);

  std::size_t next_output = 0, done = 0;
  const auto save = [&](core::BinaryWriter& out) {
    out.count(static_cast<std::int64_t>(done));
    out.count(static_cast<std::int64_t>(next_output));
    out.matrix(state);
    for (const Drive& drive : drives) drive.chiller->save(out);
    following.save(out);
    if (options.balances)
      for (const HeatBalance& balance : *options.balances) balance.save(out);
    stepper.save(out);
  };
  const auto load = [&](core::BinaryReader& in) {
    done = in.count();
    next_output = in.count();
    state = in.matrix();
    for (Drive& drive : drives) drive.chiller->load(in);
    following.load(in);
    if (options.balances)
      for (HeatBalance& balance : *options.balances) balance.load(in);
    stepper.load(in);
  };
  const auto report = [&](double time) {
    if (next_output >= outputs.size() || time < outputs[next_output] - 1e-9 * ends.back()) return;
    for (std::size_t l = 0; l < drives.size(); ++l) {
      const Index column = l;
      on_output({l, next_output, time, state.col(column), readings.col(column).head(sensors), drives[l].row});
    }
    ++next_output;
  };
  if (options.checkpoint && options.checkpoint->restore(load)) {
    readings = read(state);
    summary.resumed_at = done > 0 ? ends[done - 1] : 0.0;
  } else {
    report(0.0);
  }

  std::optional<core::Progress> progress;
  if (options.progress) progress.emplace(label(programs), ends.size() - done);
  std::vector<Coefficients> coefficients(drives.size());
  summary.shortest_step = ends.back();
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const double time = i > 0 ? ends[i - 1] : 0.0, end = ends[i], step = end - time;
    summary.shortest_step = std::min(summary.shortest_step, step);
    summary.longest_step = std::max(summary.longest_step, step);
    ++summary.steps;
    if (i < done) continue;
    for (Drive& drive : drives) drive.row = drive.program->row(time, end);
    Eigen::MatrixXd before;
    if (options.balances) before = state;
    if (following.needed()) {
      following.advance(state, readings, step, coefficients, summary);
    } else {
      for (std::size_t l = 0; l < drives.size(); ++l) {
        Drive& drive = drives[l];
        const VectorXd& inlet = drive.chiller->advance(drive.row, readings.col(l), model.guide_K(drive.row), step);
        model.coefficients(drive.row, inlet, {}, coefficients[l]);
      }
      stepper.advance(state, coefficients, step);
      readings = read(state);
    }
    if (options.balances)
      for (std::size_t l = 0; l < drives.size(); ++l) {
        const Index column = l;
        (*options.balances)[l].add(before.col(column), state.col(column), stepper.mean_over_step()->col(column),
                                   coefficients[l].p, coefficients[l].q, step, stepper.local_change(l));
      }
    if (options.on_step) options.on_step(coefficients, step);
    done = i + 1;
    report(end);
    try {
      if (progress)
        progress->advance();
      else
        core::check_interrupt();
    } catch (const core::Interrupted&) {
      if (options.checkpoint) options.checkpoint->write(save);
      throw;
    }
    if (options.checkpoint && done < ends.size() && options.checkpoint->due()) options.checkpoint->write(save);
  }
  return summary;
}

std::vector<std::vector<const LoadProgram*>> blocks_of_equal_grid(const std::vector<LoadProgram>& programs,
                                                                  double refine) {
  std::vector<std::vector<const LoadProgram*>> blocks;
  for (const LoadProgram& program : programs) {
    const auto ends = program.step_ends(refine);
    const auto outputs = program.output_times();
    const TimeScheme scheme = program.time().scheme;
    bool placed = false;
    for (auto& block : blocks)
      if (!placed && scheme != TimeScheme::adaptive && block.front()->time().scheme == scheme &&
          block.front()->step_ends(refine) == ends && block.front()->output_times() == outputs) {
        block.push_back(&program);
        placed = true;
      }
    if (!placed) blocks.push_back({&program});
  }
  return blocks;
}

}  // namespace thermotwin::solver
