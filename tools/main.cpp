// SPDX-License-Identifier: GPL-3.0-or-later
// The command line: parses, sets threads and quiet, calls the verb, maps errors to exit status.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <new>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/progress.h"
#include "core/text.h"
#include "core/thread_pool.h"
#include "tools/options.h"

namespace {

using namespace thermotwin;

void add_common(CLI::App& verb, tools::CommonOptions& options) {
  verb.add_option("--out", options.out, "folder for results")->capture_default_str();
  verb.add_option("--threads", options.threads, "threads (0: all cores); results do not depend on it")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  verb.add_flag("--quiet", options.quiet, "no progress on stderr");
  verb.add_flag("--json", options.json, "summary as one JSON object on stdout");
}

/// `reduce` has an --order of its own.
void add_mesh(CLI::App& verb, std::string& size, int& order, const std::string& order_name = "--mesh-order,--order") {
  verb.add_option("--size", size, "mesh: coarse, standard, fine, or a factor of the element sizes");
  verb.add_option(order_name, order, "tetrahedra: 1 linear, 2 quadratic (absent: as machine.toml says)")
      ->check(CLI::Range(1, 2));
}

void add_checkpoint(CLI::App& verb, double& every_s) {
  verb.add_option("--checkpoint-every", every_s, "seconds of computing between checkpoints")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
}

void add_solver(CLI::App& verb, std::string& solver) {
  verb.add_option("--solver", solver, "linear solver: direct while its factors fit into memory (auto), direct, iterative")
      ->check(CLI::IsMember({"auto", "direct", "iterative"}))
      ->capture_default_str();
}

template <class Options>
CLI::App* add_verb(CLI::App& app, const std::string& name, const std::string& text,
                   const std::string& example, Options& options, void (*verb)(const Options&)) {
  CLI::App* command = app.add_subcommand(name, text);
  add_common(*command, options);
  command->footer("Example:\n  " + example);
  command->callback([&options, verb] {
    core::set_quiet(options.quiet);
    core::set_thread_count(options.threads);
    core::install_interrupt_handler();
    verb(options);
  });
  return command;
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
    return "unknown verb '" + extras.front() + "'; one of: " + core::join(known) + " (nearest: " +
           core::nearest(extras.front(), known) + ")";
  }
  return error.what();
}

