// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/inference/model_search.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/thread_pool.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/inference/evidence.h"
#include "diagnosis/inference/hypothesis_fit.h"
#include "diagnosis/inference/lag_scan.h"
#include "diagnosis/inference/unknown_cause.h"
#include "diagnosis/record/diagnose_options.h"
#include "diagnosis/statistics/statistics.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// A cause whose whole prior moves the white residual by less than this cannot be told from none.
constexpr double visible = 2.0;
constexpr std::size_t most_pair_partners = 60;
constexpr double likely_enough = 0.1;  ///< none, that it may be the verdict
constexpr double worth_looking_beside =
    10.0;  ///< ln Bayes factor of the leading cause above which all others are linearised anew beside it

/// Each kind counts the same, and each place of a kind. (candidates) adds up to 1
std::vector<double> prior_shares(const Problem& problem, const std::vector<int>& candidates) {
  std::map<Kind, int> places;
  for (const int i : candidates) ++places[problem.parameters[i].kind];
  std::vector<double> shares;
  for (const int i : candidates) {
    const Parameter& p = problem.parameters[i];
    shares.push_back((p.prior_share > 0.0 ? p.prior_share : 1.0 / places[p.kind]) / places.size());
  }
  return shares;
}

/// A linear form with its evidence, and the readings that were looked for beside its members.
class Evidence {
public:
  Evidence(const LinearForm& form, double log_none, double share, const std::vector<ScannedReading>& scanned = {})
      : evidence_(form.columns, form.residual, form.prior_std),
        log_none_(log_none),
        share_(share) {
    MatrixXd columns = form.columns;
    for (const ScannedReading& s : scanned) {
      const VectorXd kept = columns.col(s.parameter);
      columns.col(s.parameter) = s.column;
      elsewhere_.emplace(s.parameter, LinearEvidence(columns, s.residual, form.prior_std));
      columns.col(s.parameter) = kept;
    }
  }

  Hypothesis of(const Problem& problem, std::vector<int> members, double prior) const {
    Hypothesis h;
    std::vector<double> wide;
    const LinearEvidence* at = &evidence_;
    for (const int i : members) {
      wide.push_back(problem.parameters[i].cause_std);
      if (const auto found = elsewhere_.find(i); found != elsewhere_.end() && at == &evidence_) at = &found->second;
    }
    const LinearEvidence::Widened widened = at->widen(members, wide);
    h.log_prior = std::log(prior);
    h.log_evidence = widened.log_ratio + at->log_evidence() - log_none_;
    h.value = widened.mean;
    h.std = widened.std;
    for (std::size_t k = 0; k < members.size(); ++k) {
      const Index place = k;
      const Parameter& p = problem.parameters[members[k]];
      h.value[place] += p.nominal;
      h.log_evidence += log_within_bounds(p, h.value[place], h.std[place]);
      h.value[place] = std::clamp(h.value[place], p.low, p.high);
    }
    h.log_evidence *= share_;
    h.members = std::move(members);
    return h;
  }

private:
  LinearEvidence evidence_;
  std::map<int, LinearEvidence> elsewhere_;  ///< about what the scan found
  double log_none_, share_;
};

void sort_by_posterior(std::vector<Hypothesis>& all) {
  std::stable_sort(all.begin(), all.end(), [](const Hypothesis& a, const Hypothesis& b) {
    return a.log_prior + a.log_evidence > b.log_prior + b.log_evidence;
  });
}

