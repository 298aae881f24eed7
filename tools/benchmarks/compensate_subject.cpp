// SPDX-License-Identifier: GPL-3.0-or-later
// The compensator as a stream: rows a second and memory, against a static regression in the same
// stream and against awk copying as many columns.
#include <fmt/format.h>

#include "tools/benchmarks/report.h"
#include "tools/benchmarks/subjects.h"

namespace thermotwin::bench {

std::string compensate_subject(const Settings& settings) {
  Report report("compensate");
  const std::filesystem::path model = model_of(settings), out = settings.work / "offsets.csv";
  const auto at = [&](Command command, const std::filesystem::path& rows) {
    command.input = rows;
    command.cores = 1;
    return command;
  };
  for (const long count : {100000L, 1000000L}) {
    const auto rows = settings.work / fmt::format("rows_{}.csv", count);
    const Outcome made = run({{(settings.programs / "bench_worker").string(), "rows", "--model", model.string(),
                               "--rows", std::to_string(count), "--out", rows.string()},
                              0,
                              {},
                              {},
                              {},
                              {}});
    Command ours, regression, awk, control;
    ours.words = {settings.thermotwin.string(),
                  "compensate",
                  model.string(),
                  "--in",
                  rows.string(),
                  "--out",
                  out.string(),
                  "--quiet"};
    ours.cores = 1;
    control.words = {settings.thermotwin.string(), "compensate", model.string(), "--out", "-", "--quiet"};
    control.output = settings.work / "control.csv";
    regression.words = {(settings.programs / "bench_regression").string()};
    regression.output = settings.work / "regression.csv";
    awk.words = {"awk", "-F,", "-v", "OFS=,", "{print $1,$2,$3,$4,$5,$6,$7,$8}"};
    awk.output = settings.work / "awk.csv";
    const int pairs = count > 100000 ? std::min(settings.pairs, 3) : settings.pairs;
    const Pairs against_regression = in_turn(pairs, ours, at(regression, rows)),
                against_awk = in_turn(pairs, ours, at(awk, rows)), row_by_row = in_turn(pairs, ours, at(control, rows));
    const double seconds = median(each(against_regression.ours, "processor")),
                 MiB = median(each(against_regression.ours, "MiB"));
    report.compare(fmt::format("{} rows, file to file", count), each(against_regression.ours, "processor"),
                   each(against_regression.other, "processor"), "static regression", 1, MiB,
                   median(each(against_regression.other, "MiB")));
    report.compare(fmt::format("{} rows, file to file", count), each(against_awk.ours, "processor"),
                   each(against_awk.other, "processor"), "awk copying 8 columns", 1, MiB,
                   median(each(against_awk.other, "MiB")));
    report.compare(fmt::format("{} rows, file to file", count), each(row_by_row.ours, "processor"),
                   each(row_by_row.other, "processor"), "ours, each row flushed", 1, MiB,
                   median(each(row_by_row.other, "MiB")));
    report.note(fmt::format("{} rows, one a second: {:.0f} rows/s, {:.1f} us a row, order {}; one processor, its time",
                            count, count / seconds, 1e6 * seconds / count, made["order"]));
    std::filesystem::remove(rows);
    for (const auto& file : {out, control.output, regression.output, awk.output}) std::filesystem::remove(file);
  }
  return report.text();
}

}  // namespace thermotwin::bench
