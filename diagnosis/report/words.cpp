// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/report/words.h"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <numeric>
#include <set>

#include "compensation/measurement/channel.h"
#include "compensation/measurement/measurement_check.h"
#include "core/text.h"
#include "core/units.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/missing_source.h"
#include "diagnosis/causes/offered_causes.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/judge/action.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/judge/judgement.h"
#include "diagnosis/judge/ranking.h"
#include "diagnosis/judge/reservations.h"
#include "diagnosis/judge/residual_analysis.h"
#include "diagnosis/record/diagnose_options.h"
#include "diagnosis/response/mesh_allowance.h"
#include "diagnosis/response/response.h"
#include "diagnosis/response/start_modes.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// After a named cause: what becomes of the machine's description.
std::string extension_in_words(const Diagnosis& d) {
  if (!d.extended_machine_text.empty()) return " The correction is in extended/machine.toml.";
  const std::string them = d.causes.size() == 1 ? "it" : "them";
  constexpr double shown_percent = 0.5;  // less is printed as 0
  if (d.heldout_rms_before_um > 0 && d.ci95_high_percent < -shown_percent) {
    return fmt::format(
        " Correcting {0} alone worsens the prediction, because another deviation within its uncertainty "
        "had compensated {0}. No extension is recommended.",
        them);
  }
  if (d.heldout_rms_before_um > 0 && d.effect_heldout_um < shows_little * d.effect_fitted_um) {
    return fmt::format(
        " The held-out data cannot judge the gain: the correction changes their displacements by {:.2g} "
        "um RMS, those of the fitted data by {:.2g} um. No extension is recommended. To decide, take a record in which "
        "the load with this effect lasts to the end.",
        d.effect_heldout_um, d.effect_fitted_um);
  }
  return " The gain is not significant; no extension is recommended.";
}

/// What the correction gains on held-out data: in the displacements, or in the readings that alone are wrong.
std::string gain_in_words(const Diagnosis& d) {
  if (!(d.heldout_rms_before_um > 0)) return "";
  constexpr double nothing_percent = 1e-6;
  const bool readings_only =
      std::all_of(d.causes.begin(), d.causes.end(), [](const auto& c) { return acts_on_readings(c.parameter.kind); });
  if (!readings_only || std::abs(d.reduction_percent) > nothing_percent) {
    return fmt::format(
        " On held-out data the RMS of the displacements goes from {:.2f} to {:.2f} um ({} %, 95 % interval {} to {}).",
        d.heldout_rms_before_um, d.heldout_rms_after_um, percent_text(d.reduction_percent),
        percent_text(d.ci95_low_percent), percent_text(d.ci95_high_percent));
  }
  std::vector<std::string> own;
  for (const ChannelResidual& r : d.residuals) {
    const bool named = std::any_of(d.causes.begin(), d.causes.end(),
                                   [&](const RankedCause& cause) { return cause.parameter.where == r.id; });
    if (named) {
      own.push_back(fmt::format("the RMS of {} goes from {:.3g} to {:.3g} {}", r.id, r.rms_before, r.rms_after,
                                residual_unit(r.unit)));
    }
  }
  return " The correction changes readings, not the displacements, and is judged by these readings." +
         (own.empty() ? "" : " On held-out data " + core::join(own) + ".");
}

std::string in_words(const RankedCause& cause) {
  const Parameter& p = cause.parameter;
  if (p.kind == Kind::none) return "the machine as stated";
  if (p.kind == Kind::other_law) return "another law of " + p.where;
  if (p.name.empty()) return "an unknown cause";
  const std::string unit = p.unit == "1" ? "" : " " + p.unit;
  const std::string more =
      is_step(p.kind) ? ", since " + step_in_words(p)
      : p.missing     ? fmt::format(", follows {}{}, 95 % within {:.0f} mm", follows_in_words(*p.missing),
                                p.missing->alike.empty() ? "" : " or " + core::join(p.missing->alike, " or "),
                                    1e3 * p.missing->region95)
                      : "";
  return fmt::format("{} ({} {} +- {}{}{})", name_of(p), p.name, core::plain_number(cause.value, 4),
                     core::plain_number(cause.std, 2), unit, more);
}

