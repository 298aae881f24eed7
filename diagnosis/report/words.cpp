// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/report/words.h"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>

#include "compensation/measurement/channel.h"
#include "core/text.h"
#include "core/units.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/judge/decision.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/record/diagnose_options.h"
#include "diagnosis/response/response.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

constexpr double long_between_rows_s = 180.0;

std::string in_words(const RankedCause& cause) {
  const Parameter& p = cause.parameter;
  if (p.kind == Kind::none) return "the machine as stated";
  if (p.name.empty()) return "something that no kind describes";
  const std::string unit = p.unit == "1" ? "" : " " + p.unit;
  const std::string more =
      p.missing ? fmt::format(", follows {}, 95 % within {:.0f} mm", p.missing->follows, 1e3 * p.missing->region95)
                : "";
  return fmt::format("{} ({} {:.4g} +- {:.2g}{}{})", name_of(p), p.name, cause.value, cause.std, unit, more);
}

std::string list_in_words(const std::vector<RankedCause>& causes, std::size_t most) {
  std::string words;
  for (std::size_t i = 0; i < std::min(most, causes.size()); ++i)
    words += (i > 0 ? "; " : "") + in_words(causes[i]) + fmt::format(", probability {:.2f}", causes[i].probability);
  if (causes.size() > most) words += fmt::format("; and {} more", causes.size() - most);
  return words;
}

/// Of the reduced model as the record begins, s.
double slowest_time_constant(const reduction::ReducedModel& model, const Observations& obs) {
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> eigen(conduction_at_start(model, model.machine, obs),
                                                                        model.system.capacity, Eigen::EigenvaluesOnly);
  return 1.0 / std::max(eigen.eigenvalues()[0], 1e-12);
}

}  // namespace

std::string percent_text(double percent, int decimals) {
  const double unit = std::pow(10.0, -decimals);
  return fmt::format("{:.{}f}", std::round(percent / unit) * unit + 0.0, decimals);
}

std::string sentence_of(const Diagnosis& d) {
  const std::string gain = d.heldout_rms_before_um > 0
                               ? fmt::format(
                                     " On held-out time the displacements' RMS goes from {:.2f} to {:.2f} um "
                                     "({} %, 95 % interval {} to {}).",
                                     d.heldout_rms_before_um, d.heldout_rms_after_um, percent_text(d.reduction_percent),
                                     percent_text(d.ci95_low_percent), percent_text(d.ci95_high_percent))
                               : "";
  if (d.verdict == Verdict::no_discrepancy) {
    return "No discrepancy: measurement and model differ by no more than nominal uncertainty, mesh and noise "
           "explain.";
  }
  if (d.verdict == Verdict::unexplained)
    return "Unexplained: measurement and model differ, but none of the known causes describes how.";
  if (only_unknown_shares(d) && d.causes.size() == 1 && !outside_nominal(d.causes.front())) {
    return fmt::format(
        "Ambiguous: {} is no further off than is stated of it or than its size is uncertain, but its size and its "
        "course explain what the stated uncertainty does not; or something "
        "that no kind describes acts there.",
        in_words(d.causes.front()));
  }
  if (!d.strained.empty()) {
    std::vector<RankedCause> beside = d.ambiguous_set;
    std::erase_if(beside, [](const RankedCause& cause) { return cause.parameter.name.empty(); });
    return fmt::format(
        "Ambiguous: {}{}; but {}: it has another law, or something that no kind describes acts beside it.",
        list_in_words(d.causes, 1), beside.empty() ? "" : ", perhaps with " + list_in_words(beside, 2), d.strained);
  }
  if (only_unknown_shares(d)) {
    return fmt::format("Ambiguous: {}, and something beside {} that no kind describes, probability {:.2f}.",
                       list_in_words(d.causes, 2), d.causes.size() == 1 ? "it" : "them",
                       d.ambiguous_set.front().probability);
  }
  if (d.verdict == Verdict::ambiguous) {
    return (d.causes.empty() ? "Ambiguous: several causes explain the difference: "
                             : "Ambiguous: " + list_in_words(d.causes, 2) + " and one of: ") +
           list_in_words(d.ambiguous_set, 4) + ".";
  }
  const bool one = d.causes.size() == 1;
  return "Explained by " + list_in_words(d.causes, 3) + "." + gain +
         (!d.extended_machine_text.empty() ? ""
          : d.heldout_rms_before_um > 0 && d.ci95_high_percent < 0
              ? fmt::format(
                    " Alone {} the displacements worse: what else is off, within its uncertainty, had cancelled {}. No "
                    "extension is recommended.",
                    one ? "it makes" : "they make", one ? "it" : "them")
              : " The gain is not certain, so no extension is recommended.");
}

