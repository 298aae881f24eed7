// SPDX-License-Identifier: GPL-3.0-or-later
// The command line: parses, sets threads and quiet, calls the verb, maps errors to exit status.

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include "core/error.h"
#include "core/process.h"
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

/// What `reduce` asks of a case only.
void add_reduced_case(CLI::App& verb, tools::ReduceOptions& reduce, CLI::Option& of_case) {
  verb.add_flag("--resume", reduce.resume, "keep campaign results that are finished")->needs(&of_case);
  auto* bound = verb.add_flag("--bound", reduce.bound, "bound.rom.h5 too, for a guaranteed bound of the error at a pose; tells it for the held-out loads")
                    ->needs(&of_case);
  verb.add_option("--bound-pose", reduce.bound_poses, "of --bound: e.g. X=0,Y=0,Z=275,B=90, again for more (absent: the middle of the workspace)")
      ->needs(bound)
      ->take_all();
  add_mesh(verb, reduce.size, reduce.mesh_order, "--mesh-order");
  add_solver(verb, reduce.solver);
  for (const char* name : {"--size", "--mesh-order", "--solver"}) verb.get_option(name)->needs(&of_case);
}

/// What it asks of matrices only.
void add_matrices(CLI::App& verb, tools::ReduceOptions& reduce, CLI::Option& of_case) {
  auto* matrices = verb.add_option("--matrices", reduce.matrices,
                                   "instead of a CASE: folder of A.mtx, B.mtx, C.mtx (Matrix Market), E.mtx where it is not the "
                                   "identity, D.mtx and A_film_NAME.mtx where there are any; results: the same files, reduced, "
                                   "and system.rom.h5")
                       ->excludes(&of_case);
  verb.add_option("--method", reduce.method, "of a case: combined (absent), krylov, pod, balanced, modal; of --matrices: balanced "
                  "truncation (absent), modal truncation (dominant modes), rational krylov");
  verb.add_option("--tolerance", reduce.tolerance, "of --matrices: bound of the error, relative to the H-infinity norm")
      ->check(CLI::PositiveNumber)
      ->needs(matrices)
      ->capture_default_str();
  verb.add_flag("--absolute", reduce.absolute, "the tolerance is the bound itself")->needs(matrices);
  verb.add_flag("--compare", reduce.compare, "true errors of all methods at several orders");
  verb.add_option("--film", reduce.films,
                  "of --matrices: NAME=VALUE[,VALUE...], factor of A_film_NAME where the bases are made "
                  "(absent: 1); several values: a basis of --order for each combination, joined")
      ->needs(matrices);
}

