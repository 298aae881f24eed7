// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/propagation.h"

#include <Eigen/LU>

#include <algorithm>
#include <iterator>
#include <list>
#include <memory>

#include "core/error.h"
#include "core/thread_pool.h"
#include "diagnosis/causes/parameter_sizes.h"
#include "solver/campaign/simulation.h"
#include "solver/thermal/integrator.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr std::size_t columns_in_block = 32;  ///< fixed, so that results do not depend on threads
constexpr std::size_t kept_factors = 6;       ///< programs alternate between a few states
constexpr double negligible_share = 1e-9;     ///< of a step
constexpr int most_changes = 100;             ///< of a sum of matrices, until rounding is taken out
constexpr double share = (1.0 - solver::sdirk_gamma) / solver::sdirk_gamma;

/// A machine with its factors from a time of the record on up to the k-th of them, in order of time.
mesh::Machine with_later(const MachineInTime& machine, std::size_t count) {
  mesh::Machine changed = machine;
  for (std::size_t k = 0; k < count; ++k) {
    const LaterFactor& later = machine.later[k];
    for (mesh::SourceSpec& source : changed.sources)
      if (!later.joint && source.id == later.item) source.scale.value *= later.factor;
    for (mesh::JointSpec& joint : changed.joints)
      if (later.joint && joint.id == later.item) joint.conductance.value *= later.factor;
  }
  return changed;
}

MachineInTime in_order(MachineInTime machine) {
  std::stable_sort(machine.later.begin(), machine.later.end(),
                   [](const auto& a, const auto& b) { return a.from_s < b.from_s; });
  return machine;
}

/// The machine from a time of the record on.
struct Afterwards {
  double from_s;
  solver::OperatingModel model;
};

/// One machine's way from channels to coefficients, with its chillers.
struct Drive {
  AddedSources added;
  solver::OperatingModel model;
  std::vector<Afterwards> afterwards;  ///< rising times
  VectorXd sensor_offsets;
  std::optional<solver::Chiller> chiller;
  solver::Coefficients c, part, then;

  Drive(const reduction::ReducedModel& reduced, const MachineInTime& machine)
      : added(added_sources(reduced, machine)),
        model(machine, added.layout),
        sensor_offsets(solver::sensor_offsets(machine, added.layout)) {
    if (machine.later.empty()) return;
    const MachineInTime ordered = in_order(machine);
    for (std::size_t k = 0; k < ordered.later.size(); ++k)
      afterwards.push_back({ordered.later[k].from_s, {with_later(ordered, k + 1), added.layout}});
  }

  /// Of a row by the machine between two times.
  void between(double begin, double end, const VectorXd& row, const VectorXd& inlets, const VectorXd& readings,
               solver::Coefficients& out) {
    model.coefficients(row, inlets, readings, out);
    for (const Afterwards& after : afterwards) {
      const double share_after = std::clamp((end - after.from_s) / (end - begin), 0.0, 1.0);
      if (share_after < negligible_share) break;
      after.model.coefficients(row, inlets, readings, then);
      out.p += share_after * (then.p - out.p);
      out.q += share_after * (then.q - out.q);
    }
  }