std::vector<std::string> warnings_of(const mesh::Machine& machine, const compensation::Measurement& measurement,
                                     const Problem& problem) {
  const Observations& obs = problem.observations;
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
  if (!taken.empty()) warnings.push_back("Not recorded, so taken to be all the time: " + core::join(taken) + ".");
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
    warnings.push_back("Poses are taken at the home position where a channel names no other: " + core::join(partial) +
                       ".");
  }
  if (!constant.empty()) {
    warnings.push_back("The same value in all of the record, as of a reading that is stuck: " + core::join(constant) +
                       ".");
  }
  if (obs.start_spread_K >= even_start_K) {
    warnings.push_back(
        fmt::format("The first readings differ by {:.2g} K: the machine had not come to rest before the record. What "
                    "it was warmed by is taken into account as far as "
                    "{} sensors and the slow modes tell; a record from rest says more.",
                    obs.start_spread_K, machine.sensors.size()));
  }
  double longest = 0.0;
  for (const Observations::MayHold& may : obs.may_hold) longest = std::max(longest, may.shown - may.from);
  if (longest >= long_between_rows_s) {
    warnings.push_back(
        fmt::format("Speeds, powers or states changed somewhere between rows up to {:.0f} s apart: when, is found from "
                    "what heats fast, as far as that tells. Rows at each "
                    "change, or every minute, say it.",
                    longest));
  }
  return warnings;
}

void add_notes(const reduction::ReducedModel& model, const Problem& problem, const SearchResult& found,
               const DiagnoseOptions& options, Diagnosis& d) {
  const Observations& obs = problem.observations;
  if (const double slowest = slowest_time_constant(model, obs); obs.end - obs.start < slowest) {
    d.notes.push_back(fmt::format(
        "The record of {:.1f} h is shorter than the machine's slowest time constant of {:.1f} h: what acts that slowly "
        "is hardly seen, and the start counts for all of it.",
        (obs.end - obs.start) / core::units::hour, slowest / core::units::hour));
  }
  if (!obs.left_out.empty()) {
    d.notes.push_back("Left out, with fewer than four values in the part that is fitted: " + core::join(obs.left_out) +
                      ".");
  }
  d.notes.push_back(fmt::format(
      "{} means over {:.0f} s of {} channels; {} of them were fitted (until {:.2f} h), the rest only judged.",
      obs.size(), obs.interval, obs.channels.size(), found.fitted, (obs.split - obs.start) / core::units::hour));
  d.notes.push_back(fmt::format("Uniform start at {:.2f} degC (median of the first readings), uncertain by {:.2f} K.",
                                obs.start_C, problem.prior_std[std::ssize(problem.parameters)]));
  d.notes.push_back(fmt::format(
      "Mesh and discretisation: {:.3g} % of each displacement's own response, {:.3g} % of each temperature's. "
      "Chi-square without a "
      "cause: {:.0f} for {} values.",
      options.displacement_error_percent, options.temperature_error_percent, found.chi_square_none, found.fitted));
  if ((d.verdict == Verdict::unexplained || only_unknown_shares(d)) && found.unknown_channel >= 0) {
    d.notes.push_back("What no kind describes shows best in one channel alone: " +
                      obs.channels[found.unknown_channel].channel.id + ".");
  }
  if (!found.invisible.empty()) {
    std::vector<std::string> names;
    for (const int i : found.invisible) names.push_back(name_of(problem.parameters[i]));
    d.notes.push_back("Not visible in this measurement, so not judged: " + core::join(names) + ".");
  }
}

}  // namespace thermotwin::diagnosis
