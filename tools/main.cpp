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
          {"Measure", {add_measure, add_evaluate, add_diagnose, add_validate}},
          {"Studies", {add_study}},
          {"Control", {add_compensate, add_serve, add_nc, add_offsets}}};
}

/// The verb that was given, inside of its group: "measure uncertainty"; empty: none.
struct GivenVerb {
  const CLI::App* app;
  std::string words;
};
GivenVerb given_verb(const CLI::App& app) {
  GivenVerb given{&app, ""};
  for (auto inside = app.get_subcommands(); !inside.empty(); inside = given.app->get_subcommands()) {
    given.app = inside.front();
    given.words += given.app->get_name() + " ";
  }
  return given;
}

/// What is wrong with the command line, with the nearest known word for one that is unknown.
std::string usage_message(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App& at = *given_verb(app).app;
  const auto is_option = [](const std::string& word) { return word.size() > 1 && word.front() == '-'; };
  const std::vector<std::string> extras = at.remaining();
  if (const auto option = std::find_if(extras.begin(), extras.end(), is_option); option != extras.end()) {
    std::vector<std::string> known;
    for (const CLI::Option* of : at.get_options())
      for (const std::string& name : of->get_lnames()) known.push_back("--" + name);
    const std::string name = option->substr(0, option->find('='));
    return "unknown option '" + name + "' (nearest: " + core::nearest(name, known) + ")";
  }
  if (!at.get_subcommands({}).empty() && !extras.empty()) {
    std::vector<std::string> known;
    for (const CLI::App* verb : at.get_subcommands({})) known.push_back(verb->get_name());
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
    const bool unknown_verb = given_verb(app).app == &app && !app.remaining().empty();  // beside --help too
    if (error.get_exit_code() == 0 && !unknown_verb) return app.exit(error);
    std::cerr << "thermotwin: " << usage_message(app, error) << "\n";
    std::cerr << "see: thermotwin " << given_verb(app).words << "--help\n";
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