/// Every pair of which one member is among the better single causes. Where that one was fitted, on the linear form
/// about it.
std::vector<Hypothesis> grow_pairs(const Problem& problem, const Response& response, const mesh::Machine& machine,
                                   const White& white, const Evidence& nominal, double log_none,
                                   const std::vector<int>& candidates, const std::vector<double>& share,
                                   const std::vector<Hypothesis>& singles, const SearchOptions& options) {
  double squares = 0.0;
  std::map<int, double> share_of;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    squares += share[i] * share[i];
    share_of[candidates[i]] = share[i];
  }
  const double all_pairs = std::max(0.5 * (1.0 - squares), 1e-12);  // sum of the products of all pairs
  std::vector<const Hypothesis*> firsts;  // by evidence, those that were fitted before the others
  for (const Hypothesis& h : singles)
    if (h.members.size() == 1) firsts.push_back(&h);
  std::stable_sort(firsts.begin(), firsts.end(), [](const Hypothesis* a, const Hypothesis* b) {
    return std::make_pair(a->refined, a->log_evidence) > std::make_pair(b->refined, b->log_evidence);
  });
  std::vector<std::vector<Hypothesis>> grown(std::min(firsts.size(), most_pair_partners));
  core::parallel_for(0, grown.size(), [&](std::size_t a) {
    std::optional<Evidence> about;
    if (firsts[a]->refined) {
      const bool looked_beside = a == 0 && firsts[a]->log_evidence > worth_looking_beside;
      const LinearForm form = looked_beside ? form_beside(problem, response, machine, white, *firsts[a])
                                            : form_about(problem, white, *firsts[a]);
      about.emplace(
          form, log_none, options.evidence_share,
          a == 0 ? scan_readings(problem, response, machine, white, form, candidates) : std::vector<ScannedReading>());
    }
    const int first = firsts[a]->members[0];
    // What the leading cause itself gains where all else is linearised about it is no second one's.
    const double own_gain = about ? about->of(problem, {first}, 1.0).log_evidence - firsts[a]->log_evidence : 0.0;
    for (std::size_t b = a + 1; b < firsts.size(); ++b) {
      const int second = firsts[b]->members[0];
      grown[a].push_back(
          (about ? *about : nominal)
              .of(problem, {first, second}, options.prior_pair * share_of.at(first) * share_of.at(second) / all_pairs));
      grown[a].back().log_evidence -= own_gain;
    }
  });
  std::vector<Hypothesis> pairs;
  for (const std::vector<Hypothesis>& some : grown) pairs.insert(pairs.end(), some.begin(), some.end());
  return pairs;
}

/// What a search works on.
struct Search {
  const Problem& problem;
  const Response& response;
  const mesh::Machine& machine;
  const SearchOptions& options;
  White white;
  LinearForm form;
  double log_none = 0;
};

/// Parameters that the fitted part can show; the others are put on the list of the invisible ones.
std::vector<int> visible_candidates(const Search& of, std::vector<int>& invisible) {
  std::vector<int> candidates;
  for (int i = 0; i < std::ssize(of.problem.parameters); ++i) {
    const Parameter& p = of.problem.parameters[i];
    const double seen = of.white.columns.col(i).norm() * p.cause_std;
    (seen > visible && p.cause_std > p.nominal_std ? candidates : invisible).push_back(i);
  }
  return candidates;
}

/// Fits the first few hypotheses of so many members that are not fitted yet.
void fit_leading(const Search& of, std::vector<Hypothesis>& all, std::size_t members, int most) {
  std::vector<Hypothesis*> leading;
  for (Hypothesis& h : all)
    if (h.members.size() == members && !h.refined && std::ssize(leading) < most) leading.push_back(&h);
  core::parallel_for(0, leading.size(), [&](std::size_t i) {
    refine(*leading[i], of.problem, of.response, of.machine, of.white, of.log_none, of.options.iterations,
           of.options.evidence_share);
  });
  sort_by_posterior(all);
}

/// Of the nominal value: where the tangent at nominal says little, an estimate that begins there does not get back.
constexpr double ladder[] = {0.4, 2.5};
constexpr std::size_t most_on_ladder = 12;
constexpr double least_on_ladder = 2.0;  ///< nats on the tangent at nominal, and by which a rung has to be better

/// A film at half its value does not act as half of what it does when it doubles; heat acts in proportion.
bool acts_in_proportion(const Parameter& p) {
  const Effect effect = row_of(p.kind).effect;
  return !p.ratio || (effect != Effect::coefficient && effect != Effect::part);
}

/// A single cause on the linear form about one size of it.
Hypothesis at_size(const Search& of, const Hypothesis& single, double size) {
  Hypothesis there;
  there.members = single.members;
  there.value = VectorXd::Constant(1, size);
  linearise(there, of.problem, of.response, of.machine);
  LinearForm form = of.form;
  const int member = single.members.front();
  form.columns.col(member) = of.white.of(of.problem, there.sensitivity);
  const VectorXd off = there.sensitivity * (size - of.problem.nominal[member]);
  form.residual = of.white.of(of.problem, of.problem.measured - there.predicted + off);
  return Evidence(form, of.log_none, of.options.evidence_share)
      .of(of.problem, single.members, std::exp(single.log_prior));
}