int parse_and_run(int argc, char** argv) {
  CLI::App app{"thermotwin: a thermal digital twin of machine tools, from CAD to a compensated TCP",
               "thermotwin"};
  app.set_version_flag("--version", std::string("thermotwin ") + THERMOTWIN_VERSION);
  app.require_subcommand(1);
  app.footer("Exit status: 0 done; 2 wrong usage; 3 bad input; 4 the numerics failed; 130 interrupted.\n"
             "thermotwin VERB --help tells more.");

  tools::RunOptions run;
  CLI::App* verb = add_verb(app, "run", "the whole chain of a case: mesh, campaign, reduced model, "
                            "compensation of an unseen program, diagnosis of a measurement",
                            "thermotwin run cases/vmc5 --out out", run, &tools::run);
  verb->add_option("CASE", run.case_path, "case folder or case.toml")->required();
  add_mesh(*verb, run.size, run.mesh_order);
  add_solver(*verb, run.solver);
  verb->add_flag("--resume", run.resume, "go on where a stopped run with the same inputs ended");

  tools::MeshOptions mesh;
  verb = add_verb(app, "mesh", "builds and checks the mesh; quality table; .vtu",
                  "thermotwin mesh cases/vmc5/machine.toml --size standard", mesh, &tools::mesh_machine);
  verb->add_option("MACHINE", mesh.machine, "machine.toml, or the folder that holds it")->required();
  add_mesh(*verb, mesh.size, mesh.mesh_order);

  tools::SimulateOptions simulate;
  verb = add_verb(app, "simulate", "one load on the full model: fields.pvd, sensors.csv, tcp.csv",
                  "thermotwin simulate cases/vmc5 --load spindle_6000 --pose X=0,Y=0,Z=275", simulate,
                  &tools::simulate);
  verb->add_option("CASE", simulate.case_path, "case folder or case.toml")->required();
  verb->add_option("--load", simulate.load, "load program (name of a file in loads/)")->required();
  verb->add_option("--pose", simulate.pose, "axis positions, mm and deg: X=0,Y=0,Z=275,B=45 (absent: home)");
  verb->add_option("--fields-every", simulate.fields_every_s, "seconds between fields in fields.pvd")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  verb->add_option("--output-times", simulate.output_times, "results at these times only, s: 0,600,3600; the run ends with the last")
      ->delimiter(',')
      ->check(CLI::NonNegativeNumber);
  auto* from = verb->add_option("--start-from", simulate.start_from, "start with the temperatures of a fields .vtu, of any mesh of the machine");
  auto* sensors = verb->add_option("--start-from-sensors", simulate.start_from_sensors,
                                   "start with the smoothest field that agrees with a table of <sensor>_C (sensors.csv)");
  from->excludes(sensors);
  verb->add_option("--start-time", simulate.start_time_s, "time in that table, s (absent: its first row)")
      ->needs(sensors)
      ->check(CLI::NonNegativeNumber);
  verb->add_flag("--resume", simulate.resume, "go on from the checkpoint of a stopped run with the same inputs");
  add_checkpoint(*verb, simulate.checkpoint_every_s);
  add_mesh(*verb, simulate.size, simulate.mesh_order);
  add_solver(*verb, simulate.solver);

  tools::CampaignOptions campaign;
  verb = add_verb(app, "campaign", "load programs on the full model, the TCP error at all poses: "
                  "tcp.csv and sensors.csv per load",
                  "thermotwin campaign cases/vmc5 --resume", campaign, &tools::campaign);
  verb->add_option("CASE", campaign.case_path, "case folder or case.toml")->required();
  verb->add_option("--load", campaign.loads, "only these load programs (absent: train and holdout of the case)");
  verb->add_flag("--resume", campaign.resume, "keep loads that are finished, go on with one that was stopped");
  add_checkpoint(*verb, campaign.checkpoint_every_s);
  add_mesh(*verb, campaign.size, campaign.mesh_order);
  add_solver(*verb, campaign.solver);

  tools::ReduceOptions reduce;
  verb = add_verb(app, "reduce", "reduced state-space model model.rom.h5; order and error table",
                  "thermotwin reduce cases/vmc5", reduce, &tools::reduce);
  verb->add_option("CASE", reduce.case_path, "case folder or case.toml")->required();
  verb->add_option("--order", reduce.order, "order of the model (0: the smallest that meets the case's tolerance)")
      ->check(CLI::Range(0, 2000));
  verb->add_flag("--resume", reduce.resume, "keep campaign results that are finished");
  add_mesh(*verb, reduce.size, reduce.mesh_order, "--mesh-order");
  add_solver(*verb, reduce.solver);

  tools::CompensateOptions compensate;
  verb = add_verb(app, "compensate", "streams rows of what a control knows in, axis offsets out, row by row",
                  "thermotwin compensate out/model.rom.h5 --in rows.csv --out offsets.csv", compensate,
                  &tools::compensate);
  verb->add_option("MODEL", compensate.model, "model.rom.h5")->required();
  verb->add_option("--in", compensate.in, "CSV file, or - for standard input")->capture_default_str();
  verb->get_option("--out")->description("CSV file of the offsets, or - for standard output");
  verb->add_flag("--no-sensors", compensate.no_sensors, "ignore temperature sensors");
  verb->add_option("--step", compensate.step_s, "longest step of the thermal state, s")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();

  tools::EvaluateOptions evaluate;
  verb = add_verb(app, "evaluate", "every compensation model on the same measurement, one table",
                  "thermotwin evaluate --data measured_drift", evaluate, &tools::evaluate);
  verb->add_option("CASE", evaluate.case_path, "case folder (absent: no machine model)");
  verb->add_option("--data", evaluate.data, "measurement folder")->required();
  verb->add_option("--model", evaluate.model, "model.rom.h5 (absent: made from the case)");
  verb->add_option("--train-until", evaluate.train_until_h, "hours that fitted models may see")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();

  tools::DiagnoseOptions diagnose;
  verb = add_verb(app, "diagnose", "what the simulation gets wrong in a measurement, why, the extended model, the gain",
                  "thermotwin diagnose cases/vmc5 --data measurement --model out/model.rom.h5", diagnose,
                  &tools::diagnose);
  verb->add_option("CASE", diagnose.case_path, "case folder (absent, and no --model: data without a machine, against a grey box of its first day)");
  verb->add_option("--data", diagnose.data, "measurement folder")->required();
  verb->add_option("--model", diagnose.model, "model.rom.h5 (absent: made from the case)");

  tools::ValidateOptions validate;
  verb = add_verb(app, "validate", "online validation on machines measured virtually: finer mesh, other time "
                  "steps, perturbed parameters, noise",
                  "thermotwin validate cases/vmc5 --model out/model.rom.h5 --draws 5", validate, &tools::validate);
  verb->add_option("CASE", validate.case_path, "case folder or case.toml")->required();
  verb->add_option("--model", validate.model, "model.rom.h5 (absent: made from the case)");
  verb->add_option("--load", validate.loads, "load programs (absent: the case's holdout list)");
  verb->add_option("--draws", validate.draws, "number of perturbed machines")->check(CLI::Range(1, 1000))->capture_default_str();
  verb->add_option("--measured-size", validate.size_factor, "size factor of the measured machine's mesh")
      ->check(CLI::Range(0.05, 2.0))
      ->capture_default_str();

  tools::ExportOptions exported;
  verb = add_verb(app, "export", "the machine for another program: a CalculiX deck (heat.inp, static.inp, mesh.inp)",
                  "thermotwin export cases/vmc5 --calculix --load spindle_6000 --pose X=0,Y=0,Z=275\n"
                  "  cd out/calculix && ccx heat && ccx static",
                  exported, &tools::export_model);
  verb->add_option("MODEL", exported.model, "case folder, case.toml or machine.toml")->required();
  verb->add_flag("--calculix", exported.calculix, "decks for ccx 2.20: heat transfer, then thermo-elastic displacement, SI units and degC");
  auto* load = verb->add_option("--load", exported.load, "load program, as amplitudes (absent: steady state of the machine as it stands)");
  auto* step = verb->add_option("--time-step", exported.time_step_s, "longest increment, s (absent: time_step_s of the load)")
                   ->check(CLI::PositiveNumber)
                   ->needs(load);
  verb->add_option("--steady-at", exported.steady_at_s, "steady state of what the load has at this time, s, instead of a transient")
      ->check(CLI::NonNegativeNumber)
      ->needs(load)
      ->excludes(step);
  verb->add_option("--pose", exported.pose, "axis positions, mm and deg, where the bodies are put (absent: home)");
  verb->add_option("--body", exported.body, "only this body, without its joints to others");
  verb->add_flag("--heat-only", exported.heat_only, "no static.inp");
  add_mesh(*verb, exported.size, exported.mesh_order);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::cerr << "thermotwin: " << usage_message(app, error) << "\n";
    const auto verbs = app.get_subcommands();
    std::cerr << "try: thermotwin " << (verbs.empty() ? "" : verbs.front()->get_name() + " ") << "--help\n";
    return 2;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return parse_and_run(argc, argv);
  } catch (const thermotwin::core::Error& error) {
    std::cerr << "thermotwin: " << error.what() << "\n";
    return error.exit_status();
  } catch (const std::bad_alloc&) {
    std::cerr << "thermotwin: not enough memory; a coarser --size needs less\n";
    return 4;
  } catch (const std::exception& error) {
    std::cerr << "thermotwin: " << error.what() << "\n";
    return 4;
  }
}
