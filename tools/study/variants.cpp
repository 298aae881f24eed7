// SPDX-License-Identifier: GPL-3.0-or-later
// The verb that computes variants of a case, here or as the tasks of an array job, and gathers their tables.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>

#include "core/error.h"
#include "core/file.h"
#include "core/folder_lock.h"
#include "core/progress.h"
#include "core/text.h"
#include "reduction/model/model_file.h"
#include "study/plan/design.h"
#include "study/units/slurm.h"
#include "study/units/unit.h"
#include "study/units/unit_files.h"
#include "study/variants/earlier_results.h"
#include "study/variants/variant_results.h"
#include "study/variants/variant_runner.h"
#include "tools/chain.h"
#include "tools/page.h"
#include "tools/study/study.h"
#include "tools/study/variants_page.h"

namespace thermotwin::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t most_tasks = 200, most_variants = 100000;

struct Part {
  std::size_t index = 0, of = 1;
};

Part part_of(const std::string& words) {
  if (words.empty()) return {};
  Part part;
  char rest = 0;
  if (std::sscanf(words.c_str(), "%zu/%zu%c", &part.index, &part.of, &rest) != 2 || part.of == 0 ||
      part.index >= part.of)
    throw core::UsageError("--part " + words + ": not I/N with I from 0 to N - 1");
  return part;
}

/// What came of the units.
struct Work {
  std::size_t computed = 0, kept = 0;
  std::vector<std::string> failed;
};

/// Nodes of each mesh size, from its last unit that was computed on the full model, whenever and by whatever task;
/// empty: unknown.
std::string nodes_of(const fs::path& folder, const study::StudyPlan& plan, const std::vector<study::Unit>& units) {
  std::vector<std::string> words;
  for (const std::string& size : plan.sizes) {
    for (auto unit = units.rbegin(); unit != units.rend(); ++unit) {
      const fs::path file = study::unit_folder(folder, *unit) / "nodes";
      if (unit->size != size || !fs::exists(file)) continue;
      words.push_back(fmt::format("{}{} nodes", plan.sizes.size() > 1 ? "size " + size + ": " : "",
                                  std::atol(core::read_file(file).c_str())));
      break;
    }
  }
  return core::join(words);
}

study::Design design_of(const study::StudyPlan& plan) {
  study::Design design = study::make_design(plan);
  if (design.variants.size() <= most_variants) return design;
  throw core::InputError(plan.path.string(), fmt::format("{} variants", design.variants.size()),
                         fmt::format("{} at most", most_variants));
}

/// Computes the units of the part. One that cannot be computed is named; the others go on.
Work compute(const StudyVariantsOptions& options, const study::StudyPlan& plan, const study::Design& design,
             const std::vector<study::Unit>& units, const study::RunnerOptions& how) {
  const Part part = part_of(options.part);
  study::VariantRunner runner(plan, design, how);
  Work work;
  std::map<std::string, std::string> hopeless;  // matrices, message
  bool unsolved = false;
  for (std::size_t u = 0; u < units.size(); ++u) {
    if (u % part.of != part.index) continue;
    const study::Unit& unit = units[u];
    const auto known = hopeless.find(unit.matrices);
    std::string message;
    try {
      if (known == hopeless.end()) {
        const bool computed = runner.run(unit);
        ++(computed ? work.computed : work.kept);
        if (computed && runner.nodes() > 0)
          core::write_file(study::unit_folder(how.study, unit) / "nodes", fmt::format("{}\n", runner.nodes()));
        continue;
      }
      message = known->second;
    } catch (const core::MeshError& error) {
      message = hopeless[unit.matrices] = error.what();
    } catch (const core::SolverError& error) {
      unsolved = true;
      message = error.what();
      if (how.reduced == nullptr && runner.nodes() == 0) hopeless[unit.matrices] = message;  // not even its matrices
    }
    work.failed.push_back(study::words_of(unit, plan, design) + ": " + message);
    study::write_failure(how.study, unit, message);
    if (known == hopeless.end()) core::warn(work.failed.back());
  }
  if (work.computed + work.kept > 0 || work.failed.empty()) return work;
  const std::string none = "no variant can be computed: " + work.failed.front();
  if (unsolved) throw core::SolverError(plan.path.string() + ": " + none);
  throw core::InputError(plan.path.string(), none, "a plan with variants that mesh and solve");
}

