// SPDX-License-Identifier: GPL-3.0-or-later
// Processor time of variants of powers and films in one study, of one of them alone, and of a campaign of their load.
#include <fmt/format.h>

#include "core/file.h"
#include "tools/benchmarks/report.h"
#include "tools/benchmarks/subjects.h"

namespace thermotwin::bench {
namespace {

namespace fs = std::filesystem;

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
  for (int pair = 0; pair < settings.pairs; ++pair) {
    fs::remove_all(settings.work / "study_campaign");
    const Outcome separate = run(campaign), alone = study(settings, one, out), all = study(settings, many, out);
    ratios.push_back(all.processor_seconds / separate.processor_seconds);
    report.figure(fmt::format("{} variants of '{}', processor time", settings.variants, settings.study_load),
                  duration(all.processor_seconds), settings.threads, all.peak_MiB);
    report.figure("a campaign of the same load", duration(separate.processor_seconds), settings.threads,
                  separate.peak_MiB);
    report.figure("a study of one variant", duration(alone.processor_seconds), settings.threads, alone.peak_MiB);
  }
  report.note(fmt::format("{} variants take the processor time of {:.1f} campaigns (median of {} pairs)",
                          settings.variants, median(ratios), ratios.size()));
  return report.text();
}

}  // namespace thermotwin::bench
