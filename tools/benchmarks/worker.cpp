// SPDX-License-Identifier: GPL-3.0-or-later
// What is measured of thermotwin itself: one piece of work a process, so that its peak memory is its
// own. Prints lines "name value"; times in seconds.

#include <CLI/CLI.hpp>

#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "core/progress.h"
#include "core/thread_pool.h"
#include "tools/benchmarks/body_work.h"
#include "tools/benchmarks/machine_work.h"
#include "tools/benchmarks/online_work.h"

using namespace thermotwin;

int main(int argc, char** argv) {
  CLI::App app{"one piece of work of thermotwin, timed; started by tools/bench"};
  app.require_subcommand(1);
  bench::Options options;
  const std::vector<std::pair<std::string, void (*)(const bench::Options&)>> works = {
      {"files", bench::write_files},   {"heat", bench::heat},   {"memory", bench::memory},  {"elastic", bench::elastic},
      {"iterative", bench::iterative}, {"loads", bench::loads}, {"poses", bench::poses},    {"steps", bench::steps},
      {"online", bench::online},       {"rows", bench::rows},   {"control", bench::control}};
  for (const auto& [name, work] : works) {
    CLI::App* verb = app.add_subcommand(name);
    verb->add_option("--case", options.case_path);
    verb->add_option("--size", options.size);
    verb->add_option("--body", options.body);
    verb->add_option("--set", options.set);
    verb->add_option("--load", options.load);
    verb->add_option("--folder", options.folder);
    verb->add_option("--model", options.model);
    verb->add_option("--out", options.out);
    verb->add_option("--steps", options.steps);
    verb->add_option("--threads", options.threads);
    verb->add_option("--columns", options.columns);
    verb->add_option("--order", options.order);
    verb->add_option("--deck-steps", options.decks);
    verb->add_option("--rows", options.rows);
    verb->add_flag("--apart", options.apart);
    verb->add_flag("--wall", options.wall);
    verb->add_flag("--cold", options.cold);
    verb->callback([&options, work = work] {
      core::set_quiet(true);
      core::set_thread_count(options.threads);
      work(options);
    });
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 4;
  }
  return 0;
}
