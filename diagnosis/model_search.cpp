// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/model_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "core/thread_pool.h"
#include "diagnosis/evidence.h"
#include "diagnosis/statistics.h"
#include "diagnosis/unknown_cause.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// A cause whose whole prior moves the white residual by less than this cannot be told from none.
constexpr double visible = 2.0;
constexpr std::size_t most_pair_partners = 60;

/// The fitted part, decorrelated.
struct White {
  Whitener whitener;
  MatrixXd columns;
  VectorXd residual;

  White(const Problem& problem, const std::vector<ChannelCovariance>& covariance)
      : whitener(covariance),
        columns(whitener.whiten(problem.fitted(problem.columns))),
        residual(whitener.whiten(problem.fitted(problem.measured - problem.predicted))) {}
};

/// A time constant or a late clock far from nominal, where the tangent at nominal says nothing of it.
struct Scanned {
  int parameter = -1;
  double value = 0;
  VectorXd column, residual;  ///< whitened: tangent there, residual of the linear form
};

constexpr int scan_points = 24;
constexpr double scan_widths = 3.0;      ///< of the prior, either way
constexpr double scan_gains = 4.0;       ///< chi-square below that at nominal that is worth a closer look
constexpr std::size_t most_scanned = 4;

std::vector<Scanned> scan_readings(const Problem& problem, const Response& response, const mesh::Machine& machine, const White& white,
                                   const std::vector<int>& candidates) {
  std::vector<int> curved;
  for (const int i : candidates) {
    const std::string& kind = problem.parameters[static_cast<std::size_t>(i)].kind;
    if (kind == "sensor_lag" || kind == "clock_shift") curved.push_back(i);
  }
  if (curved.empty()) return {};
  const MatrixXd states = response.states(machine);
  // Nuisances take what they can, whatever the reading.
  const MatrixXd scaled = white.columns * problem.prior_std.asDiagonal();
  MatrixXd precision = MatrixXd::Identity(scaled.cols(), scaled.cols());
  precision.selfadjointView<Eigen::Lower>().rankUpdate(scaled.transpose());
  const Eigen::LLT<MatrixXd> factor(precision);
  const auto chi_square = [&](const VectorXd& residual) {
    const VectorXd b = scaled.transpose() * residual;
    return residual.squaredNorm() - b.dot(factor.solve(b));
  };
  const double nominal = chi_square(white.residual);
  const auto residual_at = [&](const Parameter& p, double value) {
    return VectorXd(white.whitener.whiten(problem.fitted(problem.measured - response.read(with_parameter(machine, p, value), states))));
  };
  std::vector<std::pair<double, Scanned>> found(curved.size());
  core::parallel_for(0, curved.size(), [&](std::size_t c) {
    const Parameter& p = problem.parameters[static_cast<std::size_t>(curved[c])];
    const double low = std::max(p.low, p.nominal - scan_widths * p.cause_std), high = std::min(p.high, p.nominal + scan_widths * p.cause_std);
    double best = nominal, at = p.nominal;
    for (int k = 0; k <= scan_points; ++k) {
      const double value = low + (high - low) * k / scan_points;
      const double chi = chi_square(residual_at(p, value)) + std::pow((value - p.nominal) / p.cause_std, 2);
      if (chi < best) best = chi, at = value;
    }
    found[c].first = nominal - best;
    found[c].second.parameter = curved[c];
    found[c].second.value = at;
  });
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Scanned> kept;
  for (auto& [gain, scanned] : found) {
    if (gain < scan_gains || kept.size() >= most_scanned) break;
    const Parameter& p = problem.parameters[static_cast<std::size_t>(scanned.parameter)];
    const double above = std::min(scanned.value + p.step, p.high), below = std::max(scanned.value - p.step, p.low);
    scanned.column = (residual_at(p, below) - residual_at(p, above)) / (above - below);
    scanned.residual = residual_at(p, scanned.value) + scanned.column * (scanned.value - p.nominal);
    kept.push_back(std::move(scanned));
  }
  return kept;
}