std::string list_in_words(const std::vector<RankedCause>& causes, std::size_t most) {
  std::string words;
  for (std::size_t i = 0; i < std::min(most, causes.size()); ++i)
    words += (i > 0 ? "; " : "") + in_words(causes[i]) + fmt::format(", probability {:.2f}", causes[i].probability);
  if (causes.size() > most) words += fmt::format("; and {} more", causes.size() - most);
  return words;
}

/// What decides between those that share; of a cause beside the machine as stated its own check, where no measurement
/// does.
std::string to_decide(const Diagnosis& d) {
  if (!d.next.channel.empty()) return fmt::format(" To decide, measure {} under {}.", d.next.channel, d.next.load);
  const bool beside_none = d.ambiguous_set.back().parameter.kind == Kind::none;
  if (d.next.why.empty() || !beside_none || d.ambiguous_set.front().parameter.name.empty()) return "";
  return fmt::format(" To decide, check {} on the machine, and its stated uncertainty.",
                     name_of(d.ambiguous_set.front().parameter));
}

/// Causes, and the machine as stated in the last place.
std::string beside_none_in_words(const Diagnosis& d) {
  std::vector<RankedCause> causes = d.ambiguous_set;
  const RankedCause none = causes.back();
  causes.pop_back();
  const std::string listed = list_in_words(causes, 4);
  if (causes.front().probability >= sure)
    return fmt::format("Ambiguous: the difference is explained by {}. But {}.", listed, d.open_because);
  const std::string but = d.open_because.empty() ? "" : " But " + d.open_because + ".";
  return fmt::format("Ambiguous: {}; or {}.{}", listed, list_in_words({none}, 1), but);
}

/// Something unknown in the first place, and causes that may act alone or beside it.
std::string beside_unknown_in_words(const Diagnosis& d) {
  return fmt::format(
      "Ambiguous: no cause describes the difference with certainty: {}. The probability of a cause is that of this "
      "cause alone or together with the unknown one.",
      list_in_words(d.ambiguous_set, 4));
}

/// The cause that an explanation named before it was found strained.
std::string strained_name(const Diagnosis& d) {
  for (const RankedCause& cause : d.ambiguous_set)
    if (!cause.parameter.name.empty()) return name_of(cause.parameter);
  return "it";
}

/// What a coarse mesh leaves open, and what to do; empty where the mesh is fine.
std::string mesh_hides(const Diagnosis& d) {
  constexpr double much = 0.05;
  if (d.mesh_share <= much) return "";
  return fmt::format(
      " The mesh error is up to {:.0f} % of a channel's change and hides effects of that size. It is smaller in a "
      "model "
      "of quadratic tetrahedra: `thermotwin reduce CASE --mesh-order 2`.",
      100.0 * d.mesh_share);
}

/// What comes nearest of all that is listed, and by how much it is not enough.
void add_misfit_note(const Problem& problem, const SearchResult& found, Diagnosis& d) {
  const Hypothesis* best = nullptr;
  for (const Hypothesis& h : found.hypotheses)
    if (h.refined && (best == nullptr || h.log_evidence > best->log_evidence)) best = &h;
  if (best == nullptr || best->log_evidence < strong) return;
  std::vector<std::string> names;
  for (const int member : best->members) names.push_back(name_of(problem.parameters[member]));
  d.nearest = core::join(names, " with ");
  d.notes.push_back(
      fmt::format("Of the listed causes, {} comes nearest (ln Bayes factor {:.1f} against no cause). Something unknown "
                  "or the held-out data contradict it by a ln Bayes factor of {:.1f}. Together with something unknown, "
                  "the log evidence of causes is therefore divided by {:.1f}.",
                  d.nearest, best->log_evidence, found.misfit, 1.0 + found.misfit));
}

/// Of the reduced model as the record begins, s.
double slowest_time_constant(const reduction::ReducedModel& model, const Observations& obs) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> eigen(conduction_at_start(model, model.machine, obs),
                                                                        model.system.capacity, Eigen::EigenvaluesOnly);
  return 1.0 / std::max(eigen.eigenvalues()[0], 1e-12);
}

