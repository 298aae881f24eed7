// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "core/html_page.h"
#include "core/page_text.h"
#include "core/text.h"
#include "core/units.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/judge/residual_analysis.h"
#include "diagnosis/report/svg_plot.h"
#include "diagnosis/report/words.h"

namespace thermotwin::diagnosis {

using Eigen::Index;

namespace {

constexpr std::size_t shown_causes = 15;
constexpr double not_predicted = 1e4;  ///< expected deviation over the residual: an input never moved before

std::string percent(double value) { return percent_text(value, 1) + "&#8239;%"; }

/// Probabilities near 0 and 1 keep their meaning.
std::string probability(double p) {
  if (p < 1e-3) return "&lt; 0.001";
  if (p > 0.999) return "&gt; 0.999";
  return fmt::format("{:.3f}", p);
}

std::string display_unit(const std::string& unit) { return unit == "1" ? "" : core::unit_text(unit); }

std::string two_digits(double value) { return core::plain_number(value, 2); }

/// What a page calls its model and what it expects of a residual.
struct Wording {
  std::string subject, below;  ///< title, and what is said below it; plain text
  std::string residual;        ///< of all displacement channels
  std::string expected, band;  ///< what an expected standard deviation consists of
};

Wording wording(const Diagnosis& d, const mesh::Machine* machine) {
  const std::string measurement = d.measurement.empty() ? "without a name" : d.measurement;
  if (machine != nullptr) {
    return {machine->name, "model of the machine against the record in " + measurement, "TCP residual",
            "stated uncertainty, discretisation error and noise", "stated uncertainty, discretisation error, noise"};
  }
  return {measurement, "measured record; model: a lag model fitted to its first part", "residual",
          "uncertain gains, usual drift and noise", "uncertain gains, usual drift, noise"};
}

std::string estimate(const RankedCause& cause) {
  const std::string unit = display_unit(cause.parameter.unit);
  return fmt::format("{} {} ± {}{}{}", core::xml_text(cause.parameter.name), core::plain_number(cause.value, 4),
                     two_digits(cause.std), unit.empty() ? "" : " ", unit);
}

std::string bar(double p) {
  return fmt::format("<span class=\"bar\"><i class=\"blue\" style=\"width:{:.1f}%\"></i></span>{}",
                     100.0 * std::clamp(p, 0.0, 1.0), probability(p));
}

/// Without a machine nothing is corrected where nothing is named.
bool shows_change(const Diagnosis& d, const mesh::Machine* machine) { return machine != nullptr || !d.causes.empty(); }

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

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// Changed lines with one line of context. The extension only replaces and adds single lines, so a
/// walk that looks a few lines ahead finds every difference.
std::string difference(const std::string& before, const std::string& after) {
  const auto a = lines_of(before), b = lines_of(after);
  std::string out;
  constexpr std::size_t ahead = 4;
  std::size_t i = 0, j = 0;
  std::string table;
  while (i < a.size() || j < b.size()) {
    if (i < a.size() && j < b.size() && a[i] == b[j]) {
      if (a[i].starts_with("[")) table.clear();
      if (table.size() < 400) table += "  " + core::xml_text(a[i]) + "\n";
      ++i, ++j;
      continue;
    }
    out += table.empty() ? "" : table;
    table.clear();
    std::size_t next_a = i, next_b = j;
    bool found = false;
    for (std::size_t step = 1; step <= 2 * ahead && !found; ++step) {
      for (std::size_t in_a = 0; in_a <= step && !found; ++in_a) {
        const std::size_t in_b = step - in_a;
        if (i + in_a < a.size() && j + in_b < b.size() && a[i + in_a] == b[j + in_b] && !a[i + in_a].empty())
          next_a = i + in_a, next_b = j + in_b, found = true;
      }
    }
    if (!found) next_a = a.size(), next_b = b.size();
    for (; i < next_a; ++i) out += "<span class=\"orange\">- " + core::xml_text(a[i]) + "</span>\n";
    for (; j < next_b; ++j) out += "<span class=\"green\">+ " + core::xml_text(b[j]) + "</span>\n";
  }
  return out;
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

std::string channel_table(const Diagnosis& d, const mesh::Machine* machine) {
  const bool change = shows_change(d, machine);
  std::string page =
      "<h2>Residuals in numbers</h2>\n<section class=\"card scroll\"><p class=\"sub\">RMS of measured minus predicted "
      "on held-out data, in the unit of the channel; expected: with a correct model; p: small where a correct model "
      "and white noise would hardly leave this residual</p><table>\n<tr><th>channel</th><th>unit</th><th "
      "class=\"n\">uncertainty</th><th "
      "class=\"n\">expected</th><th class=\"n\">before</th>";
  page += std::string(change ? "<th class=\"n\">after</th><th class=\"n\">change</th>" : "") +
          "<th class=\"n\">white noise, p</th></tr>\n";
  for (const ChannelResidual& r : d.residuals) {
    page += fmt::format(
        "<tr><td>{}</td><td>{}</td><td class=\"n\">{:.3g}</td><td class=\"n\">{}</td><td "
        "class=\"n\">{:.3g}</td>{}<td class=\"n\">{:.2g}</td></tr>\n",
        core::xml_text(r.id), display_unit(residual_unit(r.unit)), r.uncertainty,
        r.explained_std > not_predicted * r.rms_before ? "unknown" : fmt::format("{:.3g}", r.explained_std),
        r.rms_before,
        !change
            ? std::string()
            : fmt::format(
                  "<td class=\"n\">{:.3g}</td><td class=\"n\">{}</td>", r.rms_after,
                  r.rms_before > 0 ? fmt::format("{:+.0f}&#8239;%", 100.0 * (r.rms_after / r.rms_before - 1.0)) : "–"),
        r.p_value_white);
  }
  return page + "</table></section>\n";
}

/// Several records, or the one.
std::vector<DiagnosedRecord> each_record(const Diagnosis& d) {
  if (!d.records.empty()) return d.records;
  DiagnosedRecord one;
  one.heldout_from_s = d.heldout_from_s;
  one.rows = d.series.rows();
  return {one};
}

Eigen::VectorXd of_record(const Diagnosis& d, const DiagnosedRecord& record, const std::string& column) {
  return d.series.column(column).segment(record.first_row, record.rows);
}

std::string records_table(const Diagnosis& d) {
  if (d.records.empty()) return "";
  std::string page =
      "<h2>Records</h2>\n<section class=\"card scroll\"><p class=\"sub\">One machine, several records: a named cause "
      "holds in all of them. RMS of the displacements on the held-out end of each</p><table>\n<tr><th>record</th>"
      "<th class=\"n\">h</th><th class=\"n\">held out from h</th><th class=\"n\">before µm</th><th class=\"n\">after "
      "µm</th></tr>\n";
  const auto um = [](double value) { return value > 0.0 ? fmt::format("{:.2f}", value) : std::string("–"); };
  for (const DiagnosedRecord& record : d.records) {
    page += fmt::format(
        "<tr><td>{}</td><td class=\"n\">{:.1f}</td><td class=\"n\">{:.1f}</td><td class=\"n\">{}</td><td "
        "class=\"n\">{}</td></tr>\n",
        core::xml_text(record.name), (record.to_s - record.from_s) / core::units::hour,
        (record.heldout_from_s - record.from_s) / core::units::hour, um(record.rms_before_um), um(record.rms_after_um));
  }
  return page + "</table></section>\n";
}

std::string plots(const Diagnosis& d, const mesh::Machine* machine) {
  std::string page =
      "<h2>Residuals over time</h2>\n<div class=\"legend\"><span><i class=\"orange\"></i>measured − predicted, "
      "before</span>";
  const bool after = (d.verdict == Verdict::explained || d.verdict == Verdict::ambiguous) && shows_change(d, machine);
  if (after) page += "<span><i class=\"blue\"></i>after, with the best explanation</span>";
  page += "<span><i class=\"band\"></i>± 2 expected standard deviations (" + wording(d, machine).band +
          ")</span><span><i class=\"shade\"></i>held out</span></div>\n<div class=\"plots\">\n";
  for (const ChannelResidual& r : d.residuals) {
    const DiagnosedRecord record = each_record(d)[r.record];
    ResidualPlot plot;
    plot.title = r.id;
    plot.unit = display_unit(residual_unit(r.unit));
    plot.hours = of_record(d, record, "time_s") / core::units::hour;
    plot.before = of_record(d, record, r.id + "_before");
    plot.after = of_record(d, record, r.id + "_after");
    plot.band = 2.0 * of_record(d, record, r.id + "_std");
    plot.heldout_from = record.heldout_from_s / core::units::hour;
    plot.show_after = after;
    page +=
        fmt::format("<figure class=\"card\"><figcaption>{}<span>held-out RMS {:.3g}{} {}</span></figcaption>\n",
                    core::xml_text(r.id), r.rms_before, after ? fmt::format(" → {:.3g}", r.rms_after) : "", plot.unit);
    page += residual_svg(plot) + "</figure>\n";
  }
  return page + "</div>\n";
}

std::string overview(const Diagnosis& d, const mesh::Machine* machine) {
  std::string maps;
  const std::vector<DiagnosedRecord> records = each_record(d);
  for (std::size_t k = 0; k < records.size(); ++k) {
    const DiagnosedRecord& record = records[k];
    ResidualMap map;
    map.hours = of_record(d, record, "time_s") / core::units::hour;
    map.heldout_from = record.heldout_from_s / core::units::hour;
    for (const ChannelResidual& r : d.residuals) {
      if (r.record != static_cast<int>(k)) continue;
      map.channels.push_back(r.id);
      map.ratio.conservativeResize(map.hours.size(), std::ssize(map.channels));
      map.ratio.rightCols(1) =
          of_record(d, record, r.id + "_before").cwiseQuotient(of_record(d, record, r.id + "_std").cwiseMax(1e-12));
    }
    maps += residual_map_svg(map);
  }
  return "<h2>Residuals at a glance</h2>\n<section class=\"card scroll\"><p class=\"sub\">Measured minus predicted, "
         "over the standard deviation expected from " +
         wording(d, machine).expected +
         ".<br>Orange: measured above predicted, blue: below, pale: as expected. Right of the line: held out.</p>\n" +
         maps + "</section>\n";
}

std::string unit_of(const Diagnosis& d, const std::string& channel) {
  for (const ChannelResidual& r : d.residuals)
    if (r.id == channel) return display_unit(residual_unit(r.unit));
  return "";
}

std::string analysis(const Diagnosis& d) {
  if (d.analysis.empty()) return "";
  std::string page =
      "<h2>Residuals and inputs</h2>\n<section class=\"card scroll\"><p class=\"sub\">before the correction; the input "
      "with the largest correlation, and by how much the residual lags it</p><table>\n<tr><th>channel</th><th "
      "class=\"n\">RMS "
      "/ expected</th><th class=\"n\">largest</th><th>unit</th><th class=\"n\">at h</th><th class=\"n\">correlation "
      "time "
      "h</th><th>follows input</th><th class=\"n\">delay h</th><th class=\"n\">correlation</th></tr>\n";
  for (const ResidualAnalysis& a : d.analysis) {
    page += fmt::format(
        "<tr{}><td>{}</td><td class=\"n\">{:.2f}</td><td class=\"n\">{:+.3g}</td><td>{}</td><td "
        "class=\"n\">{:.1f}</td><td "
        "class=\"n\">{:.1f}</td><td>{}</td>"
        "<td class=\"n\">{:.2g}</td><td class=\"n\">{:+.2f}</td></tr>\n",
        a.ratio < 1.5 ? " class=\"quiet\"" : "", core::xml_text(a.id), a.ratio, a.peak, unit_of(d, a.id),
        a.peak_time_s / core::units::hour, a.memory_s / core::units::hour,
        a.follows.empty() ? "–" : core::xml_text(a.follows), a.delay_s / core::units::hour, a.correlation);
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
