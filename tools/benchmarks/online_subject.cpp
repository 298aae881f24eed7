// SPDX-License-Identifier: GPL-3.0-or-later
// The online core in C99, row by row, against the C++ compensator without sensors; a start with online data beside one
// without.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <tuple>
#include <vector>

#include "tools/benchmarks/report.h"
#include "tools/benchmarks/subjects.h"

namespace thermotwin::bench {

namespace {

namespace fs = std::filesystem;

/// A figure beside its aim.
std::string judged(const std::string& what, double value, double aim, const std::string& unit) {
  return fmt::format("aim: {} {:.3g} {}, at most {:g} {}: {}", what, value, unit, aim, unit,
                     value <= aim ? "reached" : "MISSED");
}

/// Starts of `compensate` to the answer of one row and to its end.
class Starts {
public:
  explicit Starts(const Settings& settings)
      : folder_(settings.work / "start"),
        model_(folder_ / "model.rom.h5"),
        online_(folder_ / "model.online") {
    fs::create_directories(folder_);
    fs::copy_file(model_of(settings), model_, fs::copy_options::overwrite_existing);
    std::ofstream(folder_ / "row.csv") << "time_s,spindle.speed_rpm\n0,0\n";
    command_.words = {settings.thermotwin.string(),
                      "compensate",
                      model_.string(),
                      "--quiet",
                      "--out",
                      (folder_ / "offsets.csv").string(),
                      "--in",
                      (folder_ / "row.csv").string()};
  }
  ~Starts() {
    std::error_code none;
    fs::remove_all(folder_, none);
  }
  Starts(const Starts&) = delete;
  Starts& operator=(const Starts&) = delete;

  void add_to(Report& report, int pairs) {
    std::vector<Outcome> with, without;
    run(command_);  // so that the files are in memory
    for (int i = 0; i < std::max(pairs, 1); ++i) {
      fs::remove(online_);
      without.push_back(run(command_));  // and writes online data
      with.push_back(run(command_));
    }
    for (const auto& [unit, what] : {std::pair{"processor", "processor time"}, {"wall", "wall time"}}) {
      report.compare(std::string("start with online data to the first row, ") + what, each(with, unit),
                     each(without, unit), "reading the model", 1, median(each(with, "MiB")),
                     median(each(without, "MiB")));
    }
    report.note(
        judged("start with online data to the first row, processor time", median(each(with, "processor")), 0.3, "s"));
    report.note(judged("peak memory of compensate", median(each(with, "MiB")), 64.0, "MiB"));
    report.note(judged("online data", 1e-6 * fs::file_size(online_), 16.0, "MB"));
    report.note(fmt::format("online data: {:.1f} MB beside a model of {:.1f} MB", 1e-6 * fs::file_size(online_),
                            1e-6 * fs::file_size(model_)));
  }

private:
  fs::path folder_, model_, online_;
  Command command_;
};

void add_aims(Report& report, const Outcome& made, const Outcome& live) {
  for (const auto& [word, what, aim_us] : {std::tuple{"9999", "99.99 % of rows", 200.0}, {"most", "largest", 1000.0}}) {
    report.note(
        judged(fmt::format("row, {}, processor time", what), 1e6 * made[fmt::format("core_{}", word)], aim_us, "us"));
    report.note(judged(fmt::format("row, {}, in real time, processor time", what),
                       1e6 * live[fmt::format("live_{}", word)], aim_us, "us"));
    report.note(fmt::format("the same, wall time: {}; in real time: {}",
                            duration(made[fmt::format("core_wall_{}", word)]),
                            duration(live[fmt::format("live_wall_{}", word)])));
  }
}

}  // namespace

std::string online_subject(const Settings& settings) {
  Report report("online");
  Starts(settings).add_to(report, settings.pairs);
  constexpr long count = 1000000;
  const Outcome made = run({{(settings.programs / "bench_worker").string(), "control", "--model",
                             model_of(settings).string(), "--rows", std::to_string(count)},
                            1,
                            {},
                            {},
                            {},
                            {}});
  constexpr long live_count = 10000;
  const Outcome live = run({{(settings.programs / "bench_worker").string(), "control", "--wall", "--model",
                             model_of(settings).string(), "--rows", std::to_string(live_count)},
                            1,
                            {},
                            {},
                            {},
                            {}});
  for (const auto& [word, what] :
       {std::pair{"median", "median"}, {"999", "99.9 %"}, {"9999", "99.99 %"}, {"most", "largest"}}) {
    report.compare(fmt::format("row at 10 Hz, {}, its processor time", what), {made[fmt::format("core_{}", word)]},
                   {made[fmt::format("classes_{}", word)]}, "C++ compensator, 100000 rows", 1);
    report.figure("the same, wall time", duration(made[fmt::format("core_wall_{}", word)]), 1);
    report.figure("the same, lower processor time of two runs of each row",
                  duration(made[fmt::format("core_lower_{}", word)]), 1);
    report.figure("the same with steps of 10 s", duration(made[fmt::format("short_lower_{}", word)]), 1);
  }
  report.figure("model data from model.rom.h5", duration(made["build"]), 1);
  report.figure("start of a twin", duration(made["start"]), 1);
  report.figure("first row where it does the work of the start", duration(made["first_row"]), 1);
  report.note(fmt::format("order {}: data {:.1f} MB, state {:.0f} kB, work {:.1f} MB; {} rows", made["order"],
                          made["data_MB"], made["state_kB"], made["work_MB"], count));
  report.note(
      fmt::format("rows 60 s apart over 10 h: offsets differ by at most {:.2g} um of {:.1f} um, their "
                  "deviations by {:.2g} um",
                  made["apart_um"], made["most_um"], made["std_apart_um"]));
  add_aims(report, made, live);
  return report.text();
}

}  // namespace thermotwin::bench
