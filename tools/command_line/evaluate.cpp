// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"
#include "tools/options.h"

namespace thermotwin::tools {

void add_evaluate(CLI::App& app) {
  const auto options = std::make_shared<EvaluateOptions>();
  EvaluateOptions& evaluate = *options;
  CLI::App* verb = add_verb(
      app, "evaluate", "Fits every compensation model to the first part of a measurement and judges it on the rest.",
      "thermotwin evaluate --data measured_drift\n"
      "  thermotwin evaluate cases/vmc5 --data measurement --model out/model.rom.h5 --check dx@2,dy@2,dz@2\n"
      "  thermotwin evaluate --data other_machine --fitted out/evaluation/models.toml --train-until 2",
      options, &tools::evaluate);
  verb->add_option("CASE", evaluate.case_path, "Case folder (default: no machine model).");
  verb->add_option("--data", evaluate.data, "Measurement folder.")->required();
  verb->add_option("--also", evaluate.also,
                   "Further measurement folders with the same channels, used for judging only: A,B.")
      ->delimiter(',');
  auto* train_data = verb->add_option("--train-data", evaluate.train_data,
                                      "Further measurement folders that train as a whole, A,B; --data then trains only "
                                      "with --train-until or --train-programs.")
                         ->delimiter(',');
  verb->add_option("--model", evaluate.model, "Reduced model model.rom.h5 (default: made from the case).");
  auto* extended = verb->add_option("--extended", evaluate.extended,
                                    "Extended model diagnosis/extended/model.rom.h5, judged beside the nominal one.");
  auto* until = verb->add_option("--train-until", evaluate.train_until_h,
                                 "Training time from the first row, h (default: 24, or half of a record below 30 h).")
                    ->check(positive_number());
  verb->add_option("--train-programs", evaluate.train_programs,
                   "Programs of channels.toml that train, instead of --train-until: A,B.")
      ->delimiter(',')
      ->excludes(until);
  verb->add_option("--models", evaluate.models, "Models to fit, e.g. static_regression,grey_box (default: all).")
      ->delimiter(',');
  verb->add_option("--check", evaluate.check,
                   "Displacement channels that no fit uses and that are predicted over the workspace, e.g. dx@2,dy@2.")
      ->delimiter(',');
  verb->add_option("--fitted", evaluate.fitted,
                   "models.toml of another machine of the same type, judged unchanged and with one correction factor "
                   "per channel.")
      ->excludes(extended)
      ->excludes(train_data);
  verb->add_flag("--cross", evaluate.cross, "Fit on each program or day and judge on all the others.")
      ->excludes(train_data);
  verb->add_option("--length-study", evaluate.length_study,
                   "MODEL CHANNEL: residual over the length of the training data, as box plots.")
      ->expected(2);
}

}  // namespace thermotwin::tools
