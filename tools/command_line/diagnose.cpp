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
      add_verb(app, "diagnose",
               "Compares a measurement with the model, names the cause of a discrepancy, and extends the model.",
               "thermotwin diagnose cases/vmc5 --data measurement --model out/model.rom.h5", options, &tools::diagnose);
  verb->add_option(
      "CASE", diagnose.case_path,
      "Case folder (default: that of --model; without both, a lag model of the first part of the record).");
  verb->add_option("--data", diagnose.data,
                   "Measurement folder. Given again: more records of the machine; the same cause has to hold for all.")
      ->required()
      ->allow_extra_args(false);
  verb->add_option("--model", diagnose.model, "Reduced model model.rom.h5 (default: made from the case).");
  verb->add_option(
      "--accept", diagnose.accept,
      "New folder for a copy of the case with the extended machine; prints the diagnosis of the same record "
      "with it, and its gain in compensation on this record.");
  const auto add_error = [&](const std::string& name, std::optional<double>& percent, double otherwise,
                             const std::string& of) {
    verb->add_option(
            name, percent,
            fmt::format("Discretisation error, percent of the predicted change of each {} (default: the estimate of "
                        "`reduce` from a second mesh, or {} where the model file has none).",
                        of, otherwise))
        ->check(CLI::Range(0.1, 50.0));
  };
  add_error("--displacement-error", diagnose.displacement_error_percent, diagnosis::assumed_displacement_error_percent,
            "displacement");
  add_error("--temperature-error", diagnose.temperature_error_percent, diagnosis::assumed_temperature_error_percent,
            "temperature");
}

}  // namespace thermotwin::tools