/// What it asks of the tables of a campaign only.
void add_from_campaign(CLI::App& verb, tools::ReduceOptions& reduce, CLI::Option& of_case) {
  auto* from = verb.add_option_function<std::string>(
                       "--from-campaign",
                       [&reduce](const std::string& folder) {
                         reduce.identify = true;
                         if (folder != "true") reduce.campaign = folder;
                       },
                       "identify a model from the tables of a campaign alone (folder of inputs.csv, sensors.csv, tcp.csv per load; "
                       "absent: campaign/ in --out), without the full model; results: system.rom.h5 and E, A, B, C as .mtx")
                   ->expected(0, 1)
                   ->type_name("[DIR]")
                   ->needs(&of_case);
  for (const char* name : {"--resume", "--bound", "--size", "--mesh-order", "--solver", "--matrices", "--method", "--compare"})
    from->excludes(verb.get_option(name));
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
    core::install_memory_handler();
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
  verb = add_verb(app, "simulate", "one load on the full model: fields.pvd, sensors.csv, tcp.csv, heat.csv",
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
  verb = add_verb(app, "campaign", "load programs on the full model, or on the reduced one, the TCP error at all poses: "
                  "tcp.csv, sensors.csv and heat.csv (heat flows, W) per load",
                  "thermotwin campaign cases/vmc5 --resume\n"
                  "  thermotwin campaign cases/vmc5 --reduced --model out/model.rom.h5 --out fast", campaign, &tools::campaign);
  verb->add_option("CASE", campaign.case_path, "case folder or case.toml")->required();
  verb->add_option("--load", campaign.loads, "only these load programs (absent: train and holdout of the case)");
  auto* resume = verb->add_flag("--resume", campaign.resume, "keep loads that are finished, go on with one that was stopped");
  auto* reduced = verb->add_flag("--reduced", campaign.reduced, "by the reduced model; with its reference, error_estimate.csv per load too")
                      ->excludes(resume);
  verb->add_option("--model", campaign.model, "of --reduced: model.rom.h5 (absent: that of --out)")->needs(reduced);
  verb->add_flag("--exact", campaign.exact, "of --reduced: steps without time error where films, contacts and flows stand (those that follow "
                 "the temperature never do); "
                 "absent: the full model's time scheme, to compare with it")
      ->needs(reduced);
  verb->add_option("--reference", campaign.reference, "of --reduced: model of larger order that estimates the error "
                   "(absent: reference.rom.h5 beside the model, if it is there)")
      ->needs(reduced);
  verb->add_flag("--bound", campaign.bound, "of --reduced: error_bound.csv per load too, what the error cannot exceed at the poses of "
                 "bound.rom.h5 beside the model (thermotwin reduce --bound)")
      ->needs(reduced);
  add_checkpoint(*verb, campaign.checkpoint_every_s);
  add_mesh(*verb, campaign.size, campaign.mesh_order);
  add_solver(*verb, campaign.solver);
  for (const char* of_full : {"--size", "--mesh-order", "--order", "--solver", "--checkpoint-every"})
    if (CLI::Option* option = verb->get_option_no_throw(of_full)) reduced->excludes(option);

  tools::ReduceOptions reduce;
  verb = add_verb(app, "reduce", "reduced state-space model model.rom.h5 of a case, with order and error table; or, with "
                  "--matrices, of the system E x' = A x + B u, y = C x + D u of another program",
                  "thermotwin reduce cases/vmc5\n"
                  "  thermotwin reduce cases/vmc5 --from-campaign out/campaign --out identified\n"
                  "  thermotwin reduce --matrices rail --tolerance 1e-4 --out rail_reduced\n"
                  "  thermotwin reduce --matrices spindle --film air=5,50 --film oil=1 --compare", reduce, &tools::reduce);
  auto* reduced_case = verb->add_option("CASE", reduce.case_path, "case folder or case.toml");
  verb->add_option_function<std::string>(
          "--order",
          [&reduce](const std::string& word) {
            reduce.order_by_observer = word == "observer";
            if (!reduce.order_by_observer) reduce.order = std::stoi(word);
          },
          "order of the model (0: the smallest that meets the tolerance); of a case also observer: the smallest whose error is below "
          "what an observer with the machine's sensors is unsure of")
      ->check(CLI::Range(0, 2000) | CLI::IsMember({"observer"}));
  add_reduced_case(*verb, reduce, *reduced_case);
  add_matrices(*verb, reduce, *reduced_case);
  add_from_campaign(*verb, reduce, *reduced_case);

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

  verb->add_option("--largest-offset", compensate.largest_um, "um; no offset is larger (absent: twice what the model's operating points make)")->check(CLI::PositiveNumber);
  verb->add_option("--offset-rate", compensate.rate_um_s, "um/s; no offset changes faster, from nought at the start (absent: the largest in 300 s, and what moves of the axes account for)")
      ->check(CLI::PositiveNumber);

  verb->add_flag("--strict", compensate.strict, "a cell that cannot be read ends the run (absent: it counts as missing, and the status says so)");

  verb->add_option("--probe-std", compensate.probe_std_um, "um, standard deviation of the values in columns probe_dx_um, probe_dy_um, probe_dz_um")
      ->check(CLI::Range(0.001, 1e5))
      ->capture_default_str();
  verb->add_flag("--probed-compensated", compensate.probed_compensated, "they were probed while the offsets of the row before were applied");
  verb->add_option("--learned", compensate.learned, "CSV file: what sensors and probing told of powers, films, expansions, ..., with its uncertainty, at the end");
  verb->add_option("--explain", compensate.explain, "text file: which augmented states the sensors can tell (detectability), by name, at the end");

  tools::OffsetsOptions offsets;
  verb = add_verb(app, "offsets", "location errors of any kinematic chain to axis offsets, row by row",
                  "thermotwin offsets --chain \"V [w C' B' b Y X Z (C1) t]\" --in errors.csv --out offsets.csv", offsets, &tools::offsets);
  verb->add_option("--chain", offsets.chain, "ISO 10791-1: axes from the workpiece w by the bed b to the tool t")->required();
  verb->add_option("--in", offsets.in, "CSV: time_s, positions X_mm B_deg, functional point point_x_mm (absent: 0), errors X0C_um A0C_um_per_m R0T_um")
      ->required();
  verb->get_option("--out")->description("CSV file of the offsets, or - for standard output");
  verb->add_flag("--orientation", offsets.orientation, "use rotary axes for the functional orientation too");
  verb->add_option("--axes", offsets.axes, "only these axes may be used: X,Y,Z (absent: all of the chain)")->delimiter(',');
  verb->add_option("--with-letter", offsets.along_letter, "axes that move the workpiece with their letter instead of against it: B,C")->delimiter(',');
  verb->add_option("--table-radius", offsets.table_radius_mm, "mm, at which R0T is stated")->check(CLI::PositiveNumber)->capture_default_str();

  tools::EvaluateOptions evaluate;
  verb = add_verb(app, "evaluate", "every compensation model on the same measurement, fitted on its beginning, judged on the rest",
                  "thermotwin evaluate --data measured_drift\n"
                  "  thermotwin evaluate cases/vmc5 --data measurement --model out/model.rom.h5 --check dx@2,dy@2,dz@2\n"
                  "  thermotwin evaluate --data other_machine --fitted out/evaluation/models.toml --train-until 2",
                  evaluate, &tools::evaluate);
  verb->add_option("CASE", evaluate.case_path, "case folder (absent: no machine model)");
  verb->add_option("--data", evaluate.data, "measurement folder")->required();
  verb->add_option("--also", evaluate.also, "further folders with the same channels, none of which a fit sees: A,B")->delimiter(',');
  auto* train_data =
      verb->add_option(
              "--train-data", evaluate.train_data,
              "further folders that fitted models see whole; --data then trains only by one of the next two: A,B")
          ->delimiter(',');
  verb->add_option("--model", evaluate.model, "model.rom.h5 (absent: made from the case)");
  auto* extended = verb->add_option("--extended", evaluate.extended, "diagnosis/extended/model.rom.h5, judged beside the nominal model");
  auto* until = verb->add_option("--train-until", evaluate.train_until_h, "hours from the first row that fitted models may see (absent: 24, of a record below 30 h half)")
                    ->check(CLI::PositiveNumber);
  verb->add_option("--train-programs", evaluate.train_programs, "programs of channels.toml that fitted models may see instead: A,B")
      ->delimiter(',')
      ->excludes(until);
  verb->add_option("--models", evaluate.models, "only these fitted models: static_regression,grey_box,... (absent: all)")->delimiter(',');
  verb->add_option("--check", evaluate.check, "displacement channels that no fit may use, predicted over the workspace: dx@2,dy@2")->delimiter(',');
  verb->add_option("--fitted", evaluate.fitted,
                   "models.toml of another machine of the type: as it is, and with one factor a channel")
      ->excludes(extended)
      ->excludes(train_data);
  verb->add_flag("--cross", evaluate.cross, "fit on each program (or day), judge on all the others")
      ->excludes(train_data);
  verb->add_option("--length-study", evaluate.length_study, "MODEL CHANNEL: how long a measurement the model needs, as box plots")->expected(2);

  tools::DiagnoseOptions diagnose;
  verb = add_verb(app, "diagnose", "what the simulation gets wrong in a measurement, why, the extended model, the gain",
                  "thermotwin diagnose cases/vmc5 --data measurement --model out/model.rom.h5", diagnose,
                  &tools::diagnose);
  verb->add_option("CASE", diagnose.case_path, "case folder (absent, and no --model: data without a machine, against a grey box of its first day)");
  verb->add_option("--data", diagnose.data, "measurement folder")->required();
  verb->add_option("--model", diagnose.model, "model.rom.h5 (absent: made from the case)");
  const auto add_error = [&](const std::string& name, std::optional<double>& percent, double otherwise, const std::string& of) {
    verb->add_option(name, percent, "percent of each " + of + "'s own response by which mesh and time steps may be off; where a study of the mesh shows less, more is seen")
        ->check(CLI::Range(0.1, 50.0))
        ->default_str(fmt::format("{}", otherwise));
  };
  add_error("--displacement-error", diagnose.displacement_error_percent, diagnosis::DiagnoseOptions{}.displacement_error_percent, "displacement");
  add_error("--temperature-error", diagnose.temperature_error_percent, diagnosis::DiagnoseOptions{}.temperature_error_percent, "temperature");

  tools::ValidateOptions validate;
  verb = add_verb(app, "validate", "online validation on machines measured virtually: finer mesh, another time "
                  "scheme, perturbed parameters, noise. Full runs are kept in --out: a stopped study goes on",
                  "thermotwin validate cases/vmc5 --model out/model.rom.h5 --draws 20 --perturb thermal\n"
                  "  thermotwin validate cases/vmc5 --model out/model.rom.h5 --power-off --draws 20 --truth out/reference.rom.h5 --full-draws 5", validate, &tools::validate);
  verb->add_option("CASE", validate.case_path, "case folder or case.toml")->required();
  verb->add_option("--model", validate.model, "model.rom.h5 (absent: made from the case)");
  verb->add_option("--load", validate.loads, "load programs (absent: the case's holdout list)");
  verb->add_option("--draws", validate.draws, "number of perturbed machines")->check(CLI::Range(1, 1000))->capture_default_str();
  verb->add_option("--first-seed", validate.first_seed, "machine i is drawn with this seed + i")->capture_default_str();
  verb->add_option("--perturb", validate.perturb, "all: every value with std_percent; thermal: powers, films and contact conductances only")
      ->check(CLI::IsMember({"all", "thermal"}))
      ->capture_default_str();
  verb->add_flag("--power-off", validate.power_off, "instead of load programs: work at random, hours without power, and a start that knows nothing before");
  verb->add_flag("--failed-sensors", validate.failed_sensors, "each sensor fails in each way (stuck, 2 K off, ten times the noise, absent): what it costs, how soon it is named")
      ->excludes("--power-off");
  auto* truth = verb->add_option("--truth", validate.reference, "reference.rom.h5: machines are its perturbed coefficients instead of full models (seconds; an easier truth)")
      ->check(CLI::ExistingFile);
  verb->add_option("--full-draws", validate.full_draws, "so many of the machines are measured on full models on a finer mesh too (minutes each), printed side by side")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str()
      ->needs(truth);
  verb->add_option("--measured-size", validate.size_factor, "size factor of the measured machine's mesh")
      ->check(CLI::Range(0.05, 2.0))
      ->capture_default_str();

  tools::ExportOptions exported;
  verb =
      add_verb(app, "export",
               "the machine for another program: a CalculiX deck (heat.inp, static.inp, mesh.inp), or its matrices "
               "(Matrix Market)",
               "thermotwin export cases/vmc5 --calculix --load spindle_6000 --pose X=0,Y=0,Z=275\n"
               "  cd out/calculix && ccx heat && ccx static\n"
               "  thermotwin export cases/vmc5 --matrices && thermotwin reduce --matrices out/matrices --out reduced",
               exported, &tools::export_model);
  verb->add_option("MODEL", exported.model, "case folder, case.toml or machine.toml")->required();
  verb->add_flag("--calculix", exported.calculix, "decks for ccx 2.20: heat transfer, then thermo-elastic displacement, SI units and degC");
  auto* matrices = verb->add_flag(
      "--matrices", exported.matrices,
      "E, A, a matrix for each film, contact and flow, B, C, and names.toml: what `reduce --matrices` reads");
  auto* load = verb->add_option("--load", exported.load, "load program, as amplitudes (absent: steady state of the machine as it stands)");
  auto* step = verb->add_option("--time-step", exported.time_step_s, "longest increment, s (absent: time_step_s of the load)")
                   ->check(CLI::PositiveNumber)
                   ->needs(load);
  verb->add_option("--steady-at", exported.steady_at_s, "steady state of what the load has at this time, s, instead of a transient")
      ->check(CLI::NonNegativeNumber)
      ->needs(load)
      ->excludes(step);
  verb->add_option(
      "--pose", exported.pose,
      "axis positions, mm and deg, where the bodies are put, and whose TCP error the matrices give (absent: home)");
  auto* body = verb->add_option("--body", exported.body, "only this body, without its joints to others");
  auto* heat_only = verb->add_flag("--heat-only", exported.heat_only, "no static.inp");
  for (CLI::Option* of_calculix : {load, body, heat_only}) matrices->excludes(of_calculix);
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
    std::cerr << "thermotwin: " << (thread ? "no thread can be started: not enough memory (ulimit -v) or too many processes (ulimit -u)" : error.what())
              << "\n";
    return 4;
  } catch (const std::exception& error) {
    std::cerr << "thermotwin: " << error.what() << "\n";
    return 4;
  }
}

}  // namespace

int main(int argc, char** argv) { thermotwin::core::leave(status_of(argc, argv)); }
