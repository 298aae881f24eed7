// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"
#include "tools/options.h"

namespace thermotwin::tools {

void add_campaign(CLI::App& app) {
  const auto options = std::make_shared<CampaignOptions>();
  CampaignOptions& campaign = *options;
  CLI::App* verb = add_verb(app, "campaign",
                            "load programs on the full model, or on the reduced one, the TCP error at all poses: "
                            "tcp.csv, sensors.csv and heat.csv (heat flows, W) per load",
                            "thermotwin campaign cases/vmc5 --resume\n"
                            "  thermotwin campaign cases/vmc5 --reduced --model out/model.rom.h5 --out fast",
                            options, &tools::campaign);
  verb->add_option("CASE", campaign.case_path, "case folder or case.toml")->required();
  verb->add_option("--load", campaign.loads, "only these load programs (absent: train and holdout of the case)");
  auto* resume =
      verb->add_flag("--resume", campaign.resume, "keep loads that are finished, go on with one that was stopped");
  auto* reduced = verb->add_flag("--reduced", campaign.reduced,
                                 "by the reduced model; with its reference, error_estimate.csv per load too")
                      ->excludes(resume);
  verb->add_option("--model", campaign.model, "of --reduced: model.rom.h5 (absent: that of --out)")->needs(reduced);
  verb->add_flag("--exact", campaign.exact,
                 "of --reduced: steps without time error where films, contacts and flows stand (those that follow "
                 "the temperature never do); "
                 "absent: the full model's time scheme, to compare with it")
      ->needs(reduced);
  verb->add_option("--reference", campaign.reference,
                   "of --reduced: model of larger order that estimates the error "
                   "(absent: reference.rom.h5 beside the model, if it is there)")
      ->needs(reduced);
  verb->add_flag("--bound", campaign.bound,
                 "of --reduced: error_bound.csv per load too, what the error cannot exceed at the poses of "
                 "bound.rom.h5 beside the model (thermotwin reduce --bound)")
      ->needs(reduced);
  add_checkpoint_option(*verb, campaign.checkpoint_every_s);
  add_mesh_options(*verb, campaign.size, campaign.mesh_order);
  add_solver_option(*verb, campaign.solver);
  for (const char* of_full : {"--size", "--mesh-order", "--order", "--solver", "--checkpoint-every"})
    if (CLI::Option* option = verb->get_option_no_throw(of_full)) reduced->excludes(option);
}

}  // namespace thermotwin::tools
