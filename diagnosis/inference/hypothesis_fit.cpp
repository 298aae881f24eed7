// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/inference/hypothesis_fit.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "core/units.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/inference/evidence.h"
#include "diagnosis/inference/unknown_cause.h"
#include "diagnosis/statistics/statistics.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// In what a cause is never quite as its hypothesis says: its size wanders (its effect times hat functions of
/// time, the same for all channels), heat enters spread, a sensor lags by two elements in a row instead of one, and
/// where its place is not known, elsewhere.
struct Freedom {
  MatrixXd columns;  ///< (observations x freedoms)
  VectorXd std;
};
constexpr double wandering_share = 0.12;  ///< of a cause's size
constexpr double wandering_knot_s = 3.0 * core::units::hour;
constexpr int most_wandering_knots = 12;
constexpr double spread_share = 0.5;  ///< of its heat enters spread, either way
constexpr double delay_of_two =
    0.5;  ///< two equal elements are about one of 0.7 of both and a delay of 0.3; with spread_share, a quarter
/// @param sensitivity, spread  (observations x members)   @param size  (members) estimate less nominal value
Freedom freedom(const Problem& problem, const std::vector<int>& members, const MatrixXd& sensitivity,
                const MatrixXd& spread, const VectorXd& size) {
  const Observations& obs = problem.observations;
  const long most = most_wandering_knots * std::ssize(obs.each());
  const int spans = std::clamp<long>(std::lround((obs.end - obs.start) / wandering_knot_s), 1, most);
  const double width = (obs.end - obs.start) / spans;
  VectorXd time(obs.size());
  for (std::size_t k = 0; k < obs.channels.size(); ++k)
    time.segment(problem.first_row(k), obs.channels[k].size()) = obs.channels[k].time;
  Freedom result;
  Index places = 0;
  for (const int i : members) {
    if (const auto found = problem.place_freedom.find(i); found != problem.place_freedom.end())
      places += found->second.cols();
  }
  result.columns.resize(obs.size(), sensitivity.cols() * (spans + 2) + places);
  result.std.resize(result.columns.cols());
  Index column = 0;
  const auto add = [&](VectorXd values, double share, Index member) {
    result.columns.col(column) = std::move(values);
    result.std[column++] = std::max(share * std::abs(size[member]), 1e-12);
  };
  for (Index m = 0; m < sensitivity.cols(); ++m) {
    for (int knot = 0; knot <= spans; ++knot) {
      const Eigen::ArrayXd hat = (1.0 - ((time.array() - obs.start) / width - knot).abs()).max(0.0);
      add((sensitivity.col(m).array() * hat).matrix(), wandering_share, m);
    }
    add(spread.col(m), spread_share, m);
    if (const auto found = problem.place_freedom.find(members[m]); found != problem.place_freedom.end())
      for (Index k = 0; k < found->second.cols(); ++k) add(found->second.col(k), 1.0, m);
  }
  return result;
}

VectorXd joined(const VectorXd& a, const VectorXd& b) {
  VectorXd both(a.size() + b.size());
  both << a, b;
  return both;
}

MatrixXd joined(const MatrixXd& a, const MatrixXd& b) {
  MatrixXd both(a.rows(), a.cols() + b.cols());
  both << a, b;
  return both;
}

/// How far the fitted part of each channel is from a prediction, RMS. (channels)
VectorXd seen_in(const Problem& problem, const VectorXd& predicted) {
  const auto& channels = problem.observations.channels;
  const VectorXd residual = problem.decorrelated(problem.measured - predicted);
  VectorXd seen(std::ssize(channels));
  for (std::size_t k = 0; k < channels.size(); ++k)
    seen[k] = root_mean_square(residual.segment(problem.first_row(k), channels[k].fitted));
  return seen;
}

double normal_mass(double mean, double std, double low, double high) {
  const auto below = [&](double x) { return 0.5 * std::erfc((mean - x) / (std * std::numbers::sqrt2)); };
  return below(high) - below(low);
}

/// The clock of a channel that lags; -1: not among the parameters.
int clock_of(const Problem& problem, int lag) {
  const Parameter& p = problem.parameters[lag];
  for (int i = 0; p.kind == Kind::sensor_lag && i < std::ssize(problem.parameters); ++i)
    if (problem.parameters[i].kind == Kind::clock_shift && problem.parameters[i].where == p.where) return i;
  return -1;
}

