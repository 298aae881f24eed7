// SPDX-License-Identifier: GPL-3.0-or-later
// The command line: parses, calls the verb, maps errors to exit status.

#include <CLI/CLI.hpp>

#include <algorithm>
#include <iostream>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include "core/error.h"
#include "core/process.h"
#include "core/text.h"
#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"

namespace {

using namespace thermotwin;

using AddVerb = void (*)(CLI::App&);
struct VerbGroup {
  const char* name;
  std::vector<AddVerb> verbs;
};

/// The verbs as `--help` lists them.
std::vector<VerbGroup> verb_groups() {
  using namespace tools;
  return {{"Machine", {add_mesh, add_export}},
          {"Compute", {add_simulate, add_campaign, add_reduce, add_run}},
          {"Measure", {add_evaluate, add_diagnose, add_validate}},
          {"Control", {add_compensate, add_offsets}}};
}

/// What is wrong with the command line, with the nearest known word for one that is unknown.
std::string usage_message(const CLI::App& app, const CLI::ParseError& error) {
  const auto verbs = app.get_subcommands();
  const CLI::App& at = verbs.empty() ? app : *verbs.front();
  const auto is_option = [](const std::string& word) { return word.size() > 1 && word.front() == '-'; };
  const std::vector<std::string> extras = at.remaining();
  if (const auto option = std::find_if(extras.begin(), extras.end(), is_option); option != extras.end()) {
    std::vector<std::string> known;
    for (const CLI::Option* of : at.get_options())
      for (const std::string& name : of->get_lnames()) known.push_back("--" + name);
    const std::string name = option->substr(0, option->find('='));
    return "unknown option '" + name + "' (nearest: " + core::nearest(name, known) + ")";
  }
  if (verbs.empty() && !extras.empty()) {
    std::vector<std::string> known;
    for (const CLI::App* verb : app.get_subcommands({})) known.push_back(verb->get_name());
    return "unknown verb '" + extras.front() + "'; one of: " + core::join(known) +
           " (nearest: " + core::nearest(extras.front(), known) + ")";
  }
  return error.what();
}

int parse_and_run(int argc, char** argv) {
  CLI::App app{"thermotwin: a thermal digital twin of machine tools, from CAD to a compensated TCP.", "thermotwin"};
  app.set_version_flag("--version", std::string("thermotwin ") + THERMOTWIN_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Exit status: 0 done; 2 wrong usage; 3 bad input; 4 the numerics failed; 130 interrupted.\nExample:\n  "
      "thermotwin run cases/vmc5 --out out\nthermotwin VERB --help describes a verb and its options.");

  app.formatter(tools::help_formatter());
  for (const VerbGroup& group : verb_groups()) {
    for (const AddVerb add : group.verbs) {
      add(app);
      app.get_subcommands({}).back()->group(group.name);
    }
  }

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::cerr << "thermotwin: " << usage_message(app, error) << "\n";
    const auto verbs = app.get_subcommands();
    std::cerr << "see: thermotwin " << (verbs.empty() ? "" : verbs.front()->get_name() + " ") << "--help\n";
    return 2;
  }
  return 0;
}

int status_of(int argc, char** argv) {
  try {
    return parse_and_run(argc, argv);
  } catch (const core::Error& error) {
    std::cerr << "thermotwin: " << error.what() << "\n";
    return error.exit_status();
  } catch (const std::bad_alloc&) {
    std::cerr << "thermotwin: not enough memory; a coarser --size needs less\n";
    return 4;
  } catch (const std::system_error& error) {
    const bool thread = error.code() == std::errc::resource_unavailable_try_again;
    std::cerr << "thermotwin: "
              << (thread ? "no thread can be started: not enough memory (ulimit -v) or too many processes (ulimit -u)"
                         : error.what())
              << "\n";
    return 4;
  } catch (const std::exception& error) {
    std::cerr << "thermotwin: " << error.what() << "\n";
    return 4;
  }
}

}  // namespace

int main(int argc, char** argv) { thermotwin::core::leave(status_of(argc, argv)); }
