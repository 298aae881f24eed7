// SPDX-License-Identifier: GPL-3.0-or-later
// The online core in C99, row by row, against the C++ compensator without sensors.
#include <fmt/format.h>

#include "tools/benchmarks/report.h"
#include "tools/benchmarks/subjects.h"

namespace thermotwin::bench {

std::string online_subject(const Settings& settings) {
  Report report("online");
  constexpr long count = 1000000;
  const Outcome made = run({{(settings.programs / "bench_worker").string(), "control", "--model",
                             model_of(settings).string(), "--rows", std::to_string(count)},
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
  return report.text();
}

}  // namespace thermotwin::bench