/// With members at values, all others where the problem is linearised but told at nominal. A lag's spread is a delay
/// instead of a part of it.
Response::Linear linear_at(const Problem& problem, const Response& response, const mesh::Machine& machine,
                           const std::vector<int>& members, const VectorXd& values) {
  std::vector<int> all = members;
  std::vector<Index> delayed;
  for (std::size_t k = 0; k < members.size(); ++k) {
    if (const int clock = clock_of(problem, members[k]);
        clock >= 0 && std::find(members.begin(), members.end(), clock) == members.end()) {
      all.push_back(clock);
      delayed.push_back(k);
    }
  }
  std::vector<Parameter> parameters;
  for (const int i : all) parameters.push_back(problem.parameters[i]);
  const auto count = std::ssize(members), clocks = std::ssize(delayed);
  Response::Linear linear = response.linearise(problem.machine_around(machine, members), parameters,
                                               joined(values, VectorXd::Zero(clocks)), false, {}, true);
  for (Index k = 0; k < clocks; ++k) {
    const Index lag = delayed[k];
    linear.spread.col(lag) = delay_of_two * (linear.sensitivity.col(count + k) - linear.sensitivity.col(lag));
  }
  linear.sensitivity.conservativeResize(Eigen::NoChange, count);
  linear.spread.conservativeResize(Eigen::NoChange, count);
  linear.predicted -= problem.moved_around(members);
  return linear;
}

}  // namespace

White::White(const Problem& problem, bool whole_record)
    : whole(whole_record),
      whitener(whole_record ? problem.covariance : problem.fitted_covariance()),
      columns(of(problem, problem.columns)),
      residual(of(problem, problem.measured - problem.predicted)) {}

LinearForm nominal_form(const Problem& problem, const White& white) {
  return {white.columns, white.residual, problem.prior_std, {}, {}, problem.moved_around({})};
}

LinearForm form_about(const Problem& problem, const White& white, const Hypothesis& h) {
  const auto count = std::ssize(h.members);
  LinearForm form;
  const VectorXd size = h.value - problem.nominal(h.members);
  form.members = h.members;
  form.value = h.value;
  form.shift = h.sensitivity * size + problem.moved_around(h.members);
  const Freedom free = freedom(problem, h.members, h.sensitivity, h.spread, size);
  const MatrixXd free_columns = white.of(problem, free.columns), own = white.of(problem, h.sensitivity);
  form.columns = joined(white.columns, free_columns);
  for (Index k = 0; k < count; ++k) form.columns.col(h.members[k]) = own.col(k);
  form.prior_std = joined(problem.prior_std, free.std);
  form.residual = white.of(problem, problem.measured - h.predicted + h.sensitivity * size);
  return form;
}

LinearForm form_beside(const Problem& problem, const Response& response, const mesh::Machine& machine,
                       const White& white, const Hypothesis& h) {
  LinearForm form = form_about(problem, white, h);
  const auto count = std::ssize(problem.parameters);
  VectorXd at = problem.nominal.head(count);
  at.head(problem.around.size()) += problem.around;
  VectorXd off = VectorXd::Zero(count);
  off.head(problem.around.size()) = problem.around;
  for (std::size_t k = 0; k < h.members.size(); ++k) {
    at[h.members[k]] = h.value[k];
    off[h.members[k]] = h.value[k] - problem.nominal[h.members[k]];
  }
  const Response::Linear there = response.linearise(machine, problem.parameters, at, false);
  form.columns.leftCols(count) = white.of(problem, there.sensitivity);
  form.shift = there.sensitivity * off;
  form.residual = white.of(problem, problem.measured - there.predicted + form.shift);
  return form;
}

double log_within_bounds(const Parameter& p, double value, double std) {
  constexpr double least = 1e-12;
  const double width = std::max(std, 1e-6 * p.cause_std);
  return std::log(std::max(normal_mass(value, width, p.low, p.high), least)) -
         std::log(std::max(normal_mass(p.nominal, p.cause_std, p.low, p.high), least));
}