/// The leading single causes that do not act in proportion are tried at several sizes; where one of these describes the
/// record better than the tangent at nominal, the fit begins there.
void try_sizes(const Search& of, std::vector<Hypothesis>& all) {
  std::vector<Hypothesis*> leading;
  for (Hypothesis& h : all) {
    if (h.members.size() == 1 && h.log_evidence > least_on_ladder && leading.size() < most_on_ladder &&
        !acts_in_proportion(of.problem.parameters[h.members.front()]))
      leading.push_back(&h);
  }
  core::parallel_for(0, leading.size(), [&](std::size_t i) {
    Hypothesis best = *leading[i];
    for (const double rung : ladder) {
      Hypothesis there = at_size(of, *leading[i], rung);
      if (there.log_evidence > std::max(best.log_evidence, leading[i]->log_evidence + least_on_ladder))
        best = std::move(there);
    }
    *leading[i] = std::move(best);
  });
  sort_by_posterior(all);
}

/// Fits pairs in groups until none that is left comes near the best one.
void fit_pairs(const Search& of, std::vector<Hypothesis>& all) {
  for (int fitted = 0; fitted < of.options.most_refined_pairs; fitted += of.options.pair_group) {
    double best = -std::numeric_limits<double>::infinity(), left = best;
    for (const Hypothesis& h : all) {
      if (h.members.size() == 2) {
        double& of_these = h.refined ? best : left;
        of_these = std::max(of_these, h.log_prior + h.log_evidence);
      }
    }
    if (left < best - of.options.pair_margin) break;
    fit_leading(of, all, 2, of.options.pair_group);
  }
}

/// No cause, single causes and pairs, most probable first.
std::vector<Hypothesis> compared(const Search& of, const std::vector<int>& candidates) {
  const std::vector<double> share = prior_shares(of.problem, candidates);
  const Evidence nominal(of.form, of.log_none, of.options.evidence_share,
                         scan_readings(of.problem, of.response, of.machine, of.white, of.form, candidates));
  std::vector<Hypothesis> all(1);
  all[0].log_prior = std::log(of.options.prior_none);
  for (std::size_t i = 0; i < candidates.size(); ++i)
    all.push_back(nominal.of(of.problem, {candidates[i]}, of.options.prior_single * share[i]));
  sort_by_posterior(all);
  try_sizes(of, all);
  fit_leading(of, all, 1, of.options.refined_singles);

  const std::vector<Hypothesis> pairs = grow_pairs(of.problem, of.response, of.machine, of.white, nominal, of.log_none,
                                                   candidates, share, all, of.options);
  all.insert(all.end(), pairs.begin(), pairs.end());
  sort_by_posterior(all);
  fit_pairs(of, all);
  return all;
}

/// A hypothesis with something unknown beside it.
struct Leftover {
  const Hypothesis* hypothesis;
  double log_weight;                  ///< of its posterior
  std::vector<std::size_t> channels;  ///< that the unknown is in alone; empty: several
  ReadingSteps steps;                 ///< that describe it best; else without steps
};

/// Whether the best single cause and the best pair leave what they do not describe.
std::vector<Leftover> leftovers_of(const Search& of, const std::vector<Hypothesis>& all, double log_without) {
  std::vector<Leftover> leftovers;
  for (const std::size_t members : {1, 2}) {
    for (const Hypothesis& h : all) {
      if (h.members.size() == members && h.refined) {
        const UnknownEvidence beside = evidence_beside_unknown(of.problem, h);
        const double log = of.options.evidence_share * (beside.with - log_without);
        leftovers.push_back(
            {&h, std::log(of.options.prior_leftover) + h.log_prior + log, beside.channels, beside.steps});
        break;
      }
    }
  }
  return leftovers;
}

