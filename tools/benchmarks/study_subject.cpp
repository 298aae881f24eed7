// SPDX-License-Identifier: GPL-3.0-or-later
// Processor time of variants of powers and films in one study, of one of them alone, and of a campaign of their load.
// Some variants are compared with campaigns of their own first.
#include <fmt/format.h>

#include <set>

#include "core/error.h"
#include "core/file.h"
#include "core/table.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/full_model.h"
#include "study/plan/design.h"
#include "study/plan/plan.h"
#include "study/variants/variant_unit.h"
#include "tools/benchmarks/report.h"
#include "tools/benchmarks/subjects.h"

namespace thermotwin::bench {
namespace {

namespace fs = std::filesystem;

constexpr double most_ratio = 20.0;        // of processor times, at most
constexpr double most_difference = 1e-9;   // between tables, relative to the largest error of a column
constexpr double other_difference = 1e-5;  // above this the programs compute different things

/// A plan whose variants differ in all powers and films with a std_percent.
void write_plan(const Settings& s, const fs::path& file, int samples) {
  core::write_file(file, fmt::format("schema = 1\ncase = \"{}\"\nloads = [\"{}\"]\nsize = \"{}\"\nsamples = {}\n"
                                     "[[parameter]]\nkind = \"source_power\"\nwhere = \"*\"\n"
                                     "[[parameter]]\nkind = \"film_coefficient\"\nwhere = \"*\"\n",
                                     s.case_path.string(), s.study_load, s.size, samples));
}

Outcome study(const Settings& s, const fs::path& plan, const fs::path& out) {
  fs::remove_all(out);
  Command command;
  command.words = {s.thermotwin.string(), "study",   "variants", plan.string(), "--out",
                   out.string(),          "--quiet", "--json",   "--threads",   std::to_string(s.threads)};
  command.output = s.work / "study.json";
  return run(command);
}

/// The table of the variant, in whichever unit it is.
core::Table table_of(const fs::path& study, std::size_t variant) {
  const fs::path name = study::tcp_file(variant);
  for (const auto& entry : fs::recursive_directory_iterator(study / "units"))
    if (entry.path().filename() == name) return core::read_csv(entry.path());
  throw core::InputError(study.string(), "no " + name.string(), "a study that has computed all its variants");
}

/// TCP errors of a campaign of the variant's machine alone, on a model of its own.
core::Table campaign_of(const Settings& s, const study::StudyPlan& plan, const Eigen::VectorXd& values) {
  const mesh::Machine machine = study::machine_of(plan, values);
  const solver::FullModel full =
      solver::build_full_model(machine, {mesh::size_factor(machine, s.size), s.work / "cache"});
  return solver::run_campaign(full, {plan.machine_case.load(s.study_load)}, {}).front().tcp;
}

/// @return the largest difference of the first, the middle and the last variant, relative to the largest error of the
///   same kind
double largest_difference(const Settings& s, const fs::path& plan_file, const fs::path& study) {
  const study::StudyPlan plan = study::read_variant_plan(plan_file);
  const study::Design design = study::make_design(plan);
  const std::size_t count = design.variants.size();
  double largest = 0.0;
  for (const std::size_t variant : std::set<std::size_t>{0, count / 2, count - 1}) {
    const core::Table ours = table_of(study, variant), alone = campaign_of(s, plan, design.variants[variant].values);
    for (const char* column : {"dx_um", "dy_um", "dz_um", "ra_um_per_m", "rb_um_per_m", "rc_um_per_m"}) {
      const Eigen::VectorXd difference = ours.column(column) - alone.column(column);
      largest = std::max(largest, difference.cwiseAbs().maxCoeff() / alone.column(column).cwiseAbs().maxCoeff());
    }
  }
  if (largest > other_difference)
    throw core::SolverError(
        fmt::format("a variant differs from its own campaign by {:.1e} of the largest error", largest));
  return largest;
}

}  // namespace

std::string study_subject(const Settings& settings) {
  Report report("study, " + settings.size);
  const fs::path many = settings.work / "many.toml", one = settings.work / "one.toml",
                 out = settings.work / "study_out";
  write_plan(settings, many, settings.variants);
  write_plan(settings, one, 1);
  Command campaign;
  campaign.words = {settings.thermotwin.string(),
                    "campaign",
                    settings.case_path.string(),
                    "--load",
                    settings.study_load,
                    "--size",
                    settings.size,
                    "--out",
                    (settings.work / "study_campaign").string(),
                    "--quiet",
                    "--threads",
                    std::to_string(settings.threads)};
  std::vector<double> ratios;
  double difference = 0.0;
  for (int pair = 0; pair < settings.pairs; ++pair) {
    fs::remove_all(settings.work / "study_campaign");
    const Outcome separate = run(campaign), alone = study(settings, one, out), all = study(settings, many, out);
    if (pair == 0) difference = largest_difference(settings, many, out / "study/many");
    ratios.push_back(all.processor_seconds / separate.processor_seconds);
    report.figure(fmt::format("{} variants of '{}', processor time", settings.variants, settings.study_load),
                  duration(all.processor_seconds), settings.threads, all.peak_MiB);
    report.figure("a campaign of the same load", duration(separate.processor_seconds), settings.threads,
                  separate.peak_MiB);
    report.figure("a study of one variant", duration(alone.processor_seconds), settings.threads, alone.peak_MiB);
  }
  report.note(
      fmt::format("{} variants take the processor time of {:.1f} campaigns (median of {} pairs; aim: {} at most)",
                  settings.variants, median(ratios), ratios.size(), most_ratio));
  report.note(
      fmt::format("first, middle and last variant differ from campaigns of their own by {:.1e} of the largest "
                  "error at most (aim: {:.0e})",
                  difference, most_difference));
  return report.text();
}

}  // namespace thermotwin::bench