/// Channels that seem to be others come before all causes.
std::string connection_in_words(const Diagnosis& d) {
  std::vector<RankedCause> listed = d.causes;
  for (const RankedCause& cause : d.ambiguous_set)
    if (!cause.parameter.name.empty()) listed.push_back(cause);
  return fmt::format(
      "{}: {}. Before anything else, check signs and units, and where each cable ends: the warnings state the "
      "figures.{}",
      d.verdict == Verdict::unexplained ? "Unexplained" : "Ambiguous", d.connection,
      listed.empty() ? "" : " If all is as stated, these describe the record best: " + list_in_words(listed, 3) + ".");
}

}  // namespace

std::string percent_text(double percent, int decimals) {
  const double unit = std::pow(10.0, -decimals);
  return fmt::format("{:.{}f}", std::round(percent / unit) * unit + 0.0, decimals);
}

std::string sentence_of(const Diagnosis& d) {
  if (d.verdict == Verdict::no_discrepancy) {
    return "No discrepancy: measurement and model agree within stated uncertainty, discretisation error and noise. "
           "Effects too small for this record remain possible." +
           mesh_hides(d);
  }
  if (!d.connection.empty()) return connection_in_words(d);
  if (d.verdict == Verdict::unexplained)
    return "Unexplained: measurement and model differ, and no known kind of cause describes the difference. "
           "report.html shows in which channels and when the residual exceeds its expected size." +
           (d.steps.steps.empty() ? ""
                                  : (d.steps.creeps() ? " A creep describes it best: " : " Steps describe it best: ") +
                                        in_words(d.steps) + ".") +
           (d.nearest.empty() ? ""
                              : " Of the listed causes, " + d.nearest + " comes nearest, but does not explain it.");
  if (only_unknown_shares(d) && d.causes.size() == 1 && !outside_nominal(d.causes.front())) {
    return fmt::format(
        "Ambiguous: {} lies within its stated uncertainty or that of its estimate. It nevertheless explains a residual "
        "that the stated uncertainty alone does not; an unknown cause there is possible.",
        in_words(d.causes.front()));
  }
  if (d.verdict == Verdict::ambiguous && d.causes.empty() &&
      d.ambiguous_set.front().parameter.kind == Kind::other_law) {
    std::vector<std::string> places;
    for (const RankedCause& cause : d.ambiguous_set) {
      if (cause.parameter.kind == Kind::other_law)
        places.push_back(fmt::format("{} (probability {:.2f})", cause.parameter.where, cause.probability));
    }
    return fmt::format(
        "Ambiguous: the size of {} changes in the course of the record, by a law that machine.toml does not have.",
        core::join(places, " or of "));
  }
  if (!d.strained.empty() && d.causes.empty())
    return fmt::format("{} As the only explanation {} is strained: {}.", beside_unknown_in_words(d), strained_name(d),
                       d.strained);
  if (!d.strained.empty()) {
    std::vector<RankedCause> beside = d.ambiguous_set;
    std::erase_if(beside, [](const RankedCause& cause) { return cause.parameter.name.empty(); });
    const std::string named =
        list_in_words(d.causes, 1) + (beside.empty() ? "" : ", perhaps with " + list_in_words(beside, 2));
    if (d.foretold_beside_others) {
      return fmt::format(
          "Ambiguous: {}. The correction alone does not help: {}. Together with other values of machine.toml, each "
          "within its stated uncertainty, the cause predicts these data as well as expected. Such values had hidden a "
          "part of it: identify them too before the machine is corrected.",
          named, d.strained);
    }
    return fmt::format("Ambiguous: {}. As the only explanation it is strained: {}. {}", named, d.strained,
                       d.one_heat.empty()         ? "Either it follows another law, or an unknown cause acts as well."
                       : d.one_heat == d.strained ? "The power of the stated source is to be checked first."
                                                  : "Also, " + d.one_heat + ".");
  }
  if (only_unknown_shares(d)) {
    return fmt::format("Ambiguous: {}, and an unknown cause as well, probability {:.2f}.", list_in_words(d.causes, 2),
                       d.ambiguous_set.front().probability);
  }
  if (d.verdict == Verdict::ambiguous && d.causes.empty() && d.ambiguous_set.size() > 1 &&
      d.ambiguous_set.back().parameter.kind == Kind::none)
    return beside_none_in_words(d) + to_decide(d);
  if (d.verdict == Verdict::ambiguous && d.causes.empty() && d.ambiguous_set.front().parameter.kind == Kind::unknown)
    return beside_unknown_in_words(d) + to_decide(d);
  if (d.verdict == Verdict::ambiguous) {
    return (d.causes.empty() ? "Ambiguous: several causes explain the difference, none of them with certainty: "
                             : "Ambiguous: " + list_in_words(d.causes, 2) + " and one of: ") +
           list_in_words(d.ambiguous_set, 4) + "." + to_decide(d);
  }
  return "Explained by " + list_in_words(d.causes, 3) + "." + gain_in_words(d) + extension_in_words(d);
}