/// Weights to probabilities: of every hypothesis, of none and unknown, and of every parameter to be in the model.
void weigh(const Search& of, const std::vector<Leftover>& leftovers, SearchResult& result) {
  std::vector<double> listed, with = {std::log(of.options.prior_unknown) + result.log_evidence_unknown};
  for (const Hypothesis& h : result.hypotheses) listed.push_back(h.log_prior + h.log_evidence);
  result.beside_channels.clear();
  result.beside_steps = {};
  double most = with.front();
  for (const Leftover& leftover : leftovers) {
    with.push_back(leftover.log_weight);
    if (leftover.log_weight <= most) continue;
    most = leftover.log_weight;
    result.beside_channels = leftover.channels;
    result.beside_steps = leftover.steps;
  }
  const double of_listed = log_sum_exp(listed), of_unknown = log_sum_exp(with);
  result.log_normal = log_sum_exp({of_listed, of_unknown});
  result.log_odds_unknown = of_unknown - of_listed;
  result.marginal = VectorXd::Zero(std::ssize(of.problem.parameters));
  share_probability(result, of.options);
}

Stretch stretch_of(const Problem& problem, const LinearEvidence& none) {
  Stretch stretch;
  for (int i = 0; i < std::ssize(problem.parameters); ++i) {
    const double std = problem.prior_std[i], off = none.mean()[i] / std;
    // The variance of an estimate about nominal is what the record takes from the prior's.
    const double told = std::max(0.0, 1.0 - none.covariance()(i, i) / (std * std));
    stretch.squares += off * off;
    stretch.squares_mean += told;
    stretch.squares_std += 2.0 * told * told;
    if (std::abs(off) > std::abs(stretch.deviations)) stretch.deviations = off, stretch.which = i;
  }
  stretch.squares_std = std::sqrt(stretch.squares_std);
  return stretch;
}

/// Where none is likely, but only with one parameter far from what is stated of it, that parameter's cause is compared
/// with none on equal terms: a size that large wanders, and its heat spreads, whether its prior is narrow or wide. Else
/// none alone would have this size without the freedom that the cause pays for.
/// @return whether a log evidence has changed
bool compare_on_equal_terms(const Search& of, std::vector<Leftover>& leftovers, SearchResult& result) {
  if (!(result.probability_none > likely_enough) || !result.stretch.beyond()) return false;
  const int which = result.stretch.which;
  const Hypothesis* single = result.single(which);
  if (single == nullptr || !single->refined) return false;
  const LinearForm form = form_about(of.problem, of.white, *single);
  const Parameter& p = of.problem.parameters[which];
  const LinearEvidence::Widened widened =
      LinearEvidence(form.columns, form.residual, form.prior_std).widen({&which, 1}, {&p.cause_std, 1});
  const double against_none = of.options.evidence_share *
                              (widened.log_ratio + log_within_bounds(p, p.nominal + widened.mean[0], widened.std[0]));
  const double more = against_none - single->log_evidence;
  if (!(more > 0.0)) return false;
  const auto holds = [&](const Hypothesis& h) {
    return std::find(h.members.begin(), h.members.end(), which) != h.members.end();
  };
  for (Leftover& leftover : leftovers)
    if (holds(*leftover.hypothesis)) leftover.log_weight += more;
  for (Hypothesis& h : result.hypotheses)
    if (holds(h)) h.log_evidence += more;
  return true;
}

}  // namespace

SearchResult search(const Problem& problem, const Response& response, const mesh::Machine& machine,
                    const SearchOptions& options) {
  options.validate();
  Search of{problem, response, machine, options, White(problem), {}, 0.0};
  of.form = nominal_form(problem, of.white);
  const LinearEvidence none(of.form.columns, of.form.residual, of.form.prior_std);
  of.log_none = none.log_evidence();
  SearchResult result;
  result.chi_square_none = none.chi_square();
  result.fitted = of.white.residual.size();
  result.stretch = stretch_of(problem, none);
  result.hypotheses = compared(of, visible_candidates(of, result.invisible));
  const UnknownEvidence alone =
      unknown_evidence(problem, problem.columns, problem.prior_std, problem.measured - problem.predicted,
                       problem.amplitude, {0.03, 0.1, 0.3, 1.0, 3.0});
  result.log_evidence_unknown = options.evidence_share * (alone.with - alone.without);
  result.unknown_channels = alone.channels;
  result.unknown_steps = alone.steps;
  std::vector<Leftover> leftovers = leftovers_of(of, result.hypotheses, alone.without);
  weigh(of, leftovers, result);
  if (compare_on_equal_terms(of, leftovers, result)) {
    weigh(of, leftovers, result);
    sort_by_posterior(result.hypotheses);
  }
  return result;
}

}  // namespace thermotwin::diagnosis