  /// The row with one ambient's temperature moved.
  VectorXd disturbed(const VectorXd& row, int ambient, double by_K) const {
    VectorXd moved = row;
    const mesh::AmbientSpec& spec = model.machine().ambients[ambient];
    double& channel = moved[model.channels().index(spec.id + ".T_C")];
    // One that follows gets a temperature of its own.
    if (!std::isfinite(channel)) channel = model.ambient_K(ambient, row) + model.machine().reference_C;
    channel += by_K;
    return moved;
  }
  /// @param begin, end  of the step   @param duration  of the part of it that the row holds for
  void coefficients(double begin, double end, const VectorXd& measured, const VectorXd& readings, int ambient,
                    double by_K, double duration, solver::Coefficients& out) {
    const VectorXd row = by_K != 0.0 ? disturbed(measured, ambient, by_K) : measured, guide = model.guide_K(row);
    if (!chiller) {
      chiller.emplace(model.machine(), model.layout(), model.channels(),
                      solver::chiller_set_points(model.machine(), model.layout(), readings, guide));
    }
    between(begin, end, row, chiller->advance(row, readings, guide, duration), readings, out);
  }
  /// Of a step: the mean of those of its parts.
  /// @param sensors_K (sensors) temperatures at the sensors, without their offsets  @param ambient, by_K  moved by so
  ///   much
  /// @param held  null, or inputs that hold for a while instead
  void update(const Observations& obs, Index step, const VectorXd& sensors_K, int ambient = 0, double by_K = 0.0,
              const Observations::MayHold* held = nullptr) {
    const double begin = obs.points[step], end = obs.points[step + 1], duration = end - begin;
    const VectorXd readings = sensors_K + sensor_offsets;
    const double share_held =
        held ? std::clamp((std::min(end, held->to) - std::max(begin, held->from)) / duration, 0.0, 1.0) : 0.0;
    const auto mixed = obs.mixed.find(step);
    if (mixed == obs.mixed.end() && share_held < negligible_share)
      return coefficients(begin, end, obs.rows.row(step).transpose(), readings, ambient, by_K, duration, c);
    c.p.setZero(std::ssize(model.layout().terms));
    c.q.setZero(std::ssize(model.layout().inputs));
    const auto add = [&](const VectorXd& row, double of) {
      if (of < negligible_share) return;
      coefficients(begin, end, row, readings, ambient, by_K, of * duration, part);
      c.p += of * part.p;
      c.q += of * part.q;
    };
    if (mixed == obs.mixed.end())
      add(obs.rows.row(step).transpose(), 1.0 - share_held);
    else {
      for (const Observations::Part& part_held : mixed->second)
        add(part_held.row, (1.0 - share_held) * part_held.share);
    }
    if (held) add(held->row, share_held);
  }
  /// Of sources that the reduced model's own layout does not have.
  void add_heat(VectorXd& heat, double factor) const {
    if (added.inputs.cols() > 0) heat += factor * (added.inputs * c.q.tail(added.inputs.cols()));
  }
};

/// The last few operators E + gamma h A. Products with an inverse are faster than solves, once it is
/// used for as many columns as it has.
class Factors {
public:
  Factors(const reduction::ReducedSystem& system, const MatrixXd& capacity) : system_(system), capacity_(capacity) {}

  struct Entry {
    VectorXd p;
    double step = 0;
    Eigen::PartialPivLU<MatrixXd> lu;
    MatrixXd inverse;
    Index solved = 0;  ///< columns so far

    template <class Columns>
    MatrixXd solve(const Columns& columns) const {
      return inverse.size() > 0 ? MatrixXd(inverse * columns) : MatrixXd(lu.solve(columns));
    }
  };
  /// @param columns  that will be solved for
  const Entry& get(const VectorXd& p, double step, Index columns) {
    auto at = std::find_if(kept_.begin(), kept_.end(),
                           [&](const Entry& entry) { return entry.step == step && entry.p == p; });
    if (at != kept_.end()) {
      kept_.splice(kept_.begin(), kept_, at);
    } else {
      if (kept_.size() >= kept_factors) kept_.pop_back();
      Entry& entry = kept_.emplace_front();
      entry.p = p;
      entry.step = step;
      entry.lu.compute(capacity_ + solver::sdirk_gamma * step * conduction(p));
    }
    Entry& entry = kept_.front();
    entry.solved += columns;
    if (entry.inverse.size() == 0 && entry.solved > system_.order()) entry.inverse = entry.lu.inverse();
    return entry;
  }

private:
  /// K0 + sum p K. From step to step few coefficients change; reading all terms would take longer than a factor.
  const MatrixXd& conduction(const VectorXd& p) {
    const bool anew = sum_.size() == 0 || ++changes_ > most_changes;
    if (anew) {
      sum_ = system_.conduction;
      sum_p_ = VectorXd::Zero(p.size());
      changes_ = 0;
    }
    for (Index j = 0; j < p.size(); ++j)
      if (p[j] != sum_p_[j]) sum_ += (p[j] - sum_p_[j]) * system_.terms[j];
    sum_p_ = p;
    return sum_;
  }

  const reduction::ReducedSystem& system_;
  const MatrixXd& capacity_;
  std::list<Entry> kept_;
  MatrixXd sum_;
  VectorXd sum_p_;
  int changes_ = 0;
};

double height(const Disturbance& d, double time) {
  if (time <= d.from || time >= d.to) return time == d.peak ? 1.0 : 0.0;
  return time < d.peak ? (time - d.from) / (d.peak - d.from) : (d.to - time) / (d.to - d.peak);
}

