// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/model/reduced_model.h"

#include <Eigen/LU>
#include <fmt/format.h>

#include <array>
#include <cassert>
#include <cmath>

#include "core/error.h"
#include "core/range.h"
#include "solver/operation/layout.h"
#include "solver/thermal/integrator.h"

namespace thermotwin::reduction {
namespace {

constexpr int max_refinements = 5;    ///< a fresh factor costs about as much as ten of these
constexpr int kept_factors = 4;       ///< programs alternate between a few states
constexpr int exact_sum_after = 256;  ///< added differences before the operator is summed afresh

/// Factor of E + gamma h A for one set of coefficients and one step size.
struct Factor {
  Eigen::VectorXd p;
  double step = 0.0;
  long last_use = 0;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu;
};

/// A state that was met by refinement. Once it returns or stays, it earns a factor of its own.
struct Passed {
  Eigen::VectorXd p;
  double step = 0.0;
};

bool is_identity(const Eigen::MatrixXd& matrix) {
  return matrix == Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols());
}

/// Lower triangles of symmetric matrices, column by column without gaps: their weighted sum is bound
/// by memory, and this is half of it.
class PackedTriangles {
public:
  PackedTriangles(const std::vector<Eigen::MatrixXd>& matrices, const std::vector<bool>& symmetric) {
    for (std::size_t j = 0; j < matrices.size(); ++j) {
      if (symmetric[j]) packed_.push_back(pack(matrices[j]));
      place_.push_back(symmetric[j] ? std::ssize(packed_) - 1 : -1);
    }
  }
  bool holds(std::size_t j) const { return place_[j] >= 0; }

  static Eigen::VectorXd pack(const Eigen::MatrixXd& matrix) {
    const Eigen::Index r = matrix.rows();
    Eigen::VectorXd packed(r * (r + 1) / 2);
    for (Eigen::Index column = 0, at = 0; column < r; at += r - column, ++column)
      packed.segment(at, r - column) = matrix.col(column).tail(r - column);
    return packed;
  }
  static void unpack(const Eigen::VectorXd& packed, Eigen::MatrixXd& matrix) {
    const Eigen::Index r = matrix.rows();
    for (Eigen::Index column = 0, at = 0; column < r; at += r - column, ++column)
      matrix.col(column).tail(r - column) = packed.segment(at, r - column);
    matrix.triangularView<Eigen::StrictlyUpper>() = matrix.transpose();
  }

  /// sum += factors[k] * triangle of matrix terms[k], four at a time.
  void add(const std::vector<std::pair<std::size_t, double>>& terms, Eigen::VectorXd& sum) const {
    const auto of = [&](std::size_t k) -> const Eigen::VectorXd& { return packed_[place_[terms[k].first]]; };
    std::size_t k = 0;
    for (; k + 4 <= terms.size(); k += 4) {
      sum += terms[k].second * of(k) + terms[k + 1].second * of(k + 1) + terms[k + 2].second * of(k + 2) +
             terms[k + 3].second * of(k + 3);
    }
    for (; k < terms.size(); ++k) sum += terms[k].second * of(k);
  }

private:
  std::vector<Eigen::VectorXd> packed_;
  std::vector<int> place_;
};

bool is_symmetric(const Eigen::MatrixXd& matrix) { return matrix == matrix.transpose(); }

std::vector<bool> symmetric_terms(const ReducedSystem& system) {
  std::vector<bool> symmetric;
  for (const Eigen::MatrixXd& term : system.terms) symmetric.push_back(is_symmetric(term));
  return symmetric;
}

/// What a matrix has beside the mirror image of its lower triangle.
Eigen::MatrixXd beside_triangle(const Eigen::MatrixXd& matrix) {
  return matrix - Eigen::MatrixXd(matrix.selfadjointView<Eigen::Lower>());
}

}  // namespace

struct ReducedStepper::Work {
  const ReducedSystem& system;
  StepperOptions options;
  bool identity_capacity;

  Eigen::VectorXd p, q, heat;  ///< of the last step; heat = inputs * q
  Eigen::MatrixXd conduction;  ///< K0 + sum p K at conduction_p, brought to p where it is needed
  Eigen::VectorXd conduction_p;
  PackedTriangles triangles;
  Eigen::VectorXd constant_triangle, triangle;  ///< of K0 and of the sum's symmetric part
  Eigen::MatrixXd constant_flows, flows;        ///< what is not symmetric: coolant transport
  std::vector<std::pair<std::size_t, double>> changes;
  bool has_conduction = false, has_heat = false;
  int differences = 0;

  std::array<Factor, kept_factors> factors;
  long uses = 0, factorisations = 0;
  std::array<Passed, kept_factors> passed;
  std::size_t next_passed = 0;

