// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/measure/measure.h"

#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"

namespace thermotwin::tools {

namespace {

std::shared_ptr<CommonOptions> add_uncertainty(CLI::App& group) {
  const auto options = std::make_shared<MeasureOptions>();
  MeasureOptions& measured = *options;
  CLI::App* verb = add_verb(
      group, "uncertainty",
      "Propagates an uncertainty budget by the law of JCGM 100 and by Monte Carlo, or studies continuous R-Tests.",
      "thermotwin measure uncertainty cases/budgets/rtest_probe.toml\n"
      "  thermotwin measure uncertainty --arc 45,90,150",
      options, &tools::measure_uncertainty);
  auto* budget = verb->add_option("BUDGET", measured.file, "Budget: inputs, correlations and formulas of measurands.");
  auto* arc =
      verb->add_option("--arc", measured.arcs_deg,
                       "Spans of continuous R-Tests, deg; Monte Carlo gives the uncertainty of their centre and tilt, "
                       "in place of a budget.")
          ->delimiter(',')
          ->allow_extra_args(false)
          ->check(CLI::Range(10.0, 360.0))
          ->excludes(budget);
  verb->add_option("--radius", measured.radius_mm, "Distance of the sphere from the axis, mm.")
      ->check(positive_number())
      ->capture_default_str()
      ->needs(arc);
  verb->add_option("--half-width", measured.half_width_um, "Half of the range of each coordinate's uniform error, um.")
      ->check(CLI::Range(1e-6, 1000.0))
      ->capture_default_str()
      ->needs(arc);
  verb->add_option("--rate", measured.rate_Hz, "Points per second.")
      ->check(positive_number())
      ->capture_default_str()
      ->needs(arc);
  verb->add_option("--feed", measured.feed_deg_min, "Speed of the axis, deg/min.")
      ->check(positive_number())
      ->capture_default_str()
      ->needs(arc);
  verb->add_option("--plane-offset", measured.plane_offset_mm,
                   "Distance along the axis from the point at which the centre is stated to the plane of the arc, mm.")
      ->capture_default_str()
      ->needs(arc);
  verb->add_option("--fit", measured.fit, "Circle fit: geometric, taubin or kasa.")
      ->check(CLI::IsMember({"geometric", "taubin", "kasa"}))
      ->capture_default_str()
      ->needs(arc);
  verb->add_option("--draws", measured.draws, "Number of simulated R-Tests for each arc.")
      ->check(CLI::Range(2, 1000000))
      ->capture_default_str()
      ->needs(arc);
  verb->add_option("--seed", measured.seed, "Seed of the random numbers.")
      ->check(seeds())
      ->capture_default_str()
      ->needs(arc);
  return options;
}

std::shared_ptr<CommonOptions> add_analyse(CLI::App& group) {
  const auto options = std::make_shared<MeasureOptions>();
  MeasureOptions& measured = *options;
  CLI::App* verb =
      add_verb(group, "analyse",
               "Computes errors of the kinematic chain from an R-Test or a volumetric grid, displacements from probes "
               "around a mandrel, the deformation of a table's surface, or ranges and gradients of an ISO 230-3 test.",
               "thermotwin measure analyse rtest --record loads --out out/rtest\n"
               "  thermotwin measure analyse etve --ambient air\n"
               "  thermotwin measure analyse etve spindle x_axis y_axis z_axis",
               options, &tools::measure_analyse);
  verb->add_option("FOLDER", measured.file,
                   "Folder with rtest.toml, grid.toml, mandrel.toml or surface.toml, or a measurement folder.")
      ->required();
  verb->add_option("FURTHER", measured.others,
                   "Further measurement folders: one table of all ISO 230-3 tests, a column for each.");
  verb->add_option("--record", measured.record,
                   "Measurement folder of loads and temperatures during the test, to be merged with its results.");
  verb->add_option("--channels", measured.channels,
                   "Channels of the folder for evaluate and diagnose: errors for location errors (default of an "
                   "R-Test), points for the deviations at the points (default of a grid).")
      ->check(CLI::IsMember({"errors", "points"}));
  verb->add_option("--ambient", measured.ambient, "Temperature channel for gradients per K of an ISO 230-3 test.");
  return options;
}

void add_plan_of_points(CLI::App& verb, MeasurePlanOptions& planned) {
  metrology::PlanOptions& plan = planned.plan;
  verb.add_option("--radius", plan.radius_mm, "Distance of the sphere from the table's axis, mm.")
      ->check(non_negative_number())
      ->capture_default_str();
  verb.add_option(
          "--azimuth", plan.azimuths_deg,
          "Direction of the sphere from the table's axis, counted from x, deg; several values give several spheres, "
          "e.g. 0,180.")
      ->delimiter(',')
      ->capture_default_str();
  verb.add_option("--height", plan.height_mm, "Height of the sphere above the table point, mm.")->capture_default_str();
  verb.add_option("--clearance", plan.clearance_mm, "Distance by which the tool retracts between points, mm.")
      ->check(non_negative_number())
      ->capture_default_str();
  verb.add_option("--angles", plan.angles_deg,
                  "Positions of the tested axis, deg; for rtest_continuous both ends (default: over its travel).")
      ->delimiter(',');
  verb.add_option("--tilts", plan.tilts_deg, "For rtest_grid: positions of the axis that carries the tested one, deg.")
      ->delimiter(',');
  verb.add_option("--tool-offset", planned.tool_offset_mm,
                  "Vector from the machine's tool point to the measured point, mm, e.g. 0,0,-150.")
      ->delimiter(',');
  verb.add_option("--probes-on", planned.mount, "Carrier of the probes: spindle or table.")
      ->check(CLI::IsMember({"spindle", "table"}))
      ->capture_default_str();
  verb.add_option("--contact-radius", planned.contact_radius_mm,
                  "Sum of the radii of probe tip and sphere, mm; 0: flat tips.")
      ->check(non_negative_number())
      ->capture_default_str();
  verb.add_option("--noise", planned.noise_um, "Standard deviation of a sample of a probe, um.")
      ->check(non_negative_number())
      ->capture_default_str();
  verb.add_option("--repeatability", planned.repeatability_um,
                  "Standard deviation of a coordinate of the linear axes at a point, um.")
      ->check(non_negative_number())
      ->capture_default_str();
}

std::shared_ptr<CommonOptions> add_plan(CLI::App& group) {
  const auto options = std::make_shared<MeasurePlanOptions>();
  MeasurePlanOptions& planned = *options;
  metrology::PlanOptions& plan = planned.plan;
  CLI::App* verb = add_verb(group, "plan",
                            "Writes the NC program, the load program and the points of an R-Test or of a test after "
                            "ISO 230-3.",
                            "thermotwin measure plan rtest --case cases/vmc5 --speed 300 --out out/plan\n"
                            "  thermotwin measure plan random_cycle --case cases/vmc5 --load C --load B --speeds 0,600 "
                            "--warm-up 60 --seed 7 --out out/plan",
                            options, &tools::measure_plan);
  verb->add_option("KIND", planned.kind,
                   "Test: rtest, rtest_continuous, rtest_grid, etve, spindle, linear_axis, rotary_axis, random_cycle, "
                   "volumetric_grid.")
      ->required();
  verb->add_option("--case", planned.case_path, "Case folder or case.toml.")->required();
  verb->add_option("--axis", plan.axis,
                   "Tested axis (default: the axis of the table; for linear_axis the first linear one).");
  verb->add_option("--load", plan.loads,
                   "Axis under load, or spindle; may be repeated (default: the tested axis; for volumetric_grid "
                   "none).");
  verb->add_option(
          "--speed", plan.speed,
          "Speed of the load: rpm for the spindle and endless axes, else mm/min or deg/min (default: half of the "
          "largest).")
      ->check(positive_number());
  verb->add_option("--range", plan.range,
                   "Range of the load's motion to and fro, mm or deg, e.g. -90,60 (default: 80 % of the travel).")
      ->delimiter(',');
  verb->add_option("--warm-up", plan.warm_up_h, "Time under load, h.")->capture_default_str();
  verb->add_option("--cool-down", plan.cool_down_h, "Time of standstill after the load, h.")->capture_default_str();
  verb->add_option("--interval", plan.interval_min, "Time from the end of a measurement to the next one, min.")
      ->capture_default_str();
  verb->add_option("--pose", plan.pose, "Positions of the axes that the test does not move, e.g. B=0 (default: home).");
  verb->add_option("--feed", plan.feed_deg_min, "Speed of the axis in a continuous test, deg/min.")
      ->capture_default_str();
  verb->add_option("--rate", plan.rate_Hz, "Samples per second.")->capture_default_str();
  verb->add_option("--speeds", plan.speeds, "For random_cycle: lowest and highest speed (default: 0 and --speed).")
      ->delimiter(',');
  verb->add_option("--change", plan.change_percent,
                   "For random_cycle: probability of another load after an interval, %.")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  verb->add_flag("--standstills", plan.standstills, "For random_cycle: each load is followed by a standstill.");
  verb->add_option("--seed", plan.seed, "For random_cycle: seed of the random numbers.")
      ->check(seeds())
      ->capture_default_str();
  verb->add_option("--air", planned.air_C,
                   "Two air temperatures, degC: at both ends of the test, and in its middle, with linear ramps "
                   "between, e.g. 21,26 (default: the machine's).")
      ->delimiter(',');
  add_plan_of_points(*verb, planned);
  return options;
}

std::shared_ptr<CommonOptions> add_simulate_test(CLI::App& group) {
  const auto options = std::make_shared<MeasureSimulateOptions>();
  MeasureSimulateOptions& simulated = *options;
  CLI::App* verb = add_verb(group, "simulate",
                            "Runs a planned test on the full model of a machine and writes the raw signals of its "
                            "probes.",
                            "thermotwin measure simulate out/plan --case cases/vmc5 --machine-seed 3 --out out/record\n"
                            "  thermotwin measure simulate out/plan --case cases/vmc5 --hide "
                            "source_power:C.bearings:1.6 --out out/record",
                            options, &tools::measure_simulate);
  verb->add_option("PLAN", simulated.plan, "Folder of measure plan.")->required();
  verb->add_option("--case", simulated.case_path, "Case folder or case.toml.")->required();
  verb->add_option("--machine-seed", simulated.machine_seed,
                   "Seed of parameters perturbed within their stated uncertainty; 0: the nominal machine.")
      ->check(seeds())
      ->capture_default_str();
  verb->add_option(
      "--hide", simulated.hide,
      "A changed parameter as KIND:WHERE:VALUE, kinds as in diagnosis.json, e.g. source_power:C.motor:1.6.");
  verb->add_option("--add", simulated.add,
                   "For an R-Test or a grid: a known error of the chain from the second measurement on, um, um/m ..., "
                   "e.g. EXX1=20; may be repeated.");
  verb->add_flag("--surface", simulated.surface, "Writes heights of the table's surface at each measurement too.");
  verb->add_option("--seed", simulated.seed, "Seed of the noise.")->check(seeds())->capture_default_str();
  verb->add_flag("--no-noise", simulated.no_noise, "Probes and sensors without noise, axes without scatter.");
  verb->add_option("--sensor-noise", simulated.sensor_noise_K,
                   "Standard deviation of a reading of a temperature sensor, K.")
      ->check(non_negative_number())
      ->capture_default_str();
  verb->add_option("--draws", simulated.draws,
                   "Number of draws of noise and calibration that give the coverage of the stated uncertainty.")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str();
  add_mesh_options(*verb, simulated.size, simulated.mesh_order);
  add_solver_option(*verb, simulated.solver);
  return options;
}

}  // namespace

void add_measure(CLI::App& app) {
  CLI::App* group =
      app.add_subcommand("measure", "Plans and evaluates tests of location errors and states their uncertainty.");
  group->require_subcommand(1);
  group->footer(
      "Example:\n  thermotwin measure uncertainty cases/budgets/jcgm100_h2.toml\nthermotwin measure VERB --help "
      "describes a verb and its options.");
  share_common_options(*group,
                       {add_plan(*group), add_simulate_test(*group), add_uncertainty(*group), add_analyse(*group)});
}

}  // namespace thermotwin::tools
