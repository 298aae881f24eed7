// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"
#include "tools/options.h"

namespace thermotwin::tools {

void add_evaluate(CLI::App& app) {
  const auto options = std::make_shared<EvaluateOptions>();
  EvaluateOptions& evaluate = *options;
  CLI::App* verb = add_verb(
      app, "evaluate", "every compensation model on the same measurement, fitted on its beginning, judged on the rest",
      "thermotwin evaluate --data measured_drift\n"
      "  thermotwin evaluate cases/vmc5 --data measurement --model out/model.rom.h5 --check dx@2,dy@2,dz@2\n"
      "  thermotwin evaluate --data other_machine --fitted out/evaluation/models.toml --train-until 2",
      options, &tools::evaluate);
  verb->add_option("CASE", evaluate.case_path, "case folder (absent: no machine model)");
  verb->add_option("--data", evaluate.data, "measurement folder")->required();
  verb->add_option("--also", evaluate.also, "further folders with the same channels, none of which a fit sees: A,B")
      ->delimiter(',');
  auto* train_data =
      verb->add_option(
              "--train-data", evaluate.train_data,
              "further folders that fitted models see whole; --data then trains only by one of the next two: A,B")
          ->delimiter(',');
  verb->add_option("--model", evaluate.model, "model.rom.h5 (absent: made from the case)");
  auto* extended = verb->add_option("--extended", evaluate.extended,
                                    "diagnosis/extended/model.rom.h5, judged beside the nominal model");
  auto* until =
      verb->add_option("--train-until", evaluate.train_until_h,
                       "hours from the first row that fitted models may see (absent: 24, of a record below 30 h half)")
          ->check(CLI::PositiveNumber);
  verb->add_option("--train-programs", evaluate.train_programs,
                   "programs of channels.toml that fitted models may see instead: A,B")
      ->delimiter(',')
      ->excludes(until);
  verb->add_option("--models", evaluate.models,
                   "only these fitted models: static_regression,grey_box,... (absent: all)")
      ->delimiter(',');
  verb->add_option("--check", evaluate.check,
                   "displacement channels that no fit may use, predicted over the workspace: dx@2,dy@2")
      ->delimiter(',');
  verb->add_option("--fitted", evaluate.fitted,
                   "models.toml of another machine of the type: as it is, and with one factor a channel")
      ->excludes(extended)
      ->excludes(train_data);
  verb->add_flag("--cross", evaluate.cross, "fit on each program (or day), judge on all the others")
      ->excludes(train_data);
  verb->add_option("--length-study", evaluate.length_study,
                   "MODEL CHANNEL: how long a measurement the model needs, as box plots")
      ->expected(2);
}

}  // namespace thermotwin::tools
