// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"
#include "tools/options.h"

namespace thermotwin::tools {

void add_full_campaign_options(CLI::App& verb, CampaignOptions& campaign) {
  verb.add_option("CASE", campaign.case_path, "Case folder or case.toml.")->required();
  verb.add_option("--load", campaign.loads, "Load programs to run (default: train and holdout of the case).");
  add_checkpoint_option(verb, campaign.checkpoint_every_s);
  add_mesh_options(verb, campaign.size, campaign.mesh_order);
  add_solver_option(verb, campaign.solver);
}

void add_campaign(CLI::App& app) {
  const auto options = std::make_shared<CampaignOptions>();
  CampaignOptions& campaign = *options;
  CLI::App* verb = add_verb(
      app, "campaign",
      "Runs load programs at all poses of the workspace and writes tcp.csv, sensors.csv and heat.csv for each.",
      "thermotwin campaign cases/vmc5 --resume\n"
      "  thermotwin campaign cases/vmc5 --reduced --model out/model.rom.h5 --out fast",
      options, &tools::campaign);
  add_full_campaign_options(*verb, campaign);
  auto* resume = verb->add_flag("--resume", campaign.resume, "Keep finished loads and continue an interrupted one.");
  auto* reduced = verb->add_flag("--reduced", campaign.reduced,
                                 "Use the reduced model and write to campaign_reduced/ in --out, without heat.csv.")
                      ->excludes(resume);
  verb->add_option("--model", campaign.model, "With --reduced: the reduced model (default: model.rom.h5 in --out).")
      ->needs(reduced);
  verb->add_flag("--exact", campaign.exact,
                 "With --reduced: steps without time error while films, contacts and flows are constant (default: time "
                 "scheme of the full model).")
      ->needs(reduced);
  verb->add_option("--reference", campaign.reference,
                   "With --reduced: model of larger order for error_estimate.csv (default: reference.rom.h5 beside the "
                   "model, if present).")
      ->needs(reduced);
  verb->add_flag("--bound", campaign.bound,
                 "With --reduced: write error_bound.csv, the guaranteed error bound at the poses of bound.rom.h5 "
                 "beside the model (see `reduce --bound`).")
      ->needs(reduced);
  auto* tilts = verb->add_flag("--all-tilts", campaign.all_tilts,
                               "With --reduced: the workspace grid at each position of the table's axes, not only at "
                               "their home.")
                    ->needs(reduced);
  verb->add_option("--pose", campaign.poses,
                   "With --reduced: a pose, e.g. X=0,Y=0,Z=275,B=45; may be repeated (default: the workspace grid).")
      ->needs(reduced)
      ->excludes(tilts);
  for (const char* of_full : {"--size", "--mesh-order", "--order", "--solver", "--checkpoint-every"})
    if (CLI::Option* option = verb->get_option_no_throw(of_full)) reduced->excludes(option);
}

}  // namespace thermotwin::tools