  // Scratch, (r) each; directions of the refinement with their images.
  Eigen::MatrixXd shifted;
  Eigen::VectorXd start, stage, right_hand_side, residual, column;
  std::array<Eigen::VectorXd, max_refinements> direction, image;

  Work(const ReducedSystem& s, const StepperOptions& o)
      : system(s),
        options(o),
        identity_capacity(is_identity(s.capacity)),
        triangles(s.terms, symmetric_terms(s)),
        constant_triangle(PackedTriangles::pack(s.conduction)) {
    const Eigen::Index r = s.order();
    constant_flows = flows = beside_triangle(s.conduction);
    changes.reserve(s.terms.size());
    conduction.resize(r, r);
    shifted.resize(r, r);
    for (Eigen::VectorXd* v : {&heat, &start, &stage, &right_hand_side, &residual, &column}) v->setZero(r);
    for (int i = 0; i < max_refinements; ++i) direction[i] = image[i] = heat;
    p = conduction_p = Eigen::VectorXd::Zero(std::ssize(s.terms));
    q.setZero(s.inputs.cols());
    for (Factor& factor : factors) {
      factor.lu = Eigen::PartialPivLU<Eigen::MatrixXd>(r);
      factor.p = p;
    }
    for (Passed& state : passed) state.p = p;
  }

  void sum_conduction() {
    const Eigen::Index terms = p.size();
    Eigen::Index changed = 0;
    for (Eigen::Index j = 0; j < terms; ++j) changed += p(j) != conduction_p(j);
    if (has_conduction && changed == 0) return;
    const bool afresh = !has_conduction || 2 * changed > terms || ++differences > exact_sum_after;
    if (afresh) {
      triangle = constant_triangle;
      flows = constant_flows;
      differences = 0;
    }
    changes.clear();
    for (Eigen::Index j = 0; j < terms; ++j) {
      const double amount = afresh ? p(j) : p(j) - conduction_p(j);
      const std::size_t term = j;
      if (amount == 0.0) continue;
      if (triangles.holds(term)) {
        changes.emplace_back(term, amount);
      } else {
        flows += amount * system.terms[term];
      }
    }
    triangles.add(changes, triangle);
    PackedTriangles::unpack(triangle, conduction);
    conduction += flows;
    conduction_p = p;
    has_conduction = true;
  }

  void set_heat(const Eigen::VectorXd& next) {
    if (has_heat && next == q) return;
    q = next;
    heat.noalias() = system.inputs * q;
    has_heat = true;
  }

  void forget() {
    has_conduction = has_heat = false;
    for (Factor& factor : factors) factor.last_use = 0;
  }

  Factor* find_factor(double step) {
    for (Factor& factor : factors) {
      if (factor.last_use > 0 && factor.step == step && factor.p == p) return &factor;
    }
    return nullptr;
  }

  bool passed_before(double step) const {
    for (const Passed& state : passed) {
      if (state.step == step && state.p == p) return true;
    }
    return false;
  }

  void remember_passed(double step) {
    passed[next_passed].p = p;
    passed[next_passed].step = step;
    next_passed = (next_passed + 1) % passed.size();
  }

  Factor& latest() {
    Factor* newest = &factors[0];
    for (Factor& factor : factors) {
      if (factor.last_use > newest->last_use) newest = &factor;
    }
    return *newest;
  }

  Factor& make_factor(double scale, double step) {
    sum_conduction();
    Factor* oldest = &factors[0];
    for (Factor& factor : factors) {
      if (factor.last_use < oldest->last_use) oldest = &factor;
    }
    shifted = scale * conduction;
    if (identity_capacity) {
      shifted.diagonal().array() += 1.0;
    } else {
      shifted += system.capacity;
    }
    oldest->lu.compute(shifted);
    oldest->p = p;
    oldest->step = step;
    ++factorisations;
    return *oldest;
  }

  /// y = (E + scale A) x
  void apply(double scale, const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
    y.noalias() = scale * (conduction * x);
    if (identity_capacity) {
      y += x;
    } else {
      y.noalias() += system.capacity * x;
    }
  }

  /// y = E x
  void apply_capacity(const Eigen::VectorXd& x, Eigen::VectorXd& y) const {
    if (identity_capacity) {
      y = x;
    } else {
      y.noalias() = system.capacity * x;
    }
  }