/// The nominal machine, step by step.
struct Run {
  const Nominal& nominal;
  const reduction::ReducedSystem& system;
  bool identity;
  Drive drive;
  Factors factors;
  VectorXd state, sensors;           ///< at the start of the step
  VectorXd heat, first, next, last;  ///< stages and what the second one starts from
  const Factors::Entry* factor = nullptr;
  double step = 0, scale = 0;

  explicit Run(const Nominal& n)
      : nominal(n),
        system(n.model.system),
        identity(n.capacity == MatrixXd::Identity(n.capacity.rows(), n.capacity.cols())),
        drive(n.model, n.machine),
        factors(system, n.capacity),
        state(system.one_kelvin * (n.observations.start_C - n.machine.reference_C)) {}

  template <class Columns>
  MatrixXd stored(const Columns& columns) const {
    return identity ? MatrixXd(columns) : MatrixXd(nominal.capacity * columns);
  }
  /// @param columns  that are solved for beside the state, both stages
  void advance(Index s, Index columns) {
    const Observations& obs = nominal.observations;
    step = obs.points[s + 1] - obs.points[s];
    scale = solver::sdirk_gamma * step;
    sensors = system.sensors * state;
    drive.update(obs, s, sensors);
    heat = system.inputs * drive.c.q.head(system.inputs.cols());
    drive.add_heat(heat, 1.0);
    factor = &factors.get(drive.c.p, step, columns + 2);
    first = factor->solve(stored(state) + scale * heat);
    next = state + share * (first - state);
    last = factor->solve(stored(next) + scale * heat);
  }
  void finish() { state = last; }
};

[[noreturn]] void not_finite() {
  throw core::SolverError(
      "diagnosis: the reduced model's state is no longer finite; look for NaN in the measured inputs");
}

/// Tangents of some variants, advanced beside a run.
class Tangents {
public:
  Tangents(const Run& run, const std::vector<Variant>& variants, std::size_t first, std::size_t last)
      : run_(run),
        variants_(variants),
        first_(first),
        count_(last - first),
        image_(run.system.terms.size()),
        known_(run.system.terms.size()) {
    const Index r = run.system.order();
    state_.resize(r, count_);
    heat_.resize(r, count_);
    for (std::size_t v = 0; v < count_; ++v) {
      drives_.push_back(std::make_unique<Drive>(run.nominal.model, variant(v).machine));
      state_.col(v) = run.system.one_kelvin * variant(v).start_K;
      if (variant(v).start.size() > 0) state_.col(v) += variant(v).start;
    }
  }

  void record(const VectorXd& nominal_state, Index point, std::vector<MatrixXd>& out) const {
    const MatrixXd all = run_.nominal.rows * state_;
    for (std::size_t v = 0; v < count_; ++v) {
      auto row = out[first_ + v + 1].row(point);
      row = all.col(v).transpose();
      if (variant(v).row_change.size() > 0) row += (variant(v).row_change * nominal_state).transpose();
    }
  }

  void advance(Index s) {
    update(s);
    const MatrixXd stage = solve(state_, run_.first, run_.state);
    const MatrixXd next = state_ + share * (stage - state_);
    state_ = solve(next, run_.last, run_.next);
  }
  bool finite() const { return state_.allFinite(); }

private:
  const Variant& variant(std::size_t v) const { return variants_[first_ + v]; }

  /// Coefficients of the step, and what they change of the heat.
  void update(Index s) {
    const Observations& obs = run_.nominal.observations;
    const VectorXd& q = run_.drive.c.q;
    const MatrixXd sensors = run_.system.sensors * state_;
    VectorXd heat(state_.rows());
    for (std::size_t v = 0; v < count_; ++v) {
      Drive& drive = *drives_[v];
      const auto& disturbance = variant(v).disturbance;
      const double by_K = disturbance ? height(*disturbance, 0.5 * (obs.points[s] + obs.points[s + 1])) : 0.0;
      drive.update(obs, s, run_.sensors + sensors.col(v), disturbance ? disturbance->ambient : 0, by_K,
                   variant(v).held);
      heat.setZero();
      for (Index k = 0; k < run_.system.inputs.cols(); ++k)
        if (const double change = drive.c.q[k] - q[k]; change != 0.0) heat += change * run_.system.inputs.col(k);
      drive.add_heat(heat, 1.0);
      run_.drive.add_heat(heat, -1.0);
      if (variant(v).heat_map) heat = (*variant(v).heat_map * heat).eval();
      heat_.col(v) = heat;
    }
  }

