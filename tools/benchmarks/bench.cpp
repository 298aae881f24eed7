// SPDX-License-Identifier: GPL-3.0-or-later
// tools/bench: which subjects to measure, and on what.

#include <CLI/CLI.hpp>

#include <iostream>
#include <thread>

#include "core/error.h"
#include "tools/benchmarks/subjects.h"

int main(int argc, char** argv) {
  using namespace thermotwin;
  CLI::App app{"Speed of thermotwin as ratios to named alternatives, measured in turn in one run", "tools/bench"};
  bench::Settings settings;
  std::vector<std::string> subjects;
  app.add_option("SUBJECT", subjects, "solver, reduction, compensate, online (absent: these four), study")
      ->check(CLI::IsMember({"solver", "reduction", "compensate", "online", "study"}));
  app.add_option("--case", settings.case_path, "case folder")->capture_default_str()->check(CLI::ExistingPath);
  app.add_option("--size", settings.size, "mesh: coarse, standard, fine, or a factor of the element sizes")
      ->capture_default_str();
  app.add_option("--body", settings.body, "body of the single-body comparisons")->capture_default_str();
  app.add_option("--model", settings.model, "model.rom.h5 (absent: made from the case)")->check(CLI::ExistingFile);
  app.add_option("--threads", settings.threads, "threads of whole-machine work (0: all)")->check(CLI::Range(0, 1024));
  app.add_option("--pairs", settings.pairs, "pairs of runs of each comparison")
      ->capture_default_str()
      ->check(CLI::Range(1, 100));
  app.add_option("--steps", settings.steps, "time steps of each run")
      ->capture_default_str()
      ->check(CLI::Range(20, 100000));
  app.add_option("--calculix-steps", settings.deck_steps, "time steps of CalculiX")
      ->capture_default_str()
      ->check(CLI::Range(1, 10000));
  app.add_option("--variants", settings.variants, "study: number of variants")
      ->capture_default_str()
      ->check(CLI::Range(2, 100000));
  app.add_option("--study-load", settings.study_load, "study: load program")->capture_default_str();
  app.add_flag("--body-only", settings.bodies_only, "solver: leave the whole machine out");
  app.add_option("--work", settings.work, "folder for meshes, models and rows");
  app.footer("Example:\n  tools/bench solver --size standard --pairs 3");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    namespace fs = std::filesystem;
    settings.programs = fs::absolute(argv[0]).parent_path();
    settings.thermotwin = settings.programs.parent_path() / "thermotwin";
    if (settings.work.empty()) settings.work = settings.programs / "work";
    settings.work = fs::absolute(settings.work);
    fs::create_directories(settings.work);
    settings.case_path = fs::absolute(settings.case_path);
    if (!settings.model.empty()) settings.model = fs::absolute(settings.model);
    if (settings.threads == 0) settings.threads = std::max(1U, std::thread::hardware_concurrency());
    if (subjects.empty()) subjects = {"solver", "reduction", "compensate", "online"};
    for (const std::string& subject : subjects) {
      std::cerr << "measuring: " << subject << std::endl;
      std::cout << (subject == "solver"      ? bench::solver_subject(settings)
                    : subject == "reduction" ? bench::reduction_subject(settings)
                    : subject == "online"    ? bench::online_subject(settings)
                    : subject == "study"     ? bench::study_subject(settings)
                                             : bench::compensate_subject(settings))
                << std::endl;
    }
  } catch (const core::Error& error) {
    std::cerr << "tools/bench: " << error.what() << "\n";
    return error.exit_status();
  } catch (const std::exception& error) {
    std::cerr << "tools/bench: " << error.what() << "\n";
    return 4;
  }
  return 0;
}
