// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "core/html_page.h"
#include "core/text.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/report/line_difference.h"
#include "diagnosis/report/page_words.h"
#include "diagnosis/report/residual_sections.h"

namespace thermotwin::diagnosis {

namespace {

constexpr std::size_t shown_causes = 15;

std::string bar(double p) {
  return fmt::format("<span class=\"bar\"><i class=\"blue\" style=\"width:{:.1f}%\"></i></span>{}",
                     100.0 * std::clamp(p, 0.0, 1.0), probability(p));
}

std::string most_probable_tile(const Diagnosis& d) {
  if (!d.explanations.empty()) {
    return core::html_tile("most probable", probability(d.explanations.front().probability),
                           core::xml_text(d.explanations.front().name));
  }
  if (d.ranking.empty()) return core::html_tile("most probable before the last part", "–", "");
  const RankedCause& first = d.ranking.front();
  return core::html_tile("most probable before the last part", probability(first.probability),
                         core::xml_text(name_of(first.parameter.kind) + " " + first.parameter.where));
}

std::string headline(const Diagnosis& d, const mesh::Machine* machine) {
  const Wording words = wording(d, machine);
  std::string page = core::html_title("Diagnosis of " + words.subject, words.below);
  std::string name = name_of(d.verdict);
  std::replace(name.begin(), name.end(), '_', ' ');
  std::string warnings;
  for (const std::string& warning : d.warnings)
    warnings += "<p class=\"warning\">" + core::html_sentence(warning) + "</p>";
  page += "<section class=\"card verdict " + name_of(d.verdict) + "\"><b>" + core::xml_text(name) + "</b><p>" +
          core::html_sentence(d.sentence) + "</p>" + warnings + "</section>\n";
  if (!d.actions.empty()) {
    page += "<section class=\"card\" style=\"margin-top:12px\"><b>What to do</b><ul>";
    for (const std::string& action : d.actions) page += "<li>" + core::html_sentence(action) + "</li>";
    page += "</ul></section>\n";
  }
  return page;
}

std::string tiles(const Diagnosis& d, const mesh::Machine* machine) {
  const Wording words = wording(d, machine);
  const bool gauged =
      std::any_of(d.residuals.begin(), d.residuals.end(), [](const ChannelResidual& r) { return r.unit == "um"; });
  std::string page = "<div class=\"tiles\">\n" + most_probable_tile(d);
  if (gauged && !shows_change(d, machine)) {
    page += core::html_tile(words.residual + ", held out", fmt::format("{:.2f} µm", d.heldout_rms_before_um),
                            "RMS of all displacement channels");
  } else if (gauged) {
    page += core::html_tile(words.residual + " before, held out", fmt::format("{:.2f} µm", d.heldout_rms_before_um),
                            "RMS of all displacement channels");
    page += core::html_tile(words.residual + " after, held out", fmt::format("{:.2f} µm", d.heldout_rms_after_um),
                            "same data, with the cause in the model");
    page += core::html_tile("gain, held out",
                            d.reduction_percent < 0 ? "<span class=\"bad\">" + percent(d.reduction_percent) + "</span>"
                                                    : percent(d.reduction_percent),
                            "95 % interval " + percent(d.ci95_low_percent) + " to " + percent(d.ci95_high_percent));
  }
  return page + "</div>\n";
}

/// One column that adds to 1.
std::string explanations_table(const Diagnosis& d) {
  if (d.explanations.empty()) return "";
  std::string page =
      "<h2>Possible explanations</h2>\n<section class=\"card scroll\"><p class=\"sub\">Exactly one of these holds; the "
      "probabilities add to 1</p><table>\n<tr><th>explanation</th><th>probability</th><th class=\"n\">log "
      "evidence</th></tr>\n";
  for (const Explanation& one : d.explanations) {
    page += fmt::format("<tr{}><td>{}</td><td>{}</td><td class=\"n\">{}</td></tr>\n",
                        one.probability < 0.01 ? " class=\"quiet\"" : "", core::xml_text(one.name),
                        bar(one.probability), one.log_evidence ? fmt::format("{:.1f}", *one.log_evidence) : "–");
  }
  return page + "</table></section>\n";
}

/// Stated uncertainties are those of machine.toml.
std::string ranking_table(const Diagnosis& d, const mesh::Machine* machine) {
  std::string page = "<h2>Each cause by itself</h2>\n<section class=\"card scroll\">";
  if (machine != nullptr)
    page += "<p class=\"sub\">Probability that a cause takes part, alone or in a pair: a pair counts for both</p>";
  page += "<table>\n<tr><th>kind</th><th>where</th><th>probability";
  page += machine == nullptr ? " before the last part, of each channel" : "";
  page += "</th><th class=\"n\">log evidence</th><th>estimate</th>";
  page += machine != nullptr ? "<th class=\"n\">stated uncertainty</th><th class=\"n\">explains, held out</th></tr>\n"
                             : "<th class=\"n\">explains of its channel's RMS, held out</th></tr>\n";
  for (std::size_t i = 0; i < d.ranking.size(); ++i) {
    const RankedCause& cause = d.ranking[i];
    const bool parameter = !cause.parameter.name.empty();
    if (machine != nullptr && i >= shown_causes && parameter) continue;
    const std::string unit = display_unit(cause.parameter.unit);
    page += fmt::format(
        "<tr{}><td>{}</td><td>{}</td><td>{}</td><td class=\"n\">{:.1f}</td><td>{}</td>{}<td class=\"n\">{}</td></tr>\n",
        cause.probability < 0.01 ? " class=\"quiet\"" : "", core::xml_text(name_of(cause.parameter.kind)),
        core::xml_text(cause.parameter.where), bar(cause.probability), cause.log_evidence,
        parameter ? estimate(cause) : "",
        machine == nullptr ? ""
        : parameter && cause.parameter.nominal_std > 0.0
            ? fmt::format("<td class=\"n\">± {}{}{}</td>", two_digits(cause.parameter.nominal_std),
                          unit.empty() ? "" : " ", unit)
            : "<td class=\"n\">–</td>",
        parameter ? percent(cause.heldout_explained_percent) : "");
  }
  return page + "</table></section>\n";
}

std::string extension(const Diagnosis& d, const mesh::Machine* machine) {
  if (machine == nullptr) return "";
  std::string page = "<h2>Extension of the model</h2>\n<section class=\"card\">";
  if (d.extended_machine_text.empty()) return page + "No extension of machine.toml is recommended.</section>\n";
  return page + "<p class=\"sub\">changed lines of machine.toml; the whole file is extended/machine.toml</p><pre>" +
         difference(machine->text, d.extended_machine_text) + "</pre></section>\n";
}

/// If only one thing can be done.
std::string next_section(const Diagnosis& d) {
  if (d.next.channel.empty() && d.next.why.empty()) return "";
  std::string page = "<h2>Next measurement</h2>\n<section class=\"card\">";
  if (d.next.channel.empty()) return page + "<p>" + core::html_sentence(d.next.why) + ".</p></section>\n";
  page += "<p>If you can only do one thing, measure <strong>" + core::xml_text(d.next.channel) + "</strong> under " +
          core::html_sentence(d.next.load) +
          (d.next.duration_h > 0.0 ? fmt::format(" for {:.3g} h", d.next.duration_h) : std::string()) + ": " +
          core::html_sentence(d.next.why) + ".</p><ul>";
  for (const std::string& outcome : d.next.outcomes) page += "<li>" + core::html_sentence(outcome) + "</li>";
  return page + "</ul></section>\n";
}

std::string sets(const Diagnosis& d) {
  std::string page;
  if (!d.ambiguous_set.empty()) {
    page += "<h2>Causes that this measurement does not distinguish</h2>\n<section class=\"card\"><ul>";
    for (const RankedCause& cause : d.ambiguous_set) {
      page += "<li>" +
              (cause.parameter.kind == Kind::none        ? "none: nothing changed"
               : cause.parameter.kind == Kind::other_law ? "another law of " + core::xml_text(cause.parameter.where)
               : cause.parameter.name.empty()            ? "an unknown cause"
                                              : core::xml_text(name_of(cause.parameter)) + ": " + estimate(cause)) +
              ", probability " + probability(cause.probability) + "</li>";
    }
    page += "</ul></section>\n";
  }
  return page + next_section(d);
}

/// Kinds against the size from which they would be seen.
std::string detectability_table(const Diagnosis& d) {
  if (d.detectable.empty()) return "";
  std::string page =
      "<h2>What the record can show</h2>\n<section class=\"card scroll\"><p class=\"sub\">Smallest change of each kind "
      "that this record would show, at the most and at the least observable place</p><table>\n"
      "<tr><th>kind</th><th class=\"n\">from</th><th>at</th><th class=\"n\">to</th><th>at</th>"
      "<th class=\"n\">places that show nothing</th></tr>\n";
  const auto size = [](const Detectable& row, double value) {
    return row.best.empty() ? std::string("–")
           : row.ratio      ? "± " + two_digits(100.0 * value) + "&#8239;%"
                            : "± " + two_digits(value) + " " + display_unit(row.unit);
  };
  for (const Detectable& row : d.detectable) {
    page += fmt::format(
        "<tr><td>{}</td><td class=\"n\">{}</td><td>{}</td><td class=\"n\">{}</td><td>{}</td><td "
        "class=\"n\">{}</td></tr>\n",
        name_of(row.kind), size(row, row.least), core::xml_text(row.best), size(row, row.most),
        core::xml_text(row.worst), row.invisible == 0 ? std::string() : fmt::format("{}", row.invisible));
  }
  return page + "</table></section>\n";
}

std::string notes(const Diagnosis& d) {
  std::string page = "<h2>How it was judged</h2>\n<section class=\"card\"><ul>";
  for (const std::string& note : d.notes) page += "<li>" + core::xml_text(note) + "</li>";
  return page + "</ul></section>\n";
}

}  // namespace

// For the shop first: verdict, what to do, where, what to measure next; then gains, residuals and evidence.
std::string report_html(const Diagnosis& d, const mesh::Machine* machine, const Scene& scene,
                        const std::vector<core::NextStep>& steps) {
  return core::html_document("Diagnosis of " + wording(d, machine).subject,
                             headline(d, machine) + scene_html(scene) + sets(d) + extension(d, machine) +
                                 tiles(d, machine) + records_table(d) + overview(d, machine) + plots(d, machine) +
                                 explanations_table(d) + ranking_table(d, machine) + channel_table(d, machine) +
                                 detectability_table(d) + analysis(d) + notes(d) +
                                 (steps.empty() ? "" : core::html_next_steps(steps)));
}

}  // namespace thermotwin::diagnosis