double log_sum(const std::vector<double>& logs) {
  const double top = *std::max_element(logs.begin(), logs.end());
  double sum = 0.0;
  for (const double value : logs) sum += std::exp(value - top);
  return top + std::log(sum);
}

/// In what a cause is never quite as its hypothesis says: its size wanders (its effect times hat functions of
/// time, the same for all channels), and heat enters elsewhere.
struct Freedom {
  MatrixXd columns;   ///< (observations x (members x knots + members that add heat))
  VectorXd std;
};
constexpr double wandering_share = 0.12;  ///< of a cause's size
constexpr double wandering_knot_s = 3.0 * 3600.0;
constexpr int most_wandering_knots = 12;
constexpr double spread_share = 0.5;      ///< of its heat enters spread, either way

/// @param sensitivity, spread  (observations x members)   @param size  (members) estimate less nominal value
Freedom freedom(const Problem& problem, const MatrixXd& sensitivity, const MatrixXd& spread, const VectorXd& size) {
  const Observations& obs = problem.observations;
  const int spans = std::clamp(static_cast<int>(std::lround((obs.end - obs.start) / wandering_knot_s)), 1, most_wandering_knots);
  const double width = (obs.end - obs.start) / spans;
  VectorXd time(obs.size());
  for (std::size_t k = 0; k < obs.channels.size(); ++k) time.segment(problem.first_row(k), obs.channels[k].size()) = obs.channels[k].time;
  Freedom result;
  result.columns.resize(obs.size(), sensitivity.cols() * (spans + 2));
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
  VectorXd seen(static_cast<Index>(channels.size()));
  for (std::size_t k = 0; k < channels.size(); ++k)
    seen[static_cast<Index>(k)] = root_mean_square((problem.measured - predicted).segment(problem.first_row(k), channels[k].fitted));
  return seen;
}

/// Beside a cause: something that wanders by a share of what was seen without it.
UnknownEvidence leftover_evidence(const Problem& problem, const Hypothesis& h) {
  VectorXd prior_std = problem.prior_std, predicted = h.predicted;
  MatrixXd columns = problem.columns;
  for (std::size_t k = 0; k < h.members.size(); ++k) {
    const auto column = static_cast<Index>(k);
    prior_std[h.members[k]] = problem.parameters[static_cast<std::size_t>(h.members[k])].cause_std;
    columns.col(h.members[k]) = h.sensitivity.col(column);
    predicted -= h.sensitivity.col(column) * (h.value[column] - problem.nominal[h.members[k]]);
  }
  VectorXd size = h.value;
  for (std::size_t k = 0; k < h.members.size(); ++k) size[static_cast<Index>(k)] -= problem.nominal[h.members[k]];
  const Freedom free = freedom(problem, h.sensitivity, h.spread, size);
  return unknown_evidence(problem, joined(columns, free.columns), joined(prior_std, free.std), problem.measured - predicted, seen_in(problem, problem.predicted), {0.3, 0.6, 1.2});
}

double normal_mass(double mean, double std, double low, double high) {
  const auto below = [&](double x) { return 0.5 * std::erfc((mean - x) / (std * std::numbers::sqrt2)); };
  return below(high) - below(low);
}

/// What bounds do to the evidence of a Gaussian: mass that the posterior has within them over that of
/// the prior. A time constant or a power that would have to be negative explains nothing.
double log_within_bounds(const Parameter& p, double value, double std) {
  constexpr double least = 1e-12;
  const double width = std::max(std, 1e-6 * p.cause_std);
  return std::log(std::max(normal_mass(value, width, p.low, p.high), least)) -
         std::log(std::max(normal_mass(p.nominal, p.cause_std, p.low, p.high), least));
}