  /// @param nominal, before  the stage of the nominal state and what it starts from
  MatrixXd solve(const MatrixXd& start, const VectorXd& nominal, const VectorXd& before) {
    std::fill(known_.begin(), known_.end(), 0);
    MatrixXd right = heat_;
    const VectorXd& p = run_.drive.c.p;
    for (std::size_t v = 0; v < count_; ++v) {
      auto column = right.col(v);
      const VectorXd& own = drives_[v]->c.p;
      for (Index j = 0; j < p.size(); ++j) {
        const double change = own[j] - p[j];
        if (change == 0.0) continue;
        const std::size_t term = j;
        if (!known_[term]) image_[term].noalias() = run_.system.terms[term] * nominal, known_[term] = 1;
        column -= change * image_[term];
      }
      if (const MatrixXd& change = variant(v).capacity_change; change.size() > 0)
        column -= change * (nominal - before) / run_.scale;
    }
    right = run_.stored(start) + run_.scale * right;
    return run_.factor->solve(right);
  }

  const Run& run_;
  const std::vector<Variant>& variants_;
  std::size_t first_, count_;
  std::vector<std::unique_ptr<Drive>> drives_;
  MatrixXd state_, heat_;        ///< (r x variants), in units of each variant's step
  std::vector<VectorXd> image_;  ///< K_j x of the present stage, where a variant asks for it
  std::vector<char> known_;
};

}  // namespace

std::vector<MatrixXd> propagate(const Nominal& nominal, const std::vector<Variant>& variants) {
  const Index points = nominal.observations.points.size(), outputs = nominal.rows.rows();
  const std::size_t m = variants.size();
  Run run(nominal);
  std::vector<std::unique_ptr<Tangents>> blocks((m + columns_in_block - 1) / columns_in_block);
  core::parallel_for(0, blocks.size(), [&](std::size_t b) {
    blocks[b] =
        std::make_unique<Tangents>(run, variants, b * columns_in_block, std::min((b + 1) * columns_in_block, m));
  });
  std::vector<MatrixXd> out(m + 1, MatrixXd(points, outputs));
  out[0].row(0) = (nominal.rows * run.state).transpose();
  for (const auto& block : blocks) block->record(run.state, 0, out);
  for (Index s = 0; s + 1 < points; ++s) {
    run.advance(s, 2 * std::ssize(variants));
    core::parallel_for(0, blocks.size(), [&](std::size_t b) {
      blocks[b]->advance(s);
      blocks[b]->record(run.last, s + 1, out);
    });
    run.finish();
    out[0].row(s + 1) = (nominal.rows * run.state).transpose();
  }
  if (!run.state.allFinite()) not_finite();
  for (const auto& block : blocks)
    if (!block->finite()) not_finite();
  return out;
}

std::vector<MatrixXd> propagate_heat(const Nominal& nominal, const MatrixXd& loads, const MatrixXd& series) {
  const Index points = nominal.observations.points.size(), outputs = nominal.rows.rows(),
              count = loads.cols() * series.cols();
  Run run(nominal);
  const Index width = columns_in_block, blocks = (count + width - 1) / width;
  std::vector<MatrixXd> state(blocks);
  for (Index b = 0; b < blocks; ++b) state[b].setZero(loads.rows(), std::min(width, count - b * width));
  std::vector<MatrixXd> out(count, MatrixXd::Zero(points, outputs));
  for (Index s = 0; s + 1 < points; ++s) {
    run.advance(s, 2 * count);
    core::parallel_for(0, blocks, [&](std::size_t b) {
      const Index first = b * width;
      MatrixXd& x = state[b];
      MatrixXd heat(x.rows(), x.cols());
      for (Index c = 0; c < x.cols(); ++c)
        heat.col(c) = run.scale * series(s, (first + c) / loads.cols()) * loads.col((first + c) % loads.cols());
      const MatrixXd stage = run.factor->solve(run.stored(x) + heat), next = x + share * (stage - x);
      x = run.factor->solve(run.stored(next) + heat);
      const MatrixXd all = nominal.rows * x;
      for (Index c = 0; c < x.cols(); ++c) out[first + c].row(s + 1) = all.col(c).transpose();
    });
    run.finish();
  }
  for (const MatrixXd& x : state)
    if (!x.allFinite()) not_finite();
  return out;
}

}  // namespace thermotwin::diagnosis
