// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/evaluation_page.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "compensation/evaluation/plots.h"
#include "core/html_page.h"
#include "core/text.h"
#include "tools/page.h"

namespace thermotwin::tools {
namespace {

std::string headline(const compensation::Evaluation& e) {
  if (e.leaderboard.empty()) return core::html_finding(core::Tone::warn, "result", {"No model could be judged."});
  const compensation::Standing& best = e.leaderboard.front();
  const std::string where = best.seen_by_fit ? "on its training rows; nothing was held out" : "on held-out data";
  const core::Tone tone = best.seen_by_fit || best.reduction_percent < 20.0 ? core::Tone::warn : core::Tone::good;
  std::vector<std::string> sentences{fmt::format("{} removes {:.1f}&#8239;% of the RMS of the thermal error {}.",
                                                 core::xml_text(best.model), best.reduction_percent, where)};
  for (const compensation::Standing& standing : e.leaderboard) {
    if (&standing == &best || standing.model != "reduced_model_sensors") continue;
    sentences.push_back(fmt::format("The reduced model with sensors, none of it fitted, removes {:.1f}&#8239;%.",
                                    standing.reduction_percent));
  }
  return core::html_finding(tone, "best model", sentences) +
         core::html_tiles(
             {core::html_tile("best", core::xml_text(best.model), fmt::format("of {} models", e.leaderboard.size())),
              core::html_tile("removed", fmt::format("{:.1f}&#8239;%", best.reduction_percent),
                              fmt::format("RMS over {} channels", best.channels)),
              core::html_tile("below the static regression", fmt::format("{:.1f}&#8239;%", best.against_static_percent),
                              "mean over channels"),
              core::html_tile("training", fmt::format("{:.1f} h", e.training_hours), "of displacements"),
              core::html_tile("inputs", std::to_string(e.inputs), "channels that a control has to know")});
}

std::string channels(const compensation::Evaluation& e) {
  std::vector<std::pair<std::string, std::string>> items;
  for (const std::string& channel : compensation::scored_channels(e)) {
    items.emplace_back(
        channel, (e.predictions.find(channel + "_measured") ? compensation::channel_svg(e, channel) : "") + "<br>" +
                     core::html_table(e.table(channel)));
  }
  if (items.empty()) return "";
  return core::html_section("Measured and predicted", "the best models and the static regression; residuals below",
                            core::html_choice("channel", "channel", items));
}

std::string notes(const compensation::Evaluation& e) {
  std::string list;
  for (const std::string& note : e.notes) list += "<li>" + core::xml_text(note) + "</li>";
  for (const compensation::Standing& standing : e.leaderboard) {
    if (!standing.caution.empty())
      list += "<li>" + core::xml_text(standing.model + " is ranked last: " + standing.caution) + "</li>";
  }
  std::string markup;
  if (!list.empty()) markup += core::html_section("Notes", "", "<ul>" + list + "</ul>");
  if (!e.observer.empty())
    markup += core::html_section("Observability of the disturbance states", "",
                                 "<pre>" + core::xml_text(e.observer) + "</pre>");
  return markup;
}

std::string next_steps(const EvaluateOptions& options) {
  const std::string data = shell_word(options.data), out = shell_word(options.out),
                    machine = options.case_path.empty() ? "" : " " + shell_word(options.case_path);
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
      title, core::html_title(title, "compensation models on one measurement") + headline(e) +
                 core::html_section("RMS removed", "orange: the twin of the machine; grey: the static regression",
                                    core::html_wide(880, compensation::leaderboard_svg(e))) +
                 channels(e) + notes(e) + next_steps(options));
}

}  // namespace thermotwin::tools
