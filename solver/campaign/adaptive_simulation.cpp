// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/campaign/adaptive_simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "core/error.h"
#include "core/progress.h"
#include "solver/campaign/simulation.h"
#include "solver/thermal/adaptive.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double safety = 0.9;
constexpr int most_growth = 3;  // doublings at once
constexpr int most_shrink = 4;  // halvings at once
constexpr int first_rung = -8;  // of the program's first step, below the output interval
constexpr std::size_t progress_parts = 1000;
constexpr int event_samples = 8;  // places of the dense output that are looked at
constexpr int event_tries = 8;
constexpr double crumb = 1e-12;       // of the duration: what is left to a stop and is no step
constexpr double event_share = 1e-3;  // of the tolerance: how far from the band's end a switch may be

class AdaptiveRun {
public:
  AdaptiveRun(AdaptiveIntegrator& integrator, const OperatingModel& model, const LoadProgram& program,
              const SimulationOptions& options, const std::function<void(const OutputState&)>& on_output)
      : integrator_(integrator),
        model_(model),
        program_(program),
        options_(options),
        on_output_(on_output),
        machine_(model.machine()),
        time_options_(program.time()),
        offsets_(sensor_offsets(machine_, model.layout())),
        stops_(program.stops()),
        outputs_(program.output_times()),
        end_(stops_.back()) {
    tolerance_ = time_options_.tolerance_K * options.refine;
    base_ = std::min(program.output_interval(), time_options_.longest_step);
    highest_rung_ = rung_below(time_options_.longest_step);
    lowest_rung_ = std::min(highest_rung_, rung_above(time_options_.shortest_step));
    rung_ = after_corner_ = std::clamp(first_rung, lowest_rung_, highest_rung_);
    const ThermalSystem& system = integrator.system();
    state_ = options.start.size() > 0 ? options.start
                                      : VectorXd::Constant(system.size, program.initial_C() - machine_.reference_C);
    readings_ = read(state_);
    slope_ = VectorXd::Zero(readings_.size());
    row_ = program.row_at(0.0, 0.0);
    chiller_.emplace(machine_, model.layout(), model.channels(),
                     chiller_set_points(machine_, model.layout(), readings_, model.guide_K(row_)));
    summary_.shortest_step = end_;
  }

  RunSummary run() {
    Checkpoint* checkpoint = options_.checkpoint;
    const auto save = [this](core::BinaryWriter& out) { this->save(out); };
    if (checkpoint && checkpoint->restore([this](core::BinaryReader& in) { load(in); })) {
      summary_.resumed_at = time_;
    } else {
      report();
    }
    std::optional<core::Progress> progress;
    if (options_.progress) progress.emplace("thermal run '" + program_.name() + "'", progress_parts);
    std::size_t shown = parts_done();
    if (progress && shown > 0) progress->advance(shown);
    while (next_stop_ < stops_.size()) {
      step();
      report();
      try {
        const std::size_t now = parts_done();
        if (progress)
          progress->advance(now - shown);
        else
          core::check_interrupt();
        shown = now;
      } catch (const core::Interrupted&) {
        if (checkpoint) checkpoint->write(save);
        throw;
      }
      if (checkpoint && next_stop_ < stops_.size() && checkpoint->due()) checkpoint->write(save);
    }
    const AdaptiveIntegrator::Statistics& statistics = integrator_.statistics();
    summary_.factorisations = statistics.factorisations;
    summary_.iterations = statistics.iterations;
    summary_.most_factors = statistics.most_factors;
    return summary_;
  }

private:
  VectorXd read(const VectorXd& state) const { return integrator_.system().sensors * state + offsets_; }
  std::size_t parts_done() const { return static_cast<std::size_t>(progress_parts * time_ / end_); }
  double rung_size(int rung) const { return std::ldexp(base_, rung); }