/// Each kind counts the same, and each place of a kind. (candidates) adds up to 1
std::vector<double> prior_shares(const Problem& problem, const std::vector<int>& candidates) {
  std::map<std::string, int> places;
  for (const int i : candidates) ++places[problem.parameters[static_cast<std::size_t>(i)].kind];
  std::vector<double> shares;
  for (const int i : candidates) {
    const Parameter& p = problem.parameters[static_cast<std::size_t>(i)];
    shares.push_back((p.prior_share > 0.0 ? p.prior_share : 1.0 / places[p.kind]) / static_cast<double>(places.size()));
  }
  return shares;
}

/// All hypotheses on the nominal linearisation.
std::vector<Hypothesis> enumerate(const Problem& problem, const White& white, const LinearEvidence& nominal,
                                  const std::vector<int>& candidates, const std::vector<Scanned>& scanned, const SearchOptions& options) {
  // Linear forms about what the scan found, at nominal priors.
  std::map<int, LinearEvidence> elsewhere;
  for (const Scanned& s : scanned) {
    MatrixXd columns = white.columns;
    columns.col(s.parameter) = s.column;
    elsewhere.emplace(s.parameter, LinearEvidence(columns, s.residual, problem.prior_std));
  }
  const auto make = [&](std::vector<int> members, double prior) {
    Hypothesis h;
    std::vector<double> wide;
    const LinearEvidence* at = &nominal;
    for (const int i : members) {
      wide.push_back(problem.parameters[static_cast<std::size_t>(i)].cause_std);
      if (const auto found = elsewhere.find(i); found != elsewhere.end() && at == &nominal) at = &found->second;
    }
    LinearEvidence::Widened widened = at->widen(members, wide);
    h.log_prior = std::log(prior);
    h.log_evidence = widened.log_ratio + at->log_evidence() - nominal.log_evidence();
    h.value = widened.mean;
    h.std = widened.std;
    for (std::size_t k = 0; k < members.size(); ++k) {
      const auto place = static_cast<Index>(k);
      const Parameter& p = problem.parameters[static_cast<std::size_t>(members[k])];
      h.value[place] += p.nominal;
      h.log_evidence += log_within_bounds(p, h.value[place], h.std[place]);
      h.value[place] = std::clamp(h.value[place], p.low, p.high);
    }
    h.log_evidence *= options.evidence_share;
    h.members = std::move(members);
    return h;
  };
  std::vector<Hypothesis> all(1);
  all[0].log_prior = std::log(options.prior_none);
  const std::vector<double> share = prior_shares(problem, candidates);
  for (std::size_t i = 0; i < candidates.size(); ++i) all.push_back(make({candidates[i]}, options.prior_single * share[i]));
  // Pairs need a member that is among the better single causes.
  std::vector<std::size_t> order(candidates.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return all[a + 1].log_evidence > all[b + 1].log_evidence;
  });
  double squares = 0.0;
  for (const double s : share) squares += s * s;
  const double pairs = std::max(0.5 * (1.0 - squares), 1e-12);  // sum of the products of all pairs
  for (std::size_t a = 0; a < std::min(order.size(), most_pair_partners); ++a)
    for (std::size_t b = a + 1; b < order.size(); ++b)
      all.push_back(make({candidates[order[a]], candidates[order[b]]}, options.prior_pair * share[order[a]] * share[order[b]] / pairs));
  return all;
}

void sort_by_posterior(std::vector<Hypothesis>& all) {
  std::stable_sort(all.begin(), all.end(), [](const Hypothesis& a, const Hypothesis& b) {
    return a.log_prior + a.log_evidence > b.log_prior + b.log_evidence;
  });
}

