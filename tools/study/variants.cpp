// SPDX-License-Identifier: GPL-3.0-or-later
// The verb that computes variants of a case, here or as the tasks of an array job, and gathers their tables.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <map>
#include <optional>

#include "core/error.h"
#include "core/file.h"
#include "core/progress.h"
#include "core/quoted.h"
#include "core/text.h"
#include "reduction/model/model_file.h"
#include "study/plan/design.h"
#include "study/units/unit_files.h"
#include "study/units/unit_work.h"
#include "study/variants/earlier_results.h"
#include "study/variants/variant_results.h"
#include "study/variants/variant_runner.h"
#include "study/variants/variant_unit.h"
#include "tools/chain.h"
#include "tools/page.h"
#include "tools/study/cluster.h"
#include "tools/study/study.h"
#include "tools/study/variants_page.h"

namespace thermotwin::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double most_variants = 100000;
constexpr std::size_t most_shown = 24;

/// Nodes of a mesh size, from its last unit that was computed on the full model, whenever and by whatever task;
/// 0: unknown.
long nodes_of_size(const fs::path& folder, const std::string& size, const std::vector<study::VariantUnit>& units) {
  for (auto unit = units.rbegin(); unit != units.rend(); ++unit) {
    const fs::path file = study::unit_folder(folder, *unit) / "nodes";
    if (unit->size == size && fs::exists(file)) return std::atol(core::read_file(file).c_str());
  }
  return 0;
}

/// Of each mesh size in words; empty: unknown. Warns of sizes that do not change the mesh.
std::string nodes_of(const fs::path& folder, const study::StudyPlan& plan,
                     const std::vector<study::VariantUnit>& units) {
  std::vector<std::string> words;
  std::map<long, std::string> seen;
  for (const std::string& size : plan.sizes) {
    const long nodes = nodes_of_size(folder, size, units);
    if (nodes == 0) continue;
    words.push_back(fmt::format("{}{} nodes", plan.sizes.size() > 1 ? "size " + size + ": " : "", nodes));
    if (const auto [other, fresh] = seen.emplace(nodes, size); !fresh) {
      core::warn(
          fmt::format("sizes '{}' and '{}' have {} nodes each: walls and bores set the size of this mesh, and the "
                      "two groups repeat each other",
                      other->second, size, nodes));
    }
  }
  return core::join(words);
}

study::Design design_of(const study::StudyPlan& plan) {
  const double count = study::variant_count(plan);
  if (count <= most_variants) return study::make_design(plan);
  throw core::InputError(plan.path.string(), fmt::format("{:.6g} variants", count),
                         fmt::format("{} at most", most_variants));
}

/// Units whose matrices cannot be made share one attempt.
study::ComputeUnit computing(study::VariantRunner& runner, const std::vector<study::VariantUnit>& units, bool reduced) {
  return [&runner, &units, reduced, hopeless = std::map<std::string, std::exception_ptr>()](
             std::size_t u, const fs::path& folder) mutable {
    const std::string& matrices = units[u].matrices;
    if (const auto known = hopeless.find(matrices); known != hopeless.end()) std::rethrow_exception(known->second);
    try {
      study::UnitFiles files = runner.run(units[u], folder);
      if (runner.nodes() > 0) core::write_file(folder / "nodes", fmt::format("{}\n", runner.nodes()));
      return files;
    } catch (const core::Error&) {
      if (!reduced && runner.nodes() == 0) hopeless[matrices] = std::current_exception();
      throw;
    }
  };
}

json json_of(const study::VariantStudy& results) {
  json groups = json::array();
  for (const study::GroupStudy& group : results.groups) {
    json of = {{"group", group.name}, {"variants", group.variants}, {"asked", group.asked}, {"loads", json::array()}};
    if (!group.why_no_sensitivity.empty()) of["why_no_sensitivity"] = group.why_no_sensitivity;
    for (const study::LoadStudy& load : group.loads) {
      json one = {
          {"load", load.load}, {"largest_q50_um", load.largest_q50_um}, {"largest_q95_um", load.largest_q95_um}};
      if (load.sensitivity) {
        one["unexplained"] = load.sensitivity->unexplained;
        one["matter"] = json::array();
        for (const std::size_t p : study::that_matter(*load.sensitivity)) {
          const study::Share &first = load.sensitivity->first[p], &total = load.sensitivity->total[p];
          one["matter"].push_back({{"parameter", results.drawn[p]},
                                   {"first", first.value},
                                   {"first_ci95", {first.low, first.high}},
                                   {"total", total.value},
                                   {"total_ci95", {total.low, total.high}}});
        }
      }
      of["loads"].push_back(one);
    }
    groups.push_back(of);
  }
  return groups;
}

/// Load programs that no variant of the group has results of.
std::vector<std::string> without_results(const study::VariantStudy& results, const study::StudyPlan& plan,
                                         std::size_t group) {
  std::vector<std::string> names = plan.loads;
  for (const study::LoadStudy& load : results.groups[group].loads) std::erase(names, load.load);
  return names;
}