  /// The next step: a rung of the ladder, or what is left to the next stop, in two halves where one
  /// rung would leave a crumb.
  struct Plan {
    double size;
    bool to_stop, on_ladder;
  };
  Plan plan() const {
    const double left = stops_[next_stop_] - time_, rung = rung_size(rung_);
    const double from_ladder = std::log2(left / base_);
    const bool left_on_ladder = std::abs(from_ladder - std::round(from_ladder)) < 1e-9;
    if (left <= rung * (1.0 + 1e-9)) return {left, true, left_on_ladder};
    if (left < 2.0 * rung * (1.0 - 1e-9)) return {0.5 * left, false, left_on_ladder};
    return {rung, false, true};
  }

  /// One try from the state at hand, with the readings of sensors that the chillers follow
  /// continued as they went; and what the chillers do with the readings that come out.
  struct Try {
    AdaptiveIntegrator::Step step;
    Chiller::Readings readings;  // over the step, as they came out
    VectorXd middle;             // channels of the step
    VectorXd p;                  // coefficients of the step
    double error = 0;
  };
  Try attempt(double size, bool on_ladder) {
    Try result;
    const double middle = time_ + 0.5 * size, stage = tr_bdf2_stage * size;
    result.middle = program_.row(time_, time_ + size);
    const std::array<double, 3> at{0.0, stage, size};
    Chiller::Readings expected{
        readings_, slope_, VectorXd::Zero(readings_.size()), model_.guide_K(program_.row_at(time_, middle)), {}};
    expected.guide_slope = (model_.guide_K(program_.row_at(time_ + size, middle)) - expected.guide) / size;
    std::array<VectorXd, 3> inlets;
    const bool follows = model_.follows_temperature() || integrator_.is_nonlinear();
    VectorXd end = state_;  // as expected
    for (int pass = 0;; ++pass) {
      std::array<VectorXd, 3> q;
      Coefficients c;
      const auto readings_at = [&](double s) {
        return VectorXd(expected.value + s * (expected.slope + s * expected.curve));
      };
      for (std::size_t i = 0; i < 3; ++i) {
        const VectorXd row = program_.row_at(time_ + at[i], middle);
        inlets[i] = chiller_->outlet_after(row, expected, at[i]);
        model_.coefficients(row, inlets[i], readings_at(0.5 * size), c);
        q[i] = c.q;
      }
      model_.coefficients(result.middle, inlets[1], readings_at(0.5 * size), c);
      if (integrator_.is_nonlinear()) integrator_.linearise(state_, end, c);
      result.p = c.p;
      integrator_.attempt(state_, c.p, q, size, on_ladder, result.step);

      result.readings = expected;
      const VectorXd to_stage = (read(result.step.stage) - readings_) / stage,
                     to_end = (read(result.step.end) - readings_) / size;
      result.readings.curve = (to_end - to_stage) / (size - stage);
      result.readings.slope = to_stage - stage * result.readings.curve;
      if (!follows) break;
      ++summary_.passes;
      const auto observed = std::ssize(model_.layout().observed);
      const VectorXd moved = size * (0.5 * (result.readings.slope - expected.slope) +
                                     0.25 * size * (result.readings.curve - expected.curve));
      double change = observed > 0 ? moved.tail(observed).cwiseAbs().maxCoeff() : 0.0;
      if (integrator_.is_nonlinear()) change = std::max(change, (result.step.end - end).cwiseAbs().maxCoeff());
      if (change <= iteration_K) break;
      if (pass + 1 >= most_passes) {
        ++summary_.unconverged;
        break;
      }
      expected = result.readings;
      end = result.step.end;
    }
    result.error = result.step.error_K;
    for (std::size_t i = 1; i < 3; ++i) {
      const VectorXd row = program_.row_at(time_ + at[i], middle);
      const VectorXd off = chiller_->outlet_after(row, result.readings, at[i]) - inlets[i];
      if (off.size() > 0) result.error = std::max(result.error, off.cwiseAbs().maxCoeff());
    }
    return result;
  }

  VectorXd beyond(const Try& tried, double s) const { return chiller_->beyond_band(tried.middle, tried.readings, s); }