/// Gauss-Newton about the hypothesis' own estimate; its evidence by Laplace at the end.
void refine(Hypothesis& h, const Problem& problem, const Response& response, const mesh::Machine& machine,
            const White& white, double log_nominal, const SearchOptions& options) {
  const auto count = static_cast<Index>(h.members.size());
  std::vector<Parameter> parameters;
  VectorXd nominal(count), prior_std = problem.prior_std;
  for (Index k = 0; k < count; ++k) {
    const int i = h.members[static_cast<std::size_t>(k)];
    parameters.push_back(problem.parameters[static_cast<std::size_t>(i)]);
    nominal[k] = parameters.back().nominal;
    prior_std[i] = parameters.back().cause_std;
  }
  const auto inside = [&](VectorXd value) {
    for (Index k = 0; k < count; ++k) {
      const Parameter& p = parameters[static_cast<std::size_t>(k)];
      value[k] = std::clamp(value[k], p.low + (p.ratio ? 0.02 : 0.0), p.high);
    }
    return value;
  };
  VectorXd at = inside(h.value);
  MatrixXd columns = white.columns;
  // Clocks and time constants are far from linear.
  const bool reads = std::any_of(parameters.begin(), parameters.end(), [](const Parameter& p) { return acts_on_readings(p.kind); });
  for (int iteration = 0; iteration < (reads ? 3 : 1) * options.iterations; ++iteration) {
    const Response::Linear linear = response.linearise(machine, parameters, at, false, {}, true);
    const MatrixXd sensitivity = white.whitener.whiten(problem.fitted(linear.sensitivity));
    for (Index k = 0; k < count; ++k)
      columns.col(h.members[static_cast<std::size_t>(k)]) = sensitivity.col(k);
    const VectorXd residual = white.whitener.whiten(
        problem.fitted(problem.measured - linear.predicted + linear.sensitivity * (at - nominal)));
    const Freedom free = freedom(problem, linear.sensitivity, linear.spread, at - nominal);
    const LinearEvidence evidence(joined(columns, white.whitener.whiten(problem.fitted(free.columns))), residual, joined(prior_std, free.std));
    VectorXd next(count);
    h.std.resize(count);
    for (Index k = 0; k < count; ++k) {
      const int i = h.members[static_cast<std::size_t>(k)];
      next[k] = nominal[k] + evidence.mean()[i];
      h.std[k] = std::sqrt(std::max(0.0, evidence.covariance()(i, i)));
    }
    h.chi_square = evidence.chi_square();
    double bounds = 0.0;
    for (Index k = 0; k < count; ++k) bounds += log_within_bounds(parameters[static_cast<std::size_t>(k)], next[k], h.std[k]);
    next = inside(next);
    h.log_evidence = options.evidence_share * (evidence.log_evidence() - log_nominal + bounds);
    h.value = next;
    const bool settled = ((next - at).cwiseAbs().array() < 0.05 * h.std.array() + 1e-6).all();
    at = next;
    if (settled) break;
  }
  const Response::Linear there = response.linearise(machine, parameters, h.value, false, {}, true);
  h.predicted = there.predicted;
  h.sensitivity = there.sensitivity;
  h.spread = there.spread;
  h.refined = true;
}

}  // namespace

const Hypothesis* SearchResult::single(int parameter) const {
  for (const Hypothesis& h : hypotheses)
    if (h.members.size() == 1 && h.members[0] == parameter) return &h;
  return nullptr;
}

