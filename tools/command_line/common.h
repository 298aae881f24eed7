// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Options that several verbs share, and how a verb comes to the command line.

#include <CLI/CLI.hpp>

#include <memory>
#include <string>
#include <vector>

#include "core/process.h"
#include "core/progress.h"
#include "core/thread_pool.h"
#include "tools/options.h"

namespace thermotwin::tools {

/// Descriptions are broken at 100 columns; a verb is called a verb.
std::shared_ptr<CLI::Formatter> help_formatter();

void add_common_options(CLI::App& verb, CommonOptions& options);
/// The common options of a group of verbs: given before the verb's name, they count unless the verb has its own.
/// @param verbs  the options of all verbs of the group
void share_common_options(CLI::App& group, const std::vector<std::shared_ptr<CommonOptions>>& verbs);
/// `reduce` has an --order of its own.
void add_mesh_options(CLI::App& verb, std::string& size, int& order,
                      const std::string& order_name = "--mesh-order,--order");
void add_checkpoint_option(CLI::App& verb, double& every_s);
void add_solver_option(CLI::App& verb, std::string& solver);
/// Of `campaign` on the full model.
void add_full_campaign_options(CLI::App& verb, CampaignOptions& campaign);
void add_validate_options(CLI::App& verb, ValidateOptions& validate);

/// Of a seed: CLI11 takes a negative or too large number for another one.
CLI::Range seeds();

/// CLI11's own name the largest double by all its 309 digits.
CLI::Validator positive_number();
/// Of a machine, degC: -50 to 100.
CLI::Validator start_temperature();
CLI::Validator non_negative_number();

/// CLI11's ranges let nan pass. @throws InputError for an option of numbers that is none
void require_numbers(const CLI::App& verb);

/// @param options  live as long as the command line @param verb  called when this verb was given
template <class Options>
CLI::App* add_verb(CLI::App& app, const std::string& name, const std::string& text, const std::string& example,
                   const std::shared_ptr<Options>& options, void (*verb)(const Options&)) {
  CLI::App* command = app.add_subcommand(name, text);
  add_common_options(*command, *options);
  command->footer("Example:\n  " + example);
  command->callback([command, options, verb] {
    require_numbers(*command);
    core::set_quiet(options->quiet);
    core::set_thread_count(options->threads);
    core::install_interrupt_handler();
    core::install_memory_handler();
    verb(*options);
  });
  return command;
}

}  // namespace thermotwin::tools