  /// First time at which an outlet leaves its band, by bisection on the dense output.
  std::optional<std::pair<double, Index>> first_switch(const Try& tried, double size) const {
    std::optional<std::pair<double, Index>> first;
    for (Index i = 0; i < std::ssize(machine_.coolants); ++i) {
      double low = 0.0;
      for (int k = 0; k <= event_samples; ++k) {
        const double s = size * k / event_samples;
        if (beyond(tried, s)[i] < 0.0) {
          low = s;
          continue;
        }
        double high = s;
        for (int halvings = 0; halvings < 60 && high - low > 1e-15 * size; ++halvings) {
          const double middle = 0.5 * (low + high);
          (beyond(tried, middle)[i] < 0.0 ? low : high) = middle;
        }
        if (!first || high < first->first) first = {{high, i}};
        break;
      }
    }
    return first;
  }

  void step() {
    Plan next = plan();
    for (;;) {
      Try tried = attempt(next.size, next.on_ladder);
      const double ratio = tried.error / tolerance_;
      const bool shortest = next.size <= rung_size(lowest_rung_) * (1.0 + 1e-9);
      if (!(ratio <= 1.0) && !shortest) {
        ++summary_.rejected;
        const double wanted = std::isfinite(ratio) ? next.size * safety * std::pow(ratio, -1.0 / 3.0) : 0.0;
        const int below = std::clamp(rung_below(0.999 * next.size), lowest_rung_, highest_rung_);
        rung_ = std::max({lowest_rung_, below - most_shrink,
                          wanted > 0.0 ? std::min(below, rung_below(wanted)) : below - most_shrink});
        next = plan();
        continue;
      }
      if (const auto event = first_switch(tried, next.size)) {
        land_on_switch(*event, next);
        return;
      }
      if (!(ratio <= 1.0)) ++summary_.over_tolerance;
      accept(tried, next);
      grow(ratio, next.size);
      return;
    }
  }

  int rung_below(double size) const { return static_cast<int>(std::floor(std::log2(size / base_) + 1e-9)); }
  int rung_above(double size) const { return static_cast<int>(std::ceil(std::log2(size / base_) - 1e-9)); }

  void grow(double ratio, double size) {
    const double wanted = size * safety * std::pow(std::max(ratio, 1e-12), -1.0 / 3.0);
    // A step cut short by a stop says nothing against the rung it stands on.
    const int limit = std::max(rung_, rung_below(size) + most_growth);
    rung_ = std::clamp(std::max(rung_, std::min(limit, rung_below(wanted))), lowest_rung_, highest_rung_);
  }

  void accept(const Try& tried, const Plan& plan) {
    chiller_->move(tried.middle, tried.readings, plan.size);
    slope_ = tried.readings.slope + 2.0 * plan.size * tried.readings.curve;
    if (options_.balances) {
      options_.balances->front().add(state_, tried.step.end, tried.step.mean, tried.p, tried.step.q_mean, plan.size,
                                     integrator_.local_change());
    }
    state_ = tried.step.end;
    readings_ = read(state_);
    row_ = tried.middle;
    if (after_corner_open_) after_corner_ = std::min(rung_, rung_below(plan.size)), after_corner_open_ = false;
    ++summary_.steps;
    summary_.shortest_step = std::min(summary_.shortest_step, plan.size);
    summary_.longest_step = std::max(summary_.longest_step, plan.size);
    time_ += plan.size;
    if (!plan.to_stop && stops_[next_stop_] - time_ > crumb * end_) return;
    time_ = stops_[next_stop_++];
    if (next_stop_ < stops_.size() && program_.is_corner(time_)) {
      // What drives the machine jumps here: begin as after the last corner.
      rung_ = std::max(lowest_rung_, std::min(rung_, after_corner_));
      after_corner_open_ = true;
    }
  }

  /// Repeats the step so that it ends where a compressor switches. Another length gives another
  /// dense output: a few secant steps on the end until the outlet there is at the end of its band.
  void land_on_switch(std::pair<double, Index> event, Plan plan) {
    const Index coolant = event.second;
    const double whole = plan.size;
    if (event.first <= 1e-9 * whole) {
      toggle(coolant);
      return;
    }
    plan.to_stop = false;
    plan.on_ladder = false;
    plan.size = event.first;
    Try tried = attempt(plan.size, false);
    double low = 0.0, high = whole;  // the switch lies between
    for (int i = 0; i < event_tries; ++i) {
      ++summary_.rejected;
      const double off = beyond(tried, plan.size)[coolant];
      if (std::abs(off) <= event_share * tolerance_) break;
      (off < 0.0 ? low : high) = plan.size;
      const double ds = 1e-3 * plan.size;
      const double slope = (off - beyond(tried, plan.size - ds)[coolant]) / ds;
      double size = slope > 0.0 ? plan.size - off / slope : 0.5 * (low + high);
      if (!(size > low && size < high)) size = 0.5 * (low + high);
      plan.size = size;
      tried = attempt(size, false);
    }
    accept(tried, plan);
    toggle(coolant);
  }