SearchResult search(const Problem& problem, const Response& response, const mesh::Machine& machine,
                    const SearchOptions& options) {
  SearchResult result;
  const White white(problem, problem.fitted_covariance());
  const LinearEvidence nominal(white.columns, white.residual, problem.prior_std);
  result.chi_square_none = nominal.chi_square();
  result.fitted = white.residual.size();
  std::vector<int> candidates;
  for (int i = 0; i < static_cast<int>(problem.parameters.size()); ++i) {
    const double seen =
        white.columns.col(i).norm() * problem.parameters[static_cast<std::size_t>(i)].cause_std;
    (seen > visible ? candidates : result.invisible).push_back(i);
  }
  std::vector<Hypothesis>& all = result.hypotheses;
  all = enumerate(problem, white, nominal, candidates, scan_readings(problem, response, machine, white, candidates), options);
  sort_by_posterior(all);

  const double log_nominal = nominal.log_evidence();
  const auto refine_leading = [&](std::size_t members, int most) {
    std::vector<Hypothesis*> leading;
    for (Hypothesis& h : all)
      if (h.members.size() == members && static_cast<int>(leading.size()) < most) leading.push_back(&h);
    core::parallel_for(0, leading.size(), [&](std::size_t i) { refine(*leading[i], problem, response, machine, white, log_nominal, options); });
  };
  std::map<int, double> linear_form;  // log evidence of single causes before they are looked at closely
  for (const Hypothesis& h : all)
    if (h.members.size() == 1) linear_form[h.members[0]] = h.log_evidence;
  refine_leading(1, options.refined_singles);
  // What a cause gains or loses at a closer look, its pairs do as well.
  std::map<int, double> change;
  for (const Hypothesis& h : all)
    if (h.members.size() == 1 && h.refined) change[h.members[0]] = h.log_evidence - linear_form[h.members[0]];
  for (Hypothesis& h : all)
    if (h.members.size() == 2)
      if (const auto found = change.find(linear_form[h.members[0]] >= linear_form[h.members[1]] ? h.members[0] : h.members[1]); found != change.end())
        h.log_evidence += found->second;
  sort_by_posterior(all);
  refine_leading(2, options.refined_pairs);
  sort_by_posterior(all);

  const UnknownEvidence alone = unknown_evidence(problem, problem.columns, problem.prior_std, problem.measured - problem.predicted,
                                                 problem.amplitude, {0.1, 0.3, 1.0, 3.0});
  result.log_evidence_unknown = options.evidence_share * (alone.with - alone.without);
  result.unknown_channel = alone.channel;
  // Whether the best single cause and the best pair leave what they do not describe.
  std::vector<std::pair<const Hypothesis*, double>> leftovers;
  for (const std::size_t members : {1, 2})
    for (const Hypothesis& h : all)
      if (h.members.size() == members && h.refined) {
        const double log = leftover_evidence(problem, h).with - alone.without;
        leftovers.emplace_back(&h, std::log(options.prior_leftover) + h.log_prior + options.evidence_share * log);
        break;
      }
  std::vector<double> logs = {std::log(options.prior_unknown) + result.log_evidence_unknown};
  for (const Hypothesis& h : all) logs.push_back(h.log_prior + h.log_evidence);
  for (const auto& [h, log] : leftovers) logs.push_back(log);
  const double normal = log_sum(logs);
  result.probability_unknown = std::exp(logs[0] - normal);
  result.marginal = VectorXd::Zero(static_cast<Index>(problem.parameters.size()));
  for (const auto& [h, log] : leftovers) {
    const double probability = std::exp(log - normal);
    result.probability_leftover += probability;
    for (const int i : h->members) result.marginal[i] += probability;
  }
  result.probability_unknown += result.probability_leftover;
  for (Hypothesis& h : all) {
    h.probability = std::exp(h.log_prior + h.log_evidence - normal);
    if (h.members.empty()) result.probability_none = h.probability;
    for (const int i : h.members) result.marginal[i] += h.probability;
  }
  result.marginal = result.marginal.cwiseMin(1.0);  // sums of many small numbers round
  return result;
}

VectorXd white_residual(const Problem& problem, const Hypothesis& hypothesis) {
  const Whitener whitener(problem.fitted_covariance());
  const VectorXd& predicted = hypothesis.refined ? hypothesis.predicted : problem.predicted;
  VectorXd prior_std = problem.prior_std;
  // The cause stands at its estimate; what is left of it is within the estimate's uncertainty.
  for (std::size_t k = 0; k < hypothesis.members.size() && hypothesis.refined; ++k)
    prior_std[hypothesis.members[k]] = std::max(hypothesis.std[static_cast<Index>(k)], 1e-9);
  const MatrixXd columns = whitener.whiten(problem.fitted(problem.columns));
  const VectorXd residual = whitener.whiten(problem.fitted(problem.measured - predicted));
  return residual - columns * LinearEvidence(columns, residual, prior_std).mean();
}

}  // namespace thermotwin::diagnosis
