// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/tangents.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <list>

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
    const double held_share =
        held ? std::clamp((std::min(end, held->to) - std::max(begin, held->from)) / duration, 0.0, 1.0) : 0.0;
    const auto mixed = obs.mixed.find(step);
    if (mixed == obs.mixed.end() && held_share < negligible_share)
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
      add(obs.rows.row(step).transpose(), 1.0 - held_share);
    else {
      for (const Observations::Part& part_held : mixed->second)
        add(part_held.row, (1.0 - held_share) * part_held.share);
    }
    if (held) add(held->row, held_share);
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

}  // namespace

struct NominalRun::Work {
  const reduction::ReducedSystem& system;
  bool identity;
  Drive drive;
  Factors factors;
  VectorXd heat;
  const Factors::Entry* factor = nullptr;

  explicit Work(const Nominal& n)
      : system(n.model.system),
        identity(n.capacity == MatrixXd::Identity(n.capacity.rows(), n.capacity.cols())),
        drive(n.model, n.machine),
        factors(system, n.capacity) {}

  template <class Columns>
  MatrixXd stored(const Nominal& nominal, const Columns& columns) const {
    return identity ? MatrixXd(columns) : MatrixXd(nominal.capacity * columns);
  }
};

NominalRun::NominalRun(const Nominal& nominal)
    : nominal_(nominal),
      work_(std::make_unique<Work>(nominal)),
      state_(nominal.model.system.one_kelvin * (nominal.observations.start_C - nominal.machine.reference_C)) {}

NominalRun::~NominalRun() = default;

void NominalRun::advance(Index step, Index columns) {
  const Observations& obs = nominal_.observations;
  const reduction::ReducedSystem& system = work_->system;
  step_ = obs.points[step + 1] - obs.points[step];
  scale_ = solver::sdirk_gamma * step_;
  sensors_ = system.sensors * state_;
  work_->drive.update(obs, step, sensors_);
  work_->heat = system.inputs * work_->drive.c.q.head(system.inputs.cols());
  work_->drive.add_heat(work_->heat, 1.0);
  work_->factor = &work_->factors.get(work_->drive.c.p, step_, columns + 2);
  first_ = work_->factor->solve(work_->stored(nominal_, state_) + scale_ * work_->heat);
  next_ = state_ + share * (first_ - state_);
  last_ = work_->factor->solve(work_->stored(nominal_, next_) + scale_ * work_->heat);
}

void NominalRun::finish() { state_ = last_; }

NominalRun::Kept NominalRun::keep() const { return {state_, work_->drive.chiller}; }

void NominalRun::take_up(const Kept& kept) {
  state_ = kept.state;
  work_->drive.chiller = kept.chiller;
}

MatrixXd NominalRun::stored(const MatrixXd& columns) const { return work_->stored(nominal_, columns); }

MatrixXd NominalRun::solve(const MatrixXd& columns) const { return work_->factor->solve(columns); }

struct Tangents::Drives {
  std::vector<std::unique_ptr<Drive>> each;
  Factors factors;  ///< of flows that hold instead

  explicit Drives(const Nominal& nominal) : factors(nominal.model.system, nominal.capacity) {}
};

Tangents::Tangents(const NominalRun& run, const std::vector<Variant>& variants, std::size_t first, std::size_t last)
    : run_(run),
      variants_(variants),
      first_(first),
      count_(last - first),
      drives_(std::make_unique<Drives>(run.nominal_)),
      image_(run.work_->system.terms.size()),
      known_(run.work_->system.terms.size()) {
  const reduction::ReducedSystem& system = run.work_->system;
  state_.resize(system.order(), count_);
  heat_.resize(system.order(), count_);
  for (std::size_t v = 0; v < count_; ++v) {
    drives_->each.push_back(std::make_unique<Drive>(run.nominal_.model, variant(v).machine));
    state_.col(v) = system.one_kelvin * variant(v).start_K;
    if (variant(v).start.size() > 0) state_.col(v) += variant(v).start;
  }
}

Tangents::~Tangents() = default;

void Tangents::advance(Index step) {
  update(step);
  const MatrixXd stage = solve(state_, run_.first_, run_.state_);
  const MatrixXd next = state_ + share * (stage - state_);
  state_ = solve(next, run_.last_, run_.next_);
}

/// Coefficients of the step, and what they change of the heat.
void Tangents::update(Index step) {
  const Observations& obs = run_.nominal_.observations;
  const reduction::ReducedSystem& system = run_.work_->system;
  const Drive& nominal = run_.work_->drive;
  const VectorXd& q = nominal.c.q;
  const MatrixXd sensors = system.sensors * state_;
  VectorXd heat(state_.rows());
  for (std::size_t v = 0; v < count_; ++v) {
    Drive& drive = *drives_->each[v];
    const auto& disturbance = variant(v).disturbance;
    const double by_K = disturbance ? height(*disturbance, 0.5 * (obs.points[step] + obs.points[step + 1])) : 0.0;
    drive.update(obs, step, run_.sensors_ + sensors.col(v), disturbance ? disturbance->ambient : 0, by_K,
                 variant(v).held);
    heat.setZero();
    for (Index k = 0; k < system.inputs.cols(); ++k)
      if (const double change = drive.c.q[k] - q[k]; change != 0.0) heat += change * system.inputs.col(k);
    drive.add_heat(heat, 1.0);
    nominal.add_heat(heat, -1.0);
    if (variant(v).heat_map) heat = (*variant(v).heat_map * heat).eval();
    heat_.col(v) = heat;
  }
}

