// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/study/variants_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "core/html_page.h"
#include "core/quoted.h"
#include "core/text.h"
#include "study/variants/variant_plots.h"
#include "tools/page.h"

namespace thermotwin::tools {
namespace {

using study::GroupStudy;
using study::LoadStudy;
using Rows = std::vector<std::vector<std::string>>;

constexpr std::size_t most_bars = 20, least_of_quantile = 20, most_listed = 60;

std::string name_of(const VariantsPage& page, const GroupStudy& group, const LoadStudy& load) {
  return page.results.groups.size() > 1 ? load.load + ", " + group.name : load.load;
}

std::string finding(const VariantsPage& page) {
  std::vector<std::string> sentences;
  for (const GroupStudy& group : page.results.groups) {
    for (const LoadStudy& load : group.loads) {
      std::string sentence =
          fmt::format("{}: the TCP error of the median machine reaches {:.1f}&#8239;µm, {} {:.1f}&#8239;µm.",
                      core::xml_text(name_of(page, group, load)), load.largest_q50_um,
                      group.variants < least_of_quantile ? "the 95 % quantile of these machines is"
                                                         : "that of 19 in 20 stays below",
                      load.largest_q95_um);
      if (load.sensitivity) {
        std::vector<std::string> names;
        for (const std::size_t p : study::that_matter(*load.sensitivity)) {
          if (names.size() == 3) break;
          names.push_back(fmt::format("{} ({:.0f}&#8239;%)", core::xml_text(page.results.drawn[p]),
                                      100.0 * load.sensitivity->total[p].value));
        }
        if (!names.empty()) sentence += " Most of the spread comes from " + core::join(names) + ".";
      }
      sentences.push_back(sentence);
    }
  }
  if (sentences.empty()) sentences.emplace_back("No variant has results.");
  const bool whole = page.results.missing.empty();
  if (!whole) {
    sentences.push_back(
        fmt::format("{} units of work have no result; the figures are of the others.", page.results.missing.size()));
  }
  const std::size_t failed = page.results.failed_variants();
  if (failed > 0) {
    sentences.push_back(fmt::format("{} of {} variants could not be computed; the figures are of the others.", failed,
                                    page.design.variants.size()));
  }
  return core::html_finding(whole && failed == 0 ? core::Tone::plain : core::Tone::warn, "spread", sentences);
}

std::string tiles(const VariantsPage& page) {
  double largest = 0.0;
  for (const GroupStudy& group : page.results.groups)
    for (const LoadStudy& load : group.loads) largest = std::max(largest, load.largest_q95_um);
  return core::html_tiles(
      {core::html_tile(
           "variants with results",
           page.results.computed() == page.design.variants.size()
               ? std::to_string(page.design.variants.size())
               : fmt::format("{} of {}", page.results.computed(), page.design.variants.size()),
           fmt::format("{} parameters, {} of them drawn", page.plan.parameters.size(), page.design.drawn.size())),
       core::html_tile("largest TCP error", fmt::format("{:.1f} µm", largest), "95 % of the machines stay below"),
       core::html_tile("load programs", std::to_string(page.plan.loads.size()), "each on every variant"),
       core::html_tile("computed by", page.options.reduced ? "reduced model" : "full model",
                       core::xml_text(page.model))});
}

std::string curves(const VariantsPage& page) {
  std::vector<std::pair<std::string, std::string>> items;
  const auto poses = std::ssize(page.results.poses);
  for (const GroupStudy& group : page.results.groups) {
    for (const LoadStudy& load : group.loads) {
      for (Eigen::Index p = 0; p < poses; ++p) {
        const std::string pose = mesh::format_pose(page.plan.machine_case.machine, page.results.poses[p]);
        items.emplace_back(name_of(page, group, load) + (pose.empty() ? "" : ", ") + pose,
                           study::quantiles_svg(load, p, poses));
      }
    }
  }
  if (items.empty()) return "";
  return core::html_section("TCP error over time", "median of the machines, and the band from 5 to 95 % of them",
                            core::html_choice("curves", "load and pose", items));
}

std::string shares(const VariantsPage& page) {
  std::string markup;
  for (const GroupStudy& group : page.results.groups) {
    if (!group.why_no_sensitivity.empty()) {
      markup += core::html_section("Sensitivities of " + group.name, "",
                                   "<p>None: " + core::xml_text(group.why_no_sensitivity) + ".</p>\n");
    }
    for (const LoadStudy& load : group.loads) {
      if (!load.sensitivity) continue;
      Rows rows{{"parameter", "first order", "total"}};
      for (const std::size_t p : study::by_total(*load.sensitivity)) {
        rows.push_back(
            {page.results.drawn[p], share_words(load.sensitivity->first[p]), share_words(load.sensitivity->total[p])});
        if (rows.size() > most_bars) break;
      }
      std::string below = "shares of the variance of the three translations, all poses and times; 95 % intervals";
      if (page.plan.sampling != study::Sampling::pick_freeze) {
        below += fmt::format("; the regression leaves {:.2g} % of the variance, which counts to the upper ends",
                             100.0 * load.sensitivity->unexplained);
      }
      markup += core::html_section(
          "Parameters that matter, " + name_of(page, group, load), core::xml_text(below),
          study::shares_svg(page.results.drawn, *load.sensitivity, most_bars) + core::html_table(rows));
    }
  }
  return markup;
}

/// The result of each variant, where there are few.
std::string each(const VariantsPage& page) {
  const Rows rows = study::error_rows(page.plan, page.design, page.results, true, most_listed);
  if (rows.size() < 2) return "";
  std::size_t all = 0;
  for (const GroupStudy& group : page.results.groups)
    for (const LoadStudy& load : group.loads) all += load.errors.size();
  return core::html_section(
      "Each variant",
      rows.size() <= all
          ? fmt::format("the first {} of {}; all are in errors.csv and variants.csv", rows.size() - 1, all)
          : "length of the TCP error, the largest over poses",
      core::html_table(rows));
}

std::string missing(const VariantsPage& page) {
  const auto section = [](const char* title, const char* head, const std::vector<std::string>& units) {
    if (units.empty()) return std::string();
    Rows rows{{head}};
    for (const std::string& unit : units) rows.push_back({unit});
    return core::html_section(title, "", core::html_table(rows));
  };
  return section("Failed", "units that cannot be computed", page.results.failed_units) +
         section("Missing", "units without results", page.results.missing);
}

std::string next_steps(const VariantsPage& page) {
  const std::string plan = core::shell_word(page.options.plan), out = core::shell_word(page.options.out);
  std::string how = out;
  if (page.options.reduced) how += " --reduced --model " + core::shell_word(page.options.model);
  if (page.options.solver != StudyVariantsOptions().solver) how += " --solver " + page.options.solver;
  std::vector<core::NextStep> steps;
  if (!page.results.missing.empty())
    steps.push_back({"Compute what is missing; the rest is kept:",
                     fmt::format("thermotwin study variants {} --out {}", plan, how)});
  steps.push_back({"The same plan on a cluster; what is done here is kept:",
                   fmt::format("thermotwin study variants {} --slurm --out {}", plan, how)});
  steps.push_back({"Validate the compensation on machines that differ alike:",
                   fmt::format("thermotwin validate {} --draws 20 --out {}",
                               core::shell_word(page.plan.machine_case.folder), out)});
  return core::html_next_steps(steps);
}

}  // namespace

std::string share_words(const study::Share& share) {
  return fmt::format("{:.3f} ({:.3f} to {:.3f})", share.value, share.low, share.high);
}

std::string variants_page(const VariantsPage& page) {
  const std::string title = "Variants of " + page.plan.machine_case.machine.name;
  const std::string below =
      page.plan.title.empty() ? "a family of machines under the same load programs" : page.plan.title;
  return core::html_document(title, core::html_title(title, below) + finding(page) + tiles(page) + curves(page) +
                                        shares(page) + each(page) + missing(page) + next_steps(page));
}

}  // namespace thermotwin::tools
