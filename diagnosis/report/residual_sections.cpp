// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/report/residual_sections.h"

#include <fmt/format.h>

#include <iterator>
#include <vector>

#include "core/text.h"
#include "core/units.h"
#include "diagnosis/judge/residual_analysis.h"
#include "diagnosis/report/page_words.h"
#include "diagnosis/report/svg_plot.h"

namespace thermotwin::diagnosis {

namespace {

constexpr double not_predicted = 1e4;  ///< expected deviation over the residual: an input never moved before

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

std::string unit_of(const Diagnosis& d, const std::string& channel) {
  for (const ChannelResidual& r : d.residuals)
    if (r.id == channel) return display_unit(residual_unit(r.unit));
  return "";
}

}  // namespace

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

}  // namespace thermotwin::diagnosis