  void toggle(Index coolant) {
    chiller_->toggle(coolant);
    summary_.switches.push_back({time_, static_cast<int>(coolant), chiller_->running(coolant)});
  }

  void report() {
    while (next_output_ < outputs_.size() && time_ >= outputs_[next_output_] - 1e-9 * end_) {
      on_output_({0, next_output_, time_, state_, readings_.head(std::ssize(machine_.sensors)), row_});
      ++next_output_;
    }
  }

  void save(core::BinaryWriter& out) const {
    out.number(time_);
    for (std::size_t value : {next_stop_, next_output_}) out.count(value);
    // Rungs may be negative, counts may not.
    for (int value : {rung_, after_corner_}) out.number(value);
    out.count(after_corner_open_ ? 1 : 0);
    for (const VectorXd* value : {&state_, &readings_, &slope_, &row_}) out.matrix(*value);
    chiller_->save(out);
    if (options_.balances) options_.balances->front().save(out);
    for (long value : {summary_.steps, summary_.rejected, summary_.over_tolerance}) out.count(value);
    out.number(summary_.shortest_step);
    out.number(summary_.longest_step);
    out.count(summary_.switches.size());
    for (const RunSummary::Switch& at : summary_.switches) {
      out.number(at.time);
      out.count(at.coolant);
      out.count(at.running ? 1 : 0);
    }
    integrator_.save(out);
  }

  void load(core::BinaryReader& in) {
    time_ = in.number();
    for (std::size_t* value : {&next_stop_, &next_output_}) *value = in.count();
    for (int* value : {&rung_, &after_corner_}) *value = static_cast<int>(in.number());
    after_corner_open_ = in.count() != 0;
    for (VectorXd* value : {&state_, &readings_, &slope_, &row_}) *value = in.matrix();
    chiller_->load(in);
    if (options_.balances) options_.balances->front().load(in);
    for (long* value : {&summary_.steps, &summary_.rejected, &summary_.over_tolerance}) *value = in.count();
    summary_.shortest_step = in.number();
    summary_.longest_step = in.number();
    summary_.switches.resize(in.count());
    for (RunSummary::Switch& at : summary_.switches) {
      at.time = in.number();
      at.coolant = in.count();
      at.running = in.count() != 0;
    }
    integrator_.load(in);
  }

  AdaptiveIntegrator& integrator_;
  const OperatingModel& model_;
  const LoadProgram& program_;
  const SimulationOptions& options_;
  const std::function<void(const OutputState&)>& on_output_;
  const mesh::Machine& machine_;
  const TimeOptions time_options_;
  const VectorXd offsets_;
  const std::vector<double> stops_, outputs_;
  const double end_;
  double tolerance_ = 0, base_ = 1;
  int lowest_rung_ = 0, highest_rung_ = 0;

  double time_ = 0;
  std::size_t next_stop_ = 0, next_output_ = 0;
  int rung_ = 0, after_corner_ = 0;  // the ladder's step now; that of the first step after the last corner
  bool after_corner_open_ = true;    // that step is still to come
  VectorXd state_, readings_, slope_, row_;
  std::optional<Chiller> chiller_;
  RunSummary summary_;
};

}  // namespace

RunSummary simulate_adaptive(AdaptiveIntegrator& integrator, const OperatingModel& model, const LoadProgram& program,
                             const SimulationOptions& options,
                             const std::function<void(const OutputState&)>& on_output) {
  options.validate();
  program.time().validate();
  return AdaptiveRun(integrator, model, program, options, on_output).run();
}

}  // namespace thermotwin::solver
