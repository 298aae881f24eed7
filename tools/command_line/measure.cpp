// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/measure/measure.h"

#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"

namespace thermotwin::tools {

void add_measure(CLI::App& app) {
  const auto options = std::make_shared<MeasureOptions>();
  MeasureOptions& measured = *options;
  CLI::App* group = app.add_subcommand("measure", "Measures location errors and states their uncertainty.");
  add_common_options(*group, measured);  // shared with the verbs below, wherever they stand
  group->require_subcommand(1);
  group->footer("Example:\n  thermotwin measure uncertainty cases/budgets/jcgm100_h2.toml\nthermotwin measure VERB --help "
                "describes a verb and its options.");

  CLI::App* uncertainty =
      add_verb(*group, "uncertainty", "Propagates an uncertainty budget by the law of JCGM 100 and by Monte Carlo.",
               "thermotwin measure uncertainty cases/budgets/rtest_probe.toml", options, &tools::measure_uncertainty);
  uncertainty->add_option("BUDGET", measured.file, "Budget: inputs, correlations and formulas of measurands.")
      ->required();
}

}  // namespace thermotwin::tools
