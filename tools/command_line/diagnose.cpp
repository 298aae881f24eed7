// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <optional>

#include "diagnosis/record/diagnose_options.h"
#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"
#include "tools/options.h"

namespace thermotwin::tools {

void add_diagnose(CLI::App& app) {
  const auto options = std::make_shared<DiagnoseOptions>();
  DiagnoseOptions& diagnose = *options;
  CLI::App* verb =
      add_verb(app, "diagnose", "what the simulation gets wrong in a measurement, why, the extended model, the gain",
               "thermotwin diagnose cases/vmc5 --data measurement --model out/model.rom.h5", options, &tools::diagnose);
  verb->add_option(
      "CASE", diagnose.case_path,
      "case folder (absent, and no --model: data without a machine, against a lag model of its first day)");
  verb->add_option("--data", diagnose.data, "measurement folder")->required();
  verb->add_option("--model", diagnose.model, "model.rom.h5 (absent: made from the case)");
  verb->add_option("--accept", diagnose.accept,
                   "new folder: a copy of the case with the extended machine, diagnosed again, with its gain in "
                   "compensation");
  const auto add_error = [&](const std::string& name, std::optional<double>& percent, double otherwise,
                             const std::string& of) {
    verb->add_option(name, percent,
                     "percent of each " + of +
                         "'s own response by which mesh and time steps may be off; where a study of the mesh shows "
                         "less, more is seen")
        ->check(CLI::Range(0.1, 50.0))
        ->default_str(fmt::format("{}", otherwise));
  };
  add_error("--displacement-error", diagnose.displacement_error_percent,
            diagnosis::DiagnoseOptions{}.displacement_error_percent, "displacement");
  add_error("--temperature-error", diagnose.temperature_error_percent,
            diagnosis::DiagnoseOptions{}.temperature_error_percent, "temperature");
}

}  // namespace thermotwin::tools