void write_scripts(const StudyVariantsOptions& options, const std::vector<study::Unit>& units, const fs::path& study) {
  study::SlurmJob job;
  job.name = options.plan.stem().string();
  job.command = shell_word(fs::read_symlink("/proc/self/exe")) + " study variants " +
                shell_word(fs::absolute(options.plan)) + " --out " + shell_word(fs::absolute(options.out)) +
                fmt::format(" --checkpoint-every {:g} --solver {}", options.checkpoint_every_s, options.solver);
  if (options.reduced) job.command += " --reduced --model " + shell_word(fs::absolute(options.model));
  job.folder = fs::absolute(study / "slurm");
  job.tasks = static_cast<int>(
      std::min(units.size(), options.tasks > 0 ? static_cast<std::size_t>(options.tasks) : most_tasks));
  job.threads = options.task_threads;
  job.memory_GiB = options.task_memory_GiB;
  job.hours = options.task_hours;
  job.partition = options.partition;
  study::write_slurm(job);
  const fs::path submit = job.folder / "submit.sh";
  if (std::system("command -v sbatch >/dev/null 2>&1") != 0)
    core::warn("sbatch is not found here: the scripts are for a host with Slurm that shares " + job.folder.string());
  print_summary(
      options, fmt::format("{} units in {} tasks; submit them: bash {}\n", units.size(), job.tasks, shell_word(submit)),
      json({{"units", units.size()}, {"tasks", job.tasks}, {"submit", submit.string()}}).dump());
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

std::string table_of(const study::VariantStudy& results, const study::StudyPlan& plan, const study::Design& design) {
  std::vector<std::vector<std::string>> rows{
      {"group", "load", "variants", "median um", "95 % below um", "parameters that matter (total share)"}};
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
  if (options.model.empty() && (options.slurm || options.gather || !options.part.empty()))
    throw core::UsageError("--reduced on several hosts needs --model, or model.rom.h5 in --out");
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
      fmt::format("the tables in {} were those of the {} model and are replaced; its units stay, so that a run "
                  "{} --reduced brings them back",
                  folder.string(), model, reduced ? "without" : "with"));
}

}  // namespace

void study_variants(const StudyVariantsOptions& given) {
  const Stopwatch time;
  StudyVariantsOptions options = given;
  part_of(options.part);
  const study::StudyPlan plan = study::read_variant_plan(options.plan);
  const study::Design design = design_of(plan);
  const fs::path folder = options.out / "study" / plan.name();
  require_writable(folder);
  study::claim_folder(folder, options.plan);
  study::UnitOrigin origin{THERMOTWIN_VERSION, "full"};
  std::optional<reduction::ReducedModel> model;
  std::string computed_by = "every unknown of the mesh";
  if (options.reduced) {
    model = reduced_model(options, plan);
    origin.model = "reduced " + core::content_hash(core::read_file(options.model));
    computed_by = fmt::format("order {}, made of {}", model->system.order(), model->size);
  }
  const std::vector<study::Unit> units = study::make_units(plan, design, origin);
  if (options.slurm) return write_scripts(options, units, folder);
  if (const auto stale = study::stale_units(folder, units); !stale.empty()) {
    core::warn(fmt::format("{} units in {} are of another plan, machine, model or version; they are not used",
                           stale.size(), (folder / "units").string()));
  }
  Work work;
  std::optional<core::FolderLock> lock;  // the tasks of an array lock their units only
  if (options.part.empty()) lock.emplace(folder);
  if (!options.gather) {
    if (options.part.empty()) study::require_disk(folder, study::disk_need(plan, design));
    study::RunnerOptions how;
    how.study = folder;
    how.cache = options.out / "cache";
    how.solver = solver::solver_choice(options.solver, "--solver");
    how.reduced = model ? &*model : nullptr;
    how.checkpoint_s = options.checkpoint_every_s;
    work = compute(options, plan, design, units, how);
  }
  if (!options.reduced)
    if (const std::string nodes = nodes_of(folder, plan, units); !nodes.empty()) computed_by = nodes;
  json summary = {{"variants", design.variants.size()},
                  {"units", units.size()},
                  {"computed", work.computed},
                  {"kept", work.kept},
                  {"failed", work.failed},
                  {"model", options.reduced ? "reduced" : "full"},
                  {"computed_by", computed_by},
                  {"seconds", time.seconds()},
                  {"peak_GiB", peak_memory_GiB()}};
  if (!options.part.empty()) {
    return print_summary(options,
                         fmt::format("part {}: {} units computed, {} done before, {} failed\n", options.part,
                                     work.computed, work.kept, work.failed.size()),
                         summary.dump());
  }
  warn_of_other_model(folder, options.reduced);
  const study::VariantStudy results = study::gather(folder, plan, design, units);
  require_some(results, plan);
  summary["set_aside"] = study::set_aside(folder, results);
  study::write_results(folder, plan, design, results);
  if (options.gather) work.kept = results.units_done;
  summary["kept"] = work.kept;
  add_results(summary, results);
  core::write_file(folder / "study.json", summary.dump(1) + "\n");
  write_page(folder / "report.html", [&] { return variants_page({options, plan, design, results, computed_by}); });
  print_summary(
      options,
      fmt::format("{}\n{} variants on the {} model, {}; {} units computed, {} done before; {:.0f} s, peak memory "
                  "{:.2f} GiB\n{}",
                  table_of(results, plan, design), design.variants.size(), options.reduced ? "reduced" : "full",
                  computed_by, work.computed, work.kept, time.seconds(), peak_memory_GiB(),
                  last_lines(results, design.variants.size(), folder)),
      summary.dump());
  if (options.gather && !results.missing.empty()) {
    throw core::InputError(folder.string(),
                           fmt::format("{} of {} units have no result: {}", results.missing.size(), units.size(),
                                       core::join(results.missing, "; ")),
                           "all units done; submit the study again, or compute them with --local");
  }
}

}  // namespace thermotwin::tools