/// @param nominal, before  the stage of the nominal state and what it starts from
MatrixXd Tangents::solve(const MatrixXd& start, const VectorXd& nominal, const VectorXd& before) {
  std::fill(known_.begin(), known_.end(), 0);
  MatrixXd right = heat_;
  const NominalRun::Work& work = *run_.work_;
  const VectorXd& p = work.drive.c.p;
  for (std::size_t v = 0; v < count_; ++v) {
    auto column = right.col(v);
    const VectorXd& own = drives_->each[v]->c.p;
    for (Index j = 0; j < p.size(); ++j) {
      const double change = own[j] - p[j];
      if (change == 0.0) continue;
      const std::size_t term = j;
      if (!known_[term]) image_[term].noalias() = work.system.terms[term] * nominal, known_[term] = 1;
      column -= change * image_[term];
    }
    if (const MatrixXd& change = variant(v).capacity_change; change.size() > 0)
      column -= change * (nominal - before) / run_.scale_;
  }
  right = work.stored(run_.nominal_, start) + run_.scale_ * right;
  MatrixXd result = work.factor->solve(right);
  for (std::size_t v = 0; v < count_; ++v)
    if (variant(v).held && switches_flow(p, drives_->each[v]->c.p))
      result.col(v) = held_exactly(v, start, nominal, before);
  return result;
}

/// A pump that runs or stands for a while instead changes more than a tangent can tell: the fluid takes on other
/// temperatures within seconds, and with them the heat that it carries off.
bool Tangents::switches_flow(const VectorXd& p, const VectorXd& own) const {
  const std::vector<solver::Term>& terms = run_.nominal_.model.system.layout.terms;
  for (Index j = 0; j < p.size(); ++j)
    if (own[j] != p[j] && terms[j].kind == solver::TermKind::coolant_flow) return true;
  return false;
}

VectorXd Tangents::held_exactly(std::size_t v, const MatrixXd& start, const VectorXd& nominal, const VectorXd& before) {
  const NominalRun::Work& work = *run_.work_;
  const VectorXd from = before + start.col(v), heat = work.heat + heat_.col(v);
  const VectorXd right = work.stored(run_.nominal_, from) + run_.scale_ * heat;
  return drives_->factors.get(drives_->each[v]->c.p, run_.step_, 1).solve(right) - nominal;
}

Tangents::Kept Tangents::keep() const {
  Kept kept{state_, {}};
  for (const auto& drive : drives_->each) kept.chillers.push_back(drive->chiller);
  return kept;
}

void Tangents::take_up(const Kept& kept) {
  state_ = kept.state;
  for (std::size_t v = 0; v < count_; ++v) drives_->each[v]->chiller = kept.chillers[v];
}

RunWithTangents::RunWithTangents(const Nominal& nominal, const std::vector<Variant>& variants)
    : run_(nominal),
      blocks_((variants.size() + columns_in_block - 1) / columns_in_block),
      variants_(std::ssize(variants)) {
  core::parallel_for(0, blocks_.size(), [&](std::size_t b) {
    blocks_[b] = std::make_unique<Tangents>(run_, variants, b * columns_in_block,
                                            std::min((b + 1) * columns_in_block, variants.size()));
  });
}

void RunWithTangents::advance(Index step) {
  run_.advance(step, 2 * variants_);
  core::parallel_for(0, blocks_.size(), [&](std::size_t b) { blocks_[b]->advance(step); });
  run_.finish();
}

MatrixXd RunWithTangents::tangents() const {
  MatrixXd all(run_.state().size(), variants_);
  for (const auto& block : blocks_) all.middleCols(block->first(), block->state().cols()) = block->state();
  return all;
}

bool RunWithTangents::finite() const {
  return run_.state().allFinite() &&
         std::all_of(blocks_.begin(), blocks_.end(), [](const auto& block) { return block->state().allFinite(); });
}

RunWithTangents::Kept RunWithTangents::keep() const {
  Kept kept{run_.keep(), {}};
  for (const auto& block : blocks_) kept.blocks.push_back(block->keep());
  return kept;
}

void RunWithTangents::take_up(const Kept& kept) {
  run_.take_up(kept.run);
  for (std::size_t b = 0; b < blocks_.size(); ++b) blocks_[b]->take_up(kept.blocks[b]);
}

}  // namespace thermotwin::diagnosis