std::vector<std::string> warnings_of(const mesh::Machine& machine, const compensation::Measurement& measurement,
                                     const Observations& obs) {
  const solver::Channels channels(machine);
  std::vector<std::string> warnings, taken, partial, constant;
  for (const compensation::Channel& input : compensation::channels_of(channels)) {
    using compensation::Quantity;
    const std::string& name = input.name;
    const double otherwise = channels.defaults()[channels.index(name)];
    const bool recorded = std::any_of(measurement.channels.begin(), measurement.channels.end(),
                                      [&](const auto& c) { return c.input == name; });
    // Surroundings but the air are parameters of their own that hardly change; without fluid on a film its state is
    // nothing.
    const bool counts =
        (input.quantity != Quantity::temperature || name == "air.T_C") && input.quantity != Quantity::gradient &&
        name != "machine.on" &&
        (name != "cutting_fluid.on" || std::any_of(machine.films.begin(), machine.films.end(),
                                                   [&](const mesh::FilmSpec& film) { return film.state == name; }));
    if (!recorded && counts && std::isfinite(otherwise)) taken.push_back(fmt::format("{} {:.4g}", name, otherwise));
  }
  if (channels.index(mesh::time_of_day) >= 0 && !compensation::tells_time_of_day(measurement)) {
    warnings.push_back(
        "The time of day is not recorded: laws of machine.toml over day.time_h contribute 0. State starts_at under "
        "[record] of channels.toml.");
  }
  if (!taken.empty()) warnings.push_back("Not recorded; assumed constant: " + core::join(taken) + ".");
  for (const mesh::SourceSpec* source : unrecorded_sources(machine, measurement)) {
    warnings.push_back(
        fmt::format("{0}.power_W is not recorded; source {1} is assumed to give 0 W. If the machine was cutting, the "
                    "heat of this source appears as another cause: record {0}.power_W.",
                    source->drive, source->id));
  }
  for (const ObservedChannel& observed : obs.channels) {
    std::string pose = "," + observed.channel.pose_text;
    std::erase_if(pose, [](unsigned char c) { return std::isspace(c); });
    for (const mesh::Axis& axis : machine.axes) {
      if (pose.size() > 1 && !axis.endless && pose.find("," + axis.id + "=") == std::string::npos)
        partial.push_back(observed.channel.id + " leaves out " + axis.id);
    }
    const Eigen::VectorXd& value = observed.value;
    if (value.size() >= 8 && value.maxCoeff() - value.minCoeff() < 1e-9) constant.push_back(observed.channel.id);
  }
  if (!partial.empty()) {
    warnings.push_back("Incomplete poses in channels.toml; axes that are left out are assumed at the home position: " +
                       core::join(partial) + ".");
  }
  if (!constant.empty()) {
    warnings.push_back("Constant in all of the record, probably stuck: " + core::join(constant) + ".");
  }
  if (begins_warm(obs)) {
    warnings.push_back(fmt::format(
        "The first readings differ by {:.2g} K: the machine was not in thermal equilibrium when the record began. Its "
        "initial temperature field was estimated from {} sensors, and what ran before is taken as unknown. A record "
        "that begins in equilibrium is more informative.",
        std::max(obs.start_spread_K, obs.start_second_K), machine.sensors.size()));
  }
  std::set<double> unknown;  // ends of the pauses in which anything may have run
  for (const Observations::MayHold& may : obs.may_hold)
    if (may.in_pause) unknown.insert(may.shown);
  double longest = 0.0;
  for (const Observations::MayHold& may : obs.may_hold)
    if (!unknown.contains(may.shown)) longest = std::max(longest, may.shown - may.from);
  if (longest > long_row_s) {
    warnings.push_back(fmt::format(
        "Switching times are uncertain, because rows are up to {:.0f} s apart where a speed, power or state changes. "
        "They were estimated from fast-responding sensors. Record a row at each change, or one every minute.",
        longest));
  }
  double pause = 0.0;
  for (const Observations::OpenChange& each : obs.pauses)
    if (unknown.contains(each.shown)) pause = std::max(pause, each.shown - each.from);
  if (!unknown.empty()) {
    const double hours = pause / core::units::hour;
    warnings.push_back(fmt::format(
        "The log has {}. What ran meanwhile is taken as unknown, so the rows after it say less about causes. Log "
        "without pauses, or state [record] rows_at_changes = true where nothing changed.",
        unknown.size() == 1 ? fmt::format("a pause of {:.1f} h", hours)
                            : fmt::format("{} pauses of up to {:.1f} h", unknown.size(), hours)));
  }
  return warnings;
}

