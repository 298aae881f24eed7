// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/study/study.h"

#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"

namespace thermotwin::tools {
namespace {

/// Options of a study in units.
void add_cluster_options(CLI::App& verb, ClusterOptions& cluster) {
  auto* local = verb.add_flag("--local", cluster.local, "Compute on this host (default).");
  auto* slurm = verb.add_flag("--slurm", cluster.slurm,
                              "Write an array job, a gathering job and submit.sh for Slurm, and compute nothing here.")
                    ->excludes(local);
  auto* part = verb.add_option("--part", cluster.part,
                               "I/N, with I from 0: compute every N-th unit from unit I on, and gather nothing; a task "
                               "of the array job.")
                   ->excludes(slurm)
                   ->excludes(local);
  verb.add_flag("--dry-run", cluster.dry_run,
                "Say which units are to be computed and what memory and disk they need, and compute nothing.")
      ->excludes(slurm)
      ->excludes(part);
  verb.add_flag("--gather", cluster.gather,
                "Compute nothing: make the tables of the units that are done, and name those that are missing "
                "(status 3).")
      ->excludes(slurm)
      ->excludes(part)
      ->excludes("--dry-run");
  verb.add_option("--tasks", cluster.tasks, "With --slurm: tasks of the array job (default: one a unit, 200 at most).")
      ->check(CLI::Range(1, 100000))
      ->needs(slurm);
  verb.add_option("--task-threads", cluster.task_threads, "With --slurm: processors of a task.")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str()
      ->needs(slurm);
  verb.add_option("--task-memory", cluster.task_memory_GiB, "With --slurm: memory of a task, GiB.")
      ->check(CLI::Range(0.01, 1e5))
      ->capture_default_str()
      ->needs(slurm);
  verb.add_option("--task-hours", cluster.task_hours,
                  "With --slurm: time limit of a task, h; at the limit it writes its checkpoint and is queued again.")
      ->check(CLI::Range(0.1, 8760.0))
      ->capture_default_str()
      ->needs(slurm);
  verb.add_option("--partition", cluster.partition, "With --slurm: partition (default: the cluster's).")->needs(slurm);
}

std::shared_ptr<CommonOptions> add_variants(CLI::App& group) {
  const auto options = std::make_shared<StudyVariantsOptions>();
  StudyVariantsOptions& variants = *options;
  CLI::App* verb =
      add_verb(group, "variants",
               "Computes variants of a case after a plan: quantiles of the TCP error by pose and time, and "
               "the parameters that matter.",
               "thermotwin study variants family.toml\n"
               "  thermotwin study variants family.toml --slurm --out /shared/family",
               options, &study_variants);
  verb->add_option("PLAN", variants.plan, "Plan (keys: docs/reference/study.md).")->required();
  auto* reduced = verb->add_flag("--reduced", variants.reduced,
                                 "Use the reduced model instead of the full one; the result says so.");
  verb->add_option("--model", variants.model,
                   "With --reduced: the reduced model (default: model.rom.h5 in --out, else made from the case).")
      ->needs(reduced);
  add_cluster_options(*verb, variants.cluster);
  add_checkpoint_option(*verb, variants.checkpoint_every_s);
  add_solver_option(*verb, variants.solver);
  return options;
}

std::shared_ptr<CommonOptions> add_campaign_study(CLI::App& group) {
  const auto options = std::make_shared<StudyCampaignOptions>();
  CLI::App* verb =
      add_verb(group, "campaign",
               "Computes the campaign of a case in units, here or on a cluster, and writes the files of "
               "`campaign`. A unit is all load programs with the same time steps and outputs.",
               "thermotwin study campaign cases/vmc5 --slurm --out /shared/vmc5", options, &study_campaign);
  add_full_campaign_options(*verb, *options);
  add_cluster_options(*verb, options->cluster);
  return options;
}

std::shared_ptr<CommonOptions> add_validate_study(CLI::App& group) {
  const auto options = std::make_shared<StudyValidateOptions>();
  CLI::App* verb = add_verb(group, "validate",
                            "Validates the compensation as `validate` does, in units, here or on a cluster. A unit is "
                            "a machine that is measured on the full model.",
                            "thermotwin study validate cases/vmc5 --model out/model.rom.h5 --draws 20 --slurm --out "
                            "/shared/vmc5",
                            options, &study_validate);
  add_validate_options(*verb, *options);
  add_checkpoint_option(*verb, options->checkpoint_every_s);
  add_cluster_options(*verb, options->cluster);
  return options;
}

std::shared_ptr<CommonOptions> add_sensors(CLI::App& group) {
  const auto options = std::make_shared<StudySensorsOptions>();
  StudySensorsOptions& sensors = *options;
  CLI::App* verb = add_verb(group, "sensors",
                            "Chooses places for temperature sensors that leave the observer the least variance of the "
                            "TCP error.",
                            "thermotwin study sensors cases/vmc5 --count 9 --confirm 5", options, &study_sensors);
  verb->add_option("CASE", sensors.case_path, "Case folder or case.toml.")->required();
  add_mesh_options(*verb, sensors.size, sensors.mesh_order, "--mesh-order");
  verb->add_option("--count", sensors.count, "Number of sensors (default: as many as the case has).")
      ->check(CLI::Range(1, 200));
  verb->add_option("--load", sensors.loads,
                   "Load programs over which the variance is averaged (default: holdout of the case).");
  verb->add_option("--body", sensors.bodies, "Bodies that may have sensors (default: all elastic ones).");
  verb->add_option("--without", sensors.without, "Bodies and surfaces that no sensor may be on.");
  verb->add_flag("--on-contacts", sensors.on_contacts, "Allow places on surfaces of joints.");
  verb->add_flag("--on-rotating", sensors.on_rotating,
                 "Allow places on bodies that turn with a spindle or an endless axis.");
  verb->add_option("--spacing", sensors.spacing_mm, "Least distance between two candidate places on a body, mm.")
      ->check(CLI::Range(1.0, 10000.0))
      ->capture_default_str();
  verb->add_option("--noise", sensors.noise_K, "Standard deviation of a reading, K.")
      ->check(CLI::Range(1e-6, 100.0))
      ->capture_default_str();
  verb->add_option("--bias", sensors.bias_K, "Standard deviation of a sensor's constant error, K.")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  verb->add_option("--every", sensors.every_min, "Time between two corrections, min.")
      ->check(CLI::Range(0.1, 1440.0))
      ->capture_default_str();
  verb->add_option("--exchanges", sensors.exchanges, "Largest number of passes that replace single sensors.")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  verb->add_flag("--any-loss", sensors.any_loss,
                 "Choose for the error that remains after the loss of the worst sensor.");
  verb->add_option("--confirm", sensors.confirm,
                   "Number of virtually measured machines on which the chosen sensors are compared with the case's.")
      ->check(CLI::Range(1, 1000));
  return options;
}

std::shared_ptr<CommonOptions> add_tests(CLI::App& group) {
  const auto options = std::make_shared<StudyTestsOptions>();
  StudyTestsOptions& tests = *options;
  CLI::App* verb = add_verb(group, "tests",
                            "Chooses load programs and their order for a thermal test, so that the uncertain values of "
                            "machine.toml leave the least variance of the TCP error.",
                            "thermotwin study tests cases/vmc5 --hours 24 --confirm 3", options, &study_tests);
  verb->add_option("CASE", tests.case_path, "Case folder or case.toml.")->required();
  verb->add_option("--model", tests.model, "Reduced model (default: model.rom.h5 in --out, else made from the case).");
  verb->add_option("--hours", tests.hours, "Length of the test, h; with --leave the longest.")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  verb->add_option("--leave", tests.leave_um,
                   "Largest standard deviation of the TCP error that the shortened test may leave, um.")
      ->check(CLI::Range(1e-6, 1e6));
  verb->add_option("--block", tests.block_min, "Length of a standard block, min.")
      ->check(CLI::Range(5.0, 1440.0))
      ->capture_default_str();
  verb->add_option("--interval", tests.interval_min, "Interval of random cycles, min.")
      ->check(CLI::Range(5.0, 1440.0))
      ->capture_default_str();
  verb->add_option("--program", tests.programs,
                   "Load programs of the case that are blocks too (default: train of the case).");
  auto* none = verb->add_flag("--no-programs", tests.no_programs, "Use standard blocks only.");
  verb->add_flag("--no-standard", tests.no_standard, "Use load programs of the case only.")->excludes(none);
  verb->add_flag("--chamber", tests.chamber,
                 "Allow load programs that set the temperature of the surroundings: the machine stands in a chamber.");
  verb->add_option("--load", tests.loads,
                   "Load programs over which the variance is averaged (default: holdout of the case).");
  verb->add_option("--parameter", tests.parameters,
                   "Values that the test determines, as KIND:WHERE (default: all with a std_percent).");
  verb->add_option("--every", tests.every_min, "Time between two readings of the sensors, min.")
      ->check(CLI::Range(1.0, 1440.0))
      ->capture_default_str();
  verb->add_option("--bias", tests.bias_K, "Standard deviation of a sensor's constant error, K.")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  auto* probed =
      verb->add_option("--probe-every", tests.probe_every_min, "Time between two readings of the probe, min.")
          ->check(CLI::Range(5.0, 1440.0))
          ->capture_default_str();
  auto* std_um = verb->add_option("--probe-std", tests.probe_um, "Standard deviation of a probed translation, um.")
                     ->check(CLI::Range(1e-3, 1000.0))
                     ->capture_default_str();
  auto* pose = verb->add_option("--probe-pose", tests.probe_pose, "Pose at which it is probed (default: home).");
  verb->add_flag("--no-probe", tests.no_probe, "Use the temperature sensors alone.")
      ->excludes(probed)
      ->excludes(std_um)
      ->excludes(pose);
  verb->add_option("--exchanges", tests.exchanges, "Largest number of passes that replace single blocks.")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  verb->add_option("--orders", tests.orders, "Random orders to compare with.")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  verb->add_option("--seed", tests.seed, "Seed of the random cycles and orders.")
      ->check(seeds())
      ->capture_default_str();
  verb->add_option("--confirm", tests.confirm,
                   "Number of virtually measured machines whose values are estimated from the chosen test and from the "
                   "first random order.")
      ->check(CLI::Range(1, 1000));
  return options;
}

}  // namespace

void add_study(CLI::App& app) {
  CLI::App* group = app.add_subcommand("study", "Computes families of machines, here or on a cluster.");
  group->require_subcommand(1);
  group->footer(
      "Example:\n  thermotwin study variants family.toml\nthermotwin study VERB --help describes a verb and its "
      "options.");
  share_common_options(*group, {add_variants(*group), add_campaign_study(*group), add_validate_study(*group),
                                add_sensors(*group), add_tests(*group)});
}

}  // namespace thermotwin::tools