std::string reason_of(const study::VariantStudy& results, const study::Design& design, std::size_t group,
                      const std::string& load) {
  for (const study::FailedVariant& one : results.failed)
    if (design.variants[one.variant].group == group && one.load == load) return "failed: " + one.reason;
  return "not computed yet";
}

/// Of a study without and with variants that failed, the same after --local and --gather.
std::string last_lines(const study::VariantStudy& results, std::size_t variants, const fs::path& folder) {
  std::string text = fmt::format("tables and report.html in {}\n", folder.string());
  if (results.failed.empty()) return text;
  for (const std::string& unit : results.failed_units) text += "failed: " + unit + "\n";
  return text + fmt::format("{} of {} variants computed, {} failed; reasons in {}\n", results.computed(), variants,
                            results.failed_variants(), (folder / "failures.csv").string());
}

/// Values that the plan states, one by one: quantiles of them mean nothing.
std::string table_of_values(const study::VariantStudy& results, const study::StudyPlan& plan,
                            const study::Design& design) {
  const std::vector<std::vector<std::string>> rows = study::error_rows(plan, design, results, true, most_shown);
  std::size_t all = 0;
  for (const study::GroupStudy& group : results.groups)
    for (const study::LoadStudy& load : group.loads) all += load.errors.size();
  std::string text = core::format_table(rows);
  if (rows.size() <= all) text += fmt::format("\nthe first {} of {}; all are in errors.csv", rows.size() - 1, all);
  for (std::size_t g = 0; g < results.groups.size(); ++g) {
    for (const std::string& load : without_results(results, plan, g)) {
      text += fmt::format("\n{}, {}: 0 of {}, {}", results.groups[g].name, load, results.groups[g].asked,
                          reason_of(results, design, g, load));
    }
  }
  return text;
}

std::string table_of(const study::VariantStudy& results, const study::StudyPlan& plan, const study::Design& design) {
  if (design.drawn.empty() && !plan.parameters.empty()) return table_of_values(results, plan, design);
  std::vector<std::vector<std::string>> rows{{"group", "load", "variants",
                                              "TCP error, largest over time and poses: median um", "95 % below um",
                                              "parameters that matter (total share)"}};
  for (std::size_t g = 0; g < results.groups.size(); ++g) {
    const study::GroupStudy& group = results.groups[g];
    for (const std::string& name : without_results(results, plan, g)) {
      rows.push_back(
          {group.name, name, fmt::format("0 of {}", group.asked), "-", "-", reason_of(results, design, g, name)});
    }
    for (const study::LoadStudy& load : group.loads) {
      std::vector<std::string> matter;
      if (load.sensitivity) {
        for (const std::size_t p : study::that_matter(*load.sensitivity)) {
          if (matter.size() == 4) break;
          matter.push_back(fmt::format("{} {:.2f}", results.drawn[p], load.sensitivity->total[p].value));
        }
      }
      const std::string no = group.why_no_sensitivity.empty() ? "-" : "none: " + group.why_no_sensitivity;
      rows.push_back({group.name, load.load, fmt::format("{} of {}", group.variants, group.asked),
                      fmt::format("{:.2f}", load.largest_q50_um), fmt::format("{:.2f}", load.largest_q95_um),
                      matter.empty() ? no : core::join(matter)});
    }
  }
  return core::format_table(rows);
}

/// Of a reduced model: the one asked for, that of an earlier verb, or a new one.
reduction::ReducedModel reduced_model(StudyVariantsOptions& options, const study::StudyPlan& plan) {
  if (options.model.empty() && fs::exists(options.out / "model.rom.h5")) options.model = options.out / "model.rom.h5";
  if (options.model.empty() && (!is_local(options.cluster)))
    throw core::UsageError("--reduced on several hosts, or with --dry-run, needs --model, or model.rom.h5 in --out");
  if (plan.sizes.size() > 1)
    throw core::UsageError("--reduced: a reduced model has one mesh, the plan " + std::to_string(plan.sizes.size()) +
                           " sizes");
  reduction::ReducedModel model = model_for(plan.machine_case.folder, options.model, options.out);
  if (options.model.empty()) options.model = options.out / "model.rom.h5";
  return model;
}

/// Where every unit has failed, earlier results stay. @throws InputError
void require_some(const study::VariantStudy& results, const study::StudyPlan& plan) {
  if (results.units_done > 0 || results.failed_units.empty() || !results.missing.empty()) return;
  throw core::InputError(plan.path.string(), "no variant can be computed: " + results.failed_units.front(),
                         "a plan with variants that mesh and solve");
}

void add_results(json& summary, const study::VariantStudy& results) {
  summary["failed"] = results.failed_units;
  summary["variants_computed"] = results.computed();
  summary["variants_failed"] = results.failed_variants();
  summary["groups"] = json_of(results);
  summary["missing"] = results.missing;
}