void add_notes(const reduction::ReducedModel& model, const Problem& problem, const SearchResult& found,
               const DiagnoseOptions& options, Diagnosis& d) {
  const Observations& obs = problem.observations;
  double longest = 0.0;
  for (const Observations& record : obs.each()) longest = std::max(longest, record.end - record.start);
  if (const double slowest = slowest_time_constant(model, obs); longest < slowest) {
    d.notes.push_back(fmt::format(
        "The {} of {:.1f} h is shorter than the machine's slowest time constant of {:.1f} h. Effects "
        "that slow are hardly observable, and the initial state influences the whole record.",
        obs.records.empty() ? "record" : "longest record", longest / core::units::hour, slowest / core::units::hour));
  }
  if (!obs.left_out.empty()) {
    d.notes.push_back("Left out, with fewer than four values in the fitted part: " + core::join(obs.left_out) + ".");
  }
  for (const Observations& record : obs.each()) {
    const Index fitted =
        std::accumulate(record.channels.begin(), record.channels.end(), Index{0},
                        [](Index sum, const ObservedChannel& channel) { return sum + channel.fitted; });
    d.notes.push_back(fmt::format(
        "{}{} means over {:.0f} s of {} channels; {} of them were fitted (until {:.2f} h), the others were held out.",
        record.name.empty() ? "" : record.name + ": ", record.size(), record.interval, record.channels.size(), fitted,
        (record.split - record.start) / core::units::hour));
    d.notes.push_back(fmt::format(
        "{}Initial temperature: uniform, {:.2f} degC (median of the first readings), standard deviation {:.2f} K.",
        record.name.empty() ? "" : record.name + ": ", record.start_C, start_std(record)));
  }
  const MeshAllowance allowance(model.machine, model.mesh_error, options);
  // Residuals far below what is expected of them: the expectation is mostly the mesh's.
  constexpr double far_below = 0.25;
  d.mesh_share = found.chi_square_none < far_below * found.fitted ? allowance.largest() : 0.0;
  d.notes.push_back(allowance.sentence());
  d.notes.push_back(
      fmt::format("Chi-square without a cause: {:.0f} for {} values.", found.chi_square_none, found.fitted));
  if (found.probability_unknown >= 0.5) add_misfit_note(problem, found, d);
  if (const Stretch& stretch = found.stretch; stretch.too_far()) {
    d.notes.push_back(fmt::format(
        "Without a cause, {} would be {:.1f} stated standard deviations from nominal; the sum of squares of all "
        "parameters would be {:.0f}, expected {:.0f}.",
        name_of(problem.parameters[stretch.which]), std::abs(stretch.deviations), stretch.squares,
        stretch.squares_mean));
  }
  if ((d.verdict == Verdict::unexplained || only_unknown_shares(d)) && !found.unknown_channels.empty()) {
    std::vector<std::string> names;
    for (const std::size_t k : found.unknown_channels) names.push_back(obs.channels[k].channel.id);
    d.notes.push_back("The unexplained residual is concentrated in " +
                      std::string(names.size() == 1 ? "one channel alone: " : "these channels alone: ") +
                      core::join(names) + ".");
  }
  if (!found.invisible.empty()) {
    std::vector<std::string> names;
    for (const int i : found.invisible) names.push_back(name_of(problem.parameters[i]));
    d.notes.push_back("Not observable in this measurement, hence not judged: " + core::join(names) + ".");
  }
}

}  // namespace thermotwin::diagnosis