void refine(Hypothesis& h, const Problem& problem, const Response& response, const mesh::Machine& machine,
            const White& white, double log_nominal, int iterations, double evidence_share) {
  const auto count = std::ssize(h.members);
  std::vector<Parameter> parameters;
  VectorXd nominal(count), prior_std = problem.prior_std;
  for (Index k = 0; k < count; ++k) {
    const int i = h.members[k];
    parameters.push_back(problem.parameters[i]);
    nominal[k] = parameters.back().nominal;
  }
  const auto inside = [&](VectorXd value) {
    for (Index k = 0; k < count; ++k) {
      const Parameter& p = parameters[k];
      value[k] = std::clamp(value[k], p.low + (p.ratio ? 0.02 : 0.0), p.high);
    }
    return value;
  };
  VectorXd at = inside(h.value);
  MatrixXd columns = white.columns;
  // Clocks and time constants are far from linear.
  const bool reads =
      std::any_of(parameters.begin(), parameters.end(), [](const Parameter& p) { return acts_on_readings(p.kind); });
  for (int iteration = 0; iteration < (reads ? 3 : 1) * iterations; ++iteration) {
    const Response::Linear linear = linear_at(problem, response, machine, h.members, at);
    const MatrixXd sensitivity = white.of(problem, linear.sensitivity);
    for (Index k = 0; k < count; ++k) {
      columns.col(h.members[k]) = sensitivity.col(k);
      prior_std[h.members[k]] = cause_std_at(parameters[k], at[k]);
    }
    const VectorXd residual =
        white.of(problem, problem.measured - linear.predicted + linear.sensitivity * (at - nominal));
    const Freedom free = freedom(problem, h.members, linear.sensitivity, linear.spread, at - nominal);
    const LinearEvidence evidence(joined(columns, white.of(problem, free.columns)), residual,
                                  joined(prior_std, free.std));
    VectorXd next(count);
    h.std.resize(count);
    for (Index k = 0; k < count; ++k) {
      const int i = h.members[k];
      next[k] = nominal[k] + evidence.mean()[i];
      h.std[k] = std::sqrt(std::max(0.0, evidence.covariance()(i, i)));
    }
    h.chi_square = evidence.chi_square();
    double bounds = 0.0;
    for (Index k = 0; k < count; ++k) bounds += log_within_bounds(parameters[k], next[k], h.std[k]);
    next = inside(next);
    h.log_evidence = evidence_share * (evidence.log_evidence() - log_nominal + bounds);
    h.value = next;
    const bool settled = ((next - at).cwiseAbs().array() < 0.05 * h.std.array() + 1e-6).all();
    at = next;
    if (settled) break;
  }
  linearise(h, problem, response, machine);
}

void linearise(Hypothesis& h, const Problem& problem, const Response& response, const mesh::Machine& machine) {
  Response::Linear there = linear_at(problem, response, machine, h.members, h.value);
  h.predicted = std::move(there.predicted);
  h.sensitivity = std::move(there.sensitivity);
  h.spread = std::move(there.spread);
  h.refined = true;
}

Strain strain_of(const Problem& problem, const Hypothesis& h) {
  const auto evidence = [&](const White& white, LinearForm& form) {
    form = form_about(problem, white, h);
    for (std::size_t k = 0; k < h.members.size(); ++k)
      form.prior_std[h.members[k]] = cause_std_at(problem.parameters[h.members[k]], h.value[k]);
    return LinearEvidence(form.columns, form.residual, form.prior_std);
  };
  LinearForm form;
  const double fitted = evidence(White(problem), form).chi_square();
  const LinearEvidence whole = evidence(White(problem, true), form);
  Strain strain;
  const Index heldout = problem.measured.size() - problem.fitted(problem.measured).size();
  strain.heldout_chi_square = (whole.chi_square() - fitted) / std::max<Index>(heldout, 1);
  strain.heldout_misfit = 0.5 * std::max(0.0, whole.chi_square() - fitted - 1.0 * heldout);
  const VectorXd off = whole.mean().cwiseQuotient(form.prior_std).cwiseAbs();
  strain.freedom = off.tail(off.size() - problem.columns.cols()).maxCoeff();
  for (Index i = 0; i < problem.around.size(); ++i) {
    if (std::find(h.members.begin(), h.members.end(), i) == h.members.end() && off[i] > strain.other) {
      strain.other = off[i];
      strain.which = i;
    }
  }
  return strain;
}

UnknownEvidence evidence_beside_unknown(const Problem& problem, const Hypothesis& h) {
  const VectorXd size = h.value - problem.nominal(h.members), predicted = h.predicted - h.sensitivity * size;
  VectorXd prior_std = problem.prior_std;
  MatrixXd columns = problem.columns;
  for (std::size_t k = 0; k < h.members.size(); ++k) {
    prior_std[h.members[k]] = cause_std_at(problem.parameters[h.members[k]], h.value[k]);
    columns.col(h.members[k]) = h.sensitivity.col(k);
  }
  const Freedom free = freedom(problem, h.members, h.sensitivity, h.spread, size);
  return unknown_evidence(problem, joined(columns, free.columns), joined(prior_std, free.std),
                          problem.measured - predicted, seen_in(problem, problem.predicted), {0.3, 0.6, 1.2});
}

VectorXd white_residual(const Problem& problem, const Hypothesis& hypothesis) {
  const Whitener whitener(problem.fitted_covariance());
  const VectorXd& predicted = hypothesis.refined ? hypothesis.predicted : problem.predicted;
  VectorXd prior_std = problem.prior_std;
  // The cause stands at its estimate; what is left of it is within the estimate's uncertainty.
  for (std::size_t k = 0; k < hypothesis.members.size() && hypothesis.refined; ++k)
    prior_std[hypothesis.members[k]] = std::max(hypothesis.std[k], 1e-9);
  const MatrixXd columns = whitener.whiten(problem.fitted(problem.columns));
  const VectorXd residual = whitener.whiten(problem.fitted(problem.measured - predicted));
  return residual - columns * LinearEvidence(columns, residual, prior_std).mean();
}

}  // namespace thermotwin::diagnosis