/// Tables are those of the last run; the units of both models stay.
void warn_of_other_model(const fs::path& folder, bool reduced) {
  if (!fs::exists(folder / "study.json")) return;
  const json before = json::parse(core::read_file(folder / "study.json"), nullptr, false);
  const std::string model = before.is_object() ? before.value("model", "") : "";
  if (model.empty() || (model == "reduced") == reduced) return;
  core::warn(
      fmt::format("the tables in {} came from the {} model and are replaced. Its units are kept: a run {} --reduced "
                  "makes its tables again",
                  folder.string(), model, reduced ? "without" : "with"));
}

/// Tables, pages and summary of the units that are done.
void gather_variants(const StudyVariantsOptions& options, const study::StudyPlan& plan, const study::Design& design,
                     const std::vector<study::VariantUnit>& units, const UnitStudy& of, std::string computed_by,
                     const study::Work& work, const Stopwatch& time) {
  const fs::path& folder = of.folder;
  if (!options.reduced)
    if (const std::string nodes = nodes_of(folder, plan, units); !nodes.empty()) computed_by = nodes;
  warn_of_other_model(folder, options.reduced);
  const study::VariantStudy results = study::gather(folder, plan, design, units);
  require_some(results, plan);
  const std::size_t kept = options.cluster.gather ? results.units_done : work.kept;
  json summary = {{"variants", design.variants.size()},
                  {"units", units.size()},
                  {"computed", work.computed},
                  {"kept", kept},
                  {"model", options.reduced ? "reduced" : "full"},
                  {"computed_by", computed_by},
                  {"set_aside", study::set_aside(folder, results)},
                  {"seconds", time.seconds()},
                  {"peak_GiB", peak_memory_GiB()}};
  study::write_results(folder, plan, design, results);
  add_results(summary, results);
  core::write_file(folder / "study.json", summary.dump(1) + "\n");
  write_page(folder / "report.html", [&] { return variants_page({options, plan, design, results, computed_by}); });
  print_summary(
      options,
      fmt::format("{}\n{} variants on the {} model, {}; {} units computed, {} done before; {:.0f} s, peak memory "
                  "{:.2f} GiB\n{}",
                  table_of(results, plan, design), design.variants.size(), options.reduced ? "reduced" : "full",
                  computed_by, work.computed, kept, time.seconds(), peak_memory_GiB(),
                  last_lines(results, design.variants.size(), folder)),
      summary.dump());
  if (options.cluster.gather) require_none_missing(of, results.missing);
}

}  // namespace

void study_variants(const StudyVariantsOptions& given) {
  const Stopwatch time;
  StudyVariantsOptions options = given;
  study::part_of(options.cluster.part);
  const study::StudyPlan plan = study::read_variant_plan(options.plan);
  const study::Design design = design_of(plan);
  UnitStudy of;
  of.origin = plan.path;
  of.folder = options.out / "study" / plan.name();
  open_study(options.cluster, of.folder, options.plan);
  study::UnitOrigin origin{THERMOTWIN_VERSION, "full"};
  std::optional<reduction::ReducedModel> model;
  std::string computed_by = "every unknown of the mesh";
  if (options.reduced) {
    model = reduced_model(options, plan);
    origin.model = "reduced " + core::content_hash(core::read_file(options.model));
    const bool other = model->machine.hash != plan.machine_case.machine.hash;
    computed_by = fmt::format("order {}, made of {}{}", model->system.order(), model->size,
                              other ? ", from another machine.toml than that of the plan" : "");
  }
  const std::vector<study::VariantUnit> units = study::make_units(plan, design, origin);
  of.units.assign(units.begin(), units.end());
  of.command = fmt::format("study variants {} --checkpoint-every {:g} --solver {}",
                           core::shell_word(fs::absolute(options.plan)), options.checkpoint_every_s, options.solver);
  if (options.reduced) of.command += " --reduced --model " + core::shell_word(fs::absolute(options.model));
  study::RunnerOptions how;
  how.cache = options.out / "cache";
  how.solver = solver::solver_choice(options.solver, "--solver");
  how.reduced = model ? &*model : nullptr;
  how.checkpoint_s = options.checkpoint_every_s;
  study::VariantRunner runner(plan, design, how);
  of.compute = computing(runner, units, options.reduced);
  of.disk_bytes = [&](std::size_t unit) { return study::disk_need(plan, units[unit]); };
  of.memory = [&](const std::vector<std::size_t>& pending) {
    return options.reduced ? study::MemoryWanted{} : study::memory_need(plan, units, pending, how);
  };
  of.gather = [&](const study::Work& work) {
    gather_variants(options, plan, design, units, of, computed_by, work, time);
  };
  carry_out(options, options.cluster, of);
}

}  // namespace thermotwin::tools
