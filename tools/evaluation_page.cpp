// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/evaluation_page.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>
#include <vector>

#include "compensation/evaluation/plots.h"
#include "compensation/evaluation/validation.h"
#include "core/html_name.h"
#include "core/html_page.h"
#include "core/quoted.h"
#include "core/text.h"
#include "tools/page.h"

namespace thermotwin::tools {
namespace {

std::string number(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : "-";
}

/// Rows of a channel, the best model first. @param training  those that the fit saw, or the others
compensation::Rows rows_of(const compensation::Evaluation& e, const std::string& channel, bool training) {
  compensation::Rows table;
  const auto add = [&](const compensation::EvaluationRow& row) {
    if (table.empty()) {
      const std::string in = " " + row.unit;
      table.push_back({"model", "part", "rows", "RMS before" + in, "RMS after" + in, "removed %",
                       "peak to peak before" + in, "peak to peak after" + in, "mean before" + in, "mean after" + in,
                       "largest before" + in, "largest after" + in});
    }
    const compensation::Measures& m = row.measures;
    table.push_back({row.model, row.segment, std::to_string(m.count), number(m.rms_before, 2), number(m.rms, 2),
                     number(m.rms_reduction_percent, 1), number(m.peak_to_peak_before, 2), number(m.peak_to_peak, 2),
                     number(m.mean_before, 2), number(m.mean, 2), number(m.maximum_before, 2), number(m.maximum, 2)});
  };
  for (const compensation::Standing& standing : e.leaderboard)
    for (const compensation::EvaluationRow& row : e.rows)
      if (row.channel == channel && row.model == standing.model && row.training == training) add(row);
  return table;
}

std::string channel_tables(const compensation::Evaluation& e, const std::string& channel) {
  const std::string held_out = core::html_table(rows_of(e, channel, false)),
                    seen = core::html_table(rows_of(e, channel, true));
  if (held_out.empty()) return seen;
  return held_out +
         (seen.empty() ? "" : "<details><summary>The same on rows that the fit saw</summary>" + seen + "</details>");
}

std::string headline(const compensation::Evaluation& e) {
  if (e.leaderboard.empty()) return core::html_finding(core::Tone::warn, "result", {"No model could be judged."});
  const compensation::Standing& best = e.leaderboard.front();
  const std::string where = best.seen_by_fit ? "on its training rows; nothing was held out" : "on held-out data";
  const core::Tone tone = best.seen_by_fit || best.reduction_percent < 20.0 ? core::Tone::warn : core::Tone::good;
  std::vector<std::string> sentences{
      fmt::format("Subtracting the prediction of {} removes {:.1f}&#8239;% of the RMS of the thermal error {}.",
                  core::xml_text(best.model), best.reduction_percent, where)};
  for (const compensation::Standing& standing : e.leaderboard) {
    if (&standing == &best || standing.model != "reduced_model_sensors") continue;
    sentences.push_back(
        fmt::format("That of the reduced model with sensors, which was not fitted to this measurement, removes "
                    "{:.1f}&#8239;%.",
                    standing.reduction_percent));
  }
  if (best.model == "static_regression")
    sentences.emplace_back("No other model predicts this measurement better than the static regression.");
  return core::html_finding(tone, "best model", sentences) +
         core::html_tiles(
             {core::html_tile("best model", core::breakable(core::xml_text(best.model)),
                              fmt::format("of {} models", e.leaderboard.size())),
              core::html_tile("RMS removed", fmt::format("{:.1f}&#8239;%", best.reduction_percent),
                              fmt::format("by the best model, {} channels", best.channels)),
              core::html_tile("against static regression",
                              std::isfinite(best.against_static_percent)
                                  ? fmt::format("{:.1f}&#8239;%", best.against_static_percent)
                                  : "&ndash;",
                              std::isfinite(best.against_static_percent) ? "lower RMS, mean over channels"
                                                                         : "it predicts none of these channels"),
              core::html_tile("training", fmt::format("{:.1f} h", e.training_hours), "time with displacements"),
              core::html_tile("inputs", std::to_string(e.inputs), "channels that a control has to know")});
}

std::string channels(const compensation::Evaluation& e) {
  std::vector<std::pair<std::string, std::string>> items;
  for (const std::string& channel : compensation::scored_channels(e)) {
    items.emplace_back(
        channel, (e.predictions.find(channel + "_measured") ? compensation::channel_svg(e, channel) : "") + "<br>" +
                     channel_tables(e, channel));
  }
  if (items.empty()) return "";
  return core::html_section("Measured and predicted",
                            "the best models and the static regression; below: measured minus predicted. The table "
                            "has all models, the best of the leaderboard first.",
                            core::html_choice("channel", "channel", items));
}

std::string notes(const compensation::Evaluation& e) {
  std::string list;
  for (const std::string& note : e.notes) list += "<li>" + core::html_sentence(note) + "</li>";
  for (const compensation::Standing& standing : e.leaderboard) {
    if (!standing.caution.empty())
      list += "<li>" + core::xml_text(standing.model + " is ranked last: " + standing.caution) + "</li>";
  }
  std::string markup;
  if (!list.empty()) markup += core::html_section("Notes", "", "<ul>" + list + "</ul>");
  if (!e.observer.empty())
    markup += core::html_section("Observability of the disturbance states",
                                 "powers, films, ambients and offsets that the observer estimates beside the "
                                 "temperatures; one that the sensors do not detect keeps its prior",
                                 "<pre>" + core::xml_text(e.observer) + "</pre>");
  return markup;
}

std::string next_steps(const EvaluateOptions& options) {
  const std::string data = core::shell_word(options.data), out = core::shell_word(options.out),
                    machine = options.case_path.empty() ? "" : " " + core::shell_word(options.case_path);
  return core::html_next_steps(
      {{"Why the prediction is off, and what to change:",
        fmt::format("thermotwin diagnose{} --data {} --out {}", machine, data, out)},
       {"How well each model holds under a program that it was not fitted on:",
        fmt::format("thermotwin evaluate{} --data {} --cross --out {}", machine, data, out)},
       {"The fitted models on another machine of the type:",
        fmt::format("thermotwin evaluate --data OTHER_DATA --fitted {}/evaluation/models.toml --out other", out)}});
}

}  // namespace

std::string evaluation_page(const EvaluateOptions& options, const compensation::Evaluation& e) {
  const std::string name = std::filesystem::absolute(options.data).lexically_normal().filename().string(),
                    title = "Evaluation of " + (name.empty() ? options.data.string() : name);
  return core::html_document(
      title,
      core::html_title(title, "compensation models on one measurement") + headline(e) +
          core::html_section(
              "RMS removed",
              "orange: the twin of the machine; grey: the static regression; blue: models fitted to the training rows. "
              "All models are judged on the same rows: 1 - root of the summed mean squares after over those before. A "
              "rotation counts as the displacement at 300 mm; what a model does not predict counts as not compensated. "
              "Offsets of the axes remove the predicted error only in directions that a linear axis moves.",
              core::html_wide(880, compensation::leaderboard_svg(e))) +
          channels(e) + notes(e) + next_steps(options));
}

}  // namespace thermotwin::tools
