// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/measure/measure.h"

#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"

namespace thermotwin::tools {

namespace {

void add_uncertainty(CLI::App& group, const std::shared_ptr<MeasureOptions>& options) {
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
                       "Spans of continuous R-Tests, deg, whose centre and tilt are drawn in place of a budget.")
          ->delimiter(',')
          ->check(CLI::Range(10.0, 360.0))
          ->excludes(budget);
  verb->add_option("--radius", measured.radius_mm, "Distance of the sphere from the axis, mm.")
      ->check(CLI::PositiveNumber)
      ->capture_default_str()
      ->needs(arc);
  verb->add_option("--half-width", measured.half_width_um, "Half of the range of each coordinate's uniform error, um.")
      ->check(CLI::PositiveNumber)
      ->capture_default_str()
      ->needs(arc);
  verb->add_option("--rate", measured.rate_Hz, "Points per second.")
      ->check(CLI::PositiveNumber)
      ->capture_default_str()
      ->needs(arc);
  verb->add_option("--feed", measured.feed_deg_min, "Speed of the axis, deg/min.")
      ->check(CLI::PositiveNumber)
      ->capture_default_str()
      ->needs(arc);
  verb->add_option("--plane-offset", measured.plane_offset_mm,
                   "Distance along the axis from the stated point of the centre to the plane of the arc, mm.")
      ->capture_default_str()
      ->needs(arc);
  verb->add_option("--fit", measured.fit, "Circle fit: geometric, taubin or kasa.")
      ->check(CLI::IsMember({"geometric", "taubin", "kasa"}))
      ->capture_default_str()
      ->needs(arc);
  verb->add_option("--draws", measured.draws, "R-Tests that are drawn for each arc.")
      ->check(CLI::Range(2, 1000000))
      ->capture_default_str()
      ->needs(arc);
  verb->add_option("--seed", measured.seed, "Seed of the random numbers.")->capture_default_str()->needs(arc);
}

void add_analyse(CLI::App& group, const std::shared_ptr<MeasureOptions>& options) {
  MeasureOptions& measured = *options;
  CLI::App* verb =
      add_verb(group, "analyse",
               "Computes location errors with their uncertainty from an R-Test, or ranges and gradients of "
               "an ISO 230-3 test.",
               "thermotwin measure analyse rtest --record loads --out out/rtest\n"
               "  thermotwin measure analyse etve --ambient air",
               options, &tools::measure_analyse);
  verb->add_option("FOLDER", measured.file, "Folder with rtest.toml and points.csv, or a measurement folder.")
      ->required();
  verb->add_option("--record", measured.record,
                   "Measurement folder of loads and temperatures during the R-Test, to be merged with its errors.");
  verb->add_option("--ambient", measured.ambient, "Temperature channel for gradients per K of an ISO 230-3 test.");
}

}  // namespace

void add_measure(CLI::App& app) {
  const auto options = std::make_shared<MeasureOptions>();
  CLI::App* group = app.add_subcommand("measure", "Measures location errors and states their uncertainty.");
  add_common_options(*group, *options);  // shared with the verbs below, wherever they stand
  group->require_subcommand(1);
  group->footer(
      "Example:\n  thermotwin measure uncertainty cases/budgets/jcgm100_h2.toml\nthermotwin measure VERB --help "
      "describes a verb and its options.");
  add_uncertainty(*group, options);
  add_analyse(*group, options);
}

}  // namespace thermotwin::tools
