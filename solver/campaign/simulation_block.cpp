// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/simulation_block.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
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
  const OperatingModel* model;
  const LoadProgram* program;
  std::optional<Chiller> chiller;
  VectorXd row;
};

/// A step whose coefficients follow the temperatures that come out of it: solved with what they are
/// expected to be at its end, until that is what they are. Coefficients are those of the means of
/// start and end, so that the scheme stays of second order.
class FollowingStep {
public:
  FollowingStep(ThermalStepper& stepper, std::vector<Drive>& drives, const Eigen::MatrixXd& offsets)
      : stepper_(stepper),
        drives_(drives),
        offsets_(offsets),
        returns_(std::any_of(drives.begin(), drives.end(),
                             [](const Drive& drive) { return drive.chiller->follows_return(); })),
        follows_(std::any_of(drives.begin(), drives.end(),
                             [](const Drive& drive) { return drive.model->follows_temperature(); })) {}

  bool needed() const { return returns_ || follows_ || stepper_.is_nonlinear(); }

  void advance(Eigen::MatrixXd& state, Eigen::MatrixXd& readings, double step, std::vector<Coefficients>& c,
               RunSummary& summary) {
    const Index observed = std::ssize(stepper_.layout().observed);
    const bool fresh = slope_.cols() != readings.cols();
    Eigen::MatrixXd expected = fresh ? readings : Eigen::MatrixXd(readings + step * slope_), found;
    Eigen::MatrixXd end = state, next;
    if (stepper_.is_nonlinear() && !fresh) end += step * state_slope_;
    const std::vector<Drive> before = drives_;
    double change = 0.0;
    for (int pass = 0; pass < most_passes; ++pass) {
      for (std::size_t l = 0; l < drives_.size(); ++l) {
        Drive& drive = drives_[l];
        drive.chiller = before[l].chiller;
        Chiller::Readings over{readings.col(l), {}, {}, drive.model->guide_K(drive.row), {}};
        if (returns_) over.slope = (expected.col(l) - readings.col(l)) / step;
        const VectorXd middle = 0.5 * (readings.col(l) + expected.col(l));
        drive.model->coefficients(drive.row, drive.chiller->advance(drive.row, over, step), middle, c[l]);
      }
      if (stepper_.is_nonlinear()) stepper_.linearise(state, end, c);
      next = state;
      stepper_.advance(next, c, step);
      found = stepper_.sensors(next) + offsets_;
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
  std::vector<Drive>& drives_;
  const Eigen::MatrixXd& offsets_;
  const bool returns_, follows_;
  Eigen::MatrixXd slope_, state_slope_;  // of the last step, K/s
};

std::string label(const std::vector<const LoadProgram*>& programs) {
  return programs.size() == 1 ? "thermal run '" + programs.front()->name() + "'"
                              : fmt::format("thermal run of {} loads", programs.size());
}

void require_equal_grids(const std::vector<const LoadProgram*>& programs, double refine) {
  const LoadProgram& first = *programs.front();
  const std::vector<double> ends = first.step_ends(refine), outputs = first.output_times();
  for (const LoadProgram* program : programs) {
    if (program->step_ends(refine) != ends || program->output_times() != outputs) {
      throw core::InputError("load '" + program->name() + "'", "another time grid than '" + first.name() + "'",
                             "programs of equal phases, time_step_s and output_s in one block");
    }
  }
}

/// A block of loads on its way through time, one load a column.
class BlockRun {
public:
  BlockRun(ThermalStepper& stepper, const std::vector<const OperatingModel*>& models,
           const std::vector<const LoadProgram*>& programs, const SimulationOptions& options,
           const std::function<void(const OutputState&)>& on_output)
      : stepper_(stepper),
        models_(models),
        programs_(programs),
        options_(options),
        on_output_(on_output),
        ends_(programs.front()->step_ends(options.refine)),
        outputs_(programs.front()->output_times()),
        offsets_(offsets()),
        state_(start()),
        readings_(read(state_)),
        drives_(drives_at_start()),
        following_(stepper, drives_, offsets_),
        coefficients_(drives_.size()) {}

  RunSummary run() {
    resume_or_begin();
    std::optional<core::Progress> progress;
    if (options_.progress) progress.emplace(label(programs_), ends_.size() - done_);
    summary_.shortest_step = ends_.back();
    for (std::size_t i = 0; i < ends_.size(); ++i) {
      const double time = i > 0 ? ends_[i - 1] : 0.0, end = ends_[i];
      count(end - time);
      if (i < done_) continue;
      for (std::size_t l = 0; l < drives_.size(); ++l) {
        const bool as_before = l > 0 && programs_[l] == programs_[l - 1];
        drives_[l].row = as_before ? drives_[l - 1].row : programs_[l]->row(time, end);
      }
      step(end - time);
      done_ = i + 1;
      report(end);
      keep(progress);
    }
    return summary_;
  }

private:
  Eigen::MatrixXd read(const Eigen::MatrixXd& of) const { return stepper_.sensors(of) + offsets_; }

  Eigen::MatrixXd offsets() const {
    Eigen::MatrixXd of_loads(std::ssize(models_.front()->machine().sensors) + std::ssize(stepper_.layout().observed),
                             std::ssize(models_));
    for (Index l = 0; l < of_loads.cols(); ++l)
      of_loads.col(l) = sensor_offsets(models_[l]->machine(), stepper_.layout());
    return of_loads;
  }

  Eigen::MatrixXd start() const {
    Eigen::MatrixXd state(stepper_.size(), std::ssize(programs_));
    for (Index l = 0; l < state.cols(); ++l) {
      state.col(l) = options_.start.size() > 0
                         ? options_.start
                         : stepper_.uniform(programs_[l]->initial_C() - models_[l]->machine().reference_C);
    }
    return state;
  }

  std::vector<Drive> drives_at_start() const {
    std::vector<Drive> drives;
    for (std::size_t l = 0; l < programs_.size(); ++l) {
      const OperatingModel& model = *models_[l];
      Drive drive{&model, programs_[l], std::nullopt, {}};
      drive.row = drive.program->row(0.0, ends_.front());
      drive.chiller.emplace(
          model.machine(), stepper_.layout(), model.channels(),
          chiller_set_points(model.machine(), stepper_.layout(), readings_.col(l), model.guide_K(drive.row)));
      drives.push_back(std::move(drive));
    }
    return drives;
  }

  void resume_or_begin() {
    if (options_.checkpoint && options_.checkpoint->restore([this](core::BinaryReader& in) { load(in); })) {
      readings_ = read(state_);
      summary_.resumed_at = done_ > 0 ? ends_[done_ - 1] : 0.0;
    } else {
      report(0.0);
    }
  }

  void count(double step) {
    summary_.shortest_step = std::min(summary_.shortest_step, step);
    summary_.longest_step = std::max(summary_.longest_step, step);
    ++summary_.steps;
  }

  void step(double step) {
    Eigen::MatrixXd before;
    if (options_.balances) before = state_;
    if (following_.needed())
      following_.advance(state_, readings_, step, coefficients_, summary_);
    else
      advance(step);
    if (options_.balances) balance(before, step);
    if (options_.on_step) options_.on_step(coefficients_, step);
  }

  /// A step whose coefficients are known at its start.
  void advance(double step) {
    for (std::size_t l = 0; l < drives_.size(); ++l) {
      Drive& drive = drives_[l];
      const VectorXd guide = drive.model->guide_K(drive.row);
      const VectorXd& inlet = drive.chiller->advance(drive.row, readings_.col(l), guide, step);
      drive.model->coefficients(drive.row, inlet, {}, coefficients_[l]);
    }
    stepper_.advance(state_, coefficients_, step);
    readings_ = read(state_);
  }

  void balance(const Eigen::MatrixXd& before, double step) {
    for (std::size_t l = 0; l < drives_.size(); ++l) {
      (*options_.balances)[l].add(before.col(l), state_.col(l), stepper_.mean_over_step()->col(l), coefficients_[l].p,
                                  coefficients_[l].q, step, stepper_.local_change(l));
    }
  }

  void report(double time) {
    if (next_output_ >= outputs_.size() || time < outputs_[next_output_] - 1e-9 * ends_.back()) return;
    const Index sensors = std::ssize(models_.front()->machine().sensors);
    for (std::size_t l = 0; l < drives_.size(); ++l)
      on_output_({l, next_output_, time, state_.col(l), readings_.col(l).head(sensors), drives_[l].row});
    ++next_output_;
  }

  /// Writes a checkpoint when one is due, and before an interruption ends the run.
  void keep(std::optional<core::Progress>& progress) {
    const auto write = [this](core::BinaryWriter& out) { save(out); };
    try {
      if (progress)
        progress->advance();
      else
        core::check_interrupt();
    } catch (const core::Interrupted&) {
      if (options_.checkpoint) options_.checkpoint->write(write);
      throw;
    }
    if (options_.checkpoint && done_ < ends_.size() && options_.checkpoint->due()) options_.checkpoint->write(write);
  }

  void save(core::BinaryWriter& out) const {
    out.count(done_);
    out.count(next_output_);
    out.matrix(state_);
    for (const Drive& drive : drives_) drive.chiller->save(out);
    following_.save(out);
    if (options_.balances)
      for (const HeatBalance& balance : *options_.balances) balance.save(out);
    stepper_.save(out);
  }

  void load(core::BinaryReader& in) {
    done_ = in.count();
    next_output_ = in.count();
    state_ = in.matrix();
    for (Drive& drive : drives_) drive.chiller->load(in);
    following_.load(in);
    if (options_.balances)
      for (HeatBalance& balance : *options_.balances) balance.load(in);
    stepper_.load(in);
  }

  ThermalStepper& stepper_;
  const std::vector<const OperatingModel*>& models_;
  const std::vector<const LoadProgram*>& programs_;
  const SimulationOptions& options_;
  const std::function<void(const OutputState&)>& on_output_;
  const std::vector<double> ends_, outputs_;  // s
  const Eigen::MatrixXd offsets_;             // (sensors + observed x loads) K
  Eigen::MatrixXd state_, readings_;
  std::vector<Drive> drives_;
  FollowingStep following_;
  std::vector<Coefficients> coefficients_;
  std::size_t done_ = 0, next_output_ = 0;
  RunSummary summary_;
};

}  // namespace

RunSummary simulate_block(ThermalStepper& stepper, const std::vector<const OperatingModel*>& models,
                          const std::vector<const LoadProgram*>& programs, const SimulationOptions& options,
                          const std::function<void(const OutputState&)>& on_output) {
  options.validate();
  if (models.size() != programs.size()) {
    throw core::InputError("simulate_block", fmt::format("{} models of {} programs", models.size(), programs.size()),
                           "one for each");
  }
  if (programs.empty()) return {};
  require_equal_grids(programs, options.refine);
  return BlockRun(stepper, models, programs, options, on_output).run();
}

}  // namespace thermotwin::solver