  /// Generalised conjugate residuals with a factor of a neighbouring operator, from the guess in x.
  /// @return whether the tolerance was met
  bool refine(const Factor& factor, double scale, const Eigen::VectorXd& b, Eigen::VectorXd& x) {
    const double target = options.refresh_tolerance * b.norm();
    apply(scale, x, residual);
    residual = b - residual;
    for (std::size_t i = 0; i < max_refinements; ++i) {
      if (residual.norm() <= target) return true;
      direction[i].noalias() = factor.lu.solve(residual);
      apply(scale, direction[i], image[i]);
      for (std::size_t j = 0; j < i; ++j) {
        const double share = image[i].dot(image[j]);
        image[i] -= share * image[j];
        direction[i] -= share * direction[j];
      }
      const double length = image[i].norm();
      if (!(length > 0.0)) return false;
      image[i] /= length;
      direction[i] /= length;
      const double share = residual.dot(image[i]);
      x += share * direction[i];
      residual -= share * image[i];
    }
    return residual.norm() <= target;
  }

  /// Both stages by one factor; by refinement if it belongs to another operator.
  bool stages(const Factor& factor, bool exact, double step, Eigen::VectorXd& state) {
    if (!exact) sum_conduction();
    const double scale = solver::sdirk_gamma * step;
    const auto solve = [&](Eigen::VectorXd& x) {
      if (!exact) return refine(factor, scale, right_hand_side, x);
      x.noalias() = factor.lu.solve(right_hand_side);
      return true;
    };
    start = state;
    apply_capacity(start, right_hand_side);
    right_hand_side += scale * heat;
    stage = start;
    if (!solve(stage)) return false;
    // h k1 = (stage - start) / gamma, of which the second stage takes the share 1 - gamma.
    constexpr double share = (1.0 - solver::sdirk_gamma) / solver::sdirk_gamma;
    residual = start + share * (stage - start);
    apply_capacity(residual, right_hand_side);
    right_hand_side += scale * heat;
    if (!solve(stage)) return false;
    state = stage;
    return true;
  }
};

void StepperOptions::validate() const {
  core::require_option(refresh_tolerance >= 0.0 && refresh_tolerance < 1.0, "stepper refresh_tolerance",
                       refresh_tolerance, "0 to less than 1");
}

ReducedStepper::ReducedStepper(const ReducedSystem& system, const StepperOptions& options) {
  options.validate();
  work_ = std::make_unique<Work>(system, options);
}
ReducedStepper::~ReducedStepper() = default;
ReducedStepper::ReducedStepper(ReducedStepper&&) noexcept = default;

Eigen::Index ReducedStepper::size() const { return work_->system.order(); }
const solver::Layout& ReducedStepper::layout() const { return work_->system.layout; }

Eigen::VectorXd ReducedStepper::uniform(double temperature_K) const { return work_->system.one_kelvin * temperature_K; }

void ReducedStepper::advance(Eigen::VectorXd& state, const solver::Coefficients& c, double step_s) {
  Work& work = *work_;
  assert(state.size() == size() && step_s > 0.0);
  assert(c.p.size() == std::ssize(work.system.terms));
  assert(c.q.size() == work.system.inputs.cols());
  work.p = c.p;
  work.set_heat(c.q);

  Factor* factor = work.find_factor(step_s);
  bool done = false;
  if (factor) {
    done = work.stages(*factor, true, step_s, state);
  } else if (!work.passed_before(step_s)) {
    factor = &work.latest();
    done = factor->last_use > 0 && std::abs(step_s - factor->step) <= 0.2 * factor->step &&
           work.stages(*factor, false, step_s, state);
    if (done) work.remember_passed(step_s);
  }
  if (!done) {
    factor = &work.make_factor(solver::sdirk_gamma * step_s, step_s);
    work.stages(*factor, true, step_s, state);
  }
  factor->last_use = ++work.uses;
  if (!std::isfinite(state.sum())) {
    work.forget();  // a NaN in the coefficients would stay in everything that is kept
    throw core::SolverError(fmt::format(
        "reduced model: the state is no longer finite after a step of {} s; look for NaN in the inputs", step_s));
  }
}

void ReducedStepper::advance(Eigen::MatrixXd& state, const std::vector<solver::Coefficients>& c, double step_s) {
  assert(state.cols() == std::ssize(c));
  for (std::size_t load = 0; load < c.size(); ++load) {
    const Eigen::Index i = load;
    work_->column = state.col(i);
    advance(work_->column, c[load], step_s);
    state.col(i) = work_->column;
  }
}

Eigen::MatrixXd ReducedStepper::sensors(const Eigen::MatrixXd& state) const { return work_->system.sensors * state; }

const Eigen::MatrixXd& ReducedStepper::operator_matrix() const {
  work_->sum_conduction();
  return work_->conduction;
}
long ReducedStepper::factorisations() const { return work_->factorisations; }

}  // namespace thermotwin::reduction
