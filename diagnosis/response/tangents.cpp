// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/tangents.h"

#include <algorithm>
#include <iterator>

#include "core/thread_pool.h"
#include "diagnosis/response/operator_factors.h"
#include "diagnosis/response/step_coefficients.h"
#include "solver/thermal/integrator.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr std::size_t columns_in_block = 32;  ///< fixed, so that results do not depend on threads
constexpr double share = (1.0 - solver::sdirk_gamma) / solver::sdirk_gamma;

double height(const Disturbance& d, double time) {
  if (time <= d.from || time >= d.to) return time == d.peak ? 1.0 : 0.0;
  return time < d.peak ? (time - d.from) / (d.peak - d.from) : (d.to - time) / (d.to - d.peak);
}

}  // namespace

struct NominalRun::Work {
  const reduction::ReducedSystem& system;
  bool identity;
  StepCoefficients drive;
  OperatorFactors factors;
  VectorXd heat;
  const OperatorFactors::Entry* factor = nullptr;

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
  work_->heat = system.inputs * work_->drive.q().head(system.inputs.cols());
  work_->drive.add_heat(work_->heat, 1.0);
  work_->factor = &work_->factors.get(work_->drive.p(), step_, columns + 2);
  first_ = work_->factor->solve(work_->stored(nominal_, state_) + scale_ * work_->heat);
  next_ = state_ + share * (first_ - state_);
  last_ = work_->factor->solve(work_->stored(nominal_, next_) + scale_ * work_->heat);
}

void NominalRun::finish() { state_ = last_; }

NominalRun::Kept NominalRun::keep() const { return {state_, work_->drive.chiller()}; }

void NominalRun::take_up(const Kept& kept) {
  state_ = kept.state;
  work_->drive.set_chiller(kept.chiller);
}

MatrixXd NominalRun::stored(const MatrixXd& columns) const { return work_->stored(nominal_, columns); }

MatrixXd NominalRun::solve(const MatrixXd& columns) const { return work_->factor->solve(columns); }

struct Tangents::Drives {
  std::vector<std::unique_ptr<StepCoefficients>> each;
  OperatorFactors factors;  ///< of flows that hold instead

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
    drives_->each.push_back(std::make_unique<StepCoefficients>(run.nominal_.model, variant(v).machine));
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
  const StepCoefficients& nominal = run_.work_->drive;
  const VectorXd& q = nominal.q();
  const MatrixXd sensors = system.sensors * state_;
  VectorXd heat(state_.rows());
  for (std::size_t v = 0; v < count_; ++v) {
    StepCoefficients& drive = *drives_->each[v];
    const auto& disturbance = variant(v).disturbance;
    const double by_K = disturbance ? height(*disturbance, 0.5 * (obs.points[step] + obs.points[step + 1])) : 0.0;
    drive.update(obs, step, run_.sensors_ + sensors.col(v), disturbance ? disturbance->ambient : 0, by_K,
                 variant(v).held);
    heat.setZero();
    for (Index k = 0; k < system.inputs.cols(); ++k)
      if (const double change = drive.q()[k] - q[k]; change != 0.0) heat += change * system.inputs.col(k);
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
  const VectorXd& p = work.drive.p();
  for (std::size_t v = 0; v < count_; ++v) {
    auto column = right.col(v);
    const VectorXd& own = drives_->each[v]->p();
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
    if (variant(v).held && switches_flow(p, drives_->each[v]->p()))
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
  return drives_->factors.get(drives_->each[v]->p(), run_.step_, 1).solve(right) - nominal;
}

Tangents::Kept Tangents::keep() const {
  Kept kept{state_, {}};
  for (const auto& drive : drives_->each) kept.chillers.push_back(drive->chiller());
  return kept;
}

void Tangents::take_up(const Kept& kept) {
  state_ = kept.state;
  for (std::size_t v = 0; v < count_; ++v) drives_->each[v]->set_chiller(kept.chillers[v]);
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
