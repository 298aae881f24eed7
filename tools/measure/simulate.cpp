// SPDX-License-Identifier: GPL-3.0-or-later
// The verb measure simulate: a planned test on the full model of a machine, with raw signals of its probes.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <map>

#include "compensation/measurement/virtual_measurement.h"
#include "core/error.h"
#include "core/progress.h"
#include "core/text.h"
#include "core/units.h"
#include "diagnosis/causes/hypothesis.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/parameter.h"
#include "metrology/plan/plan_files.h"
#include "metrology/plan/sphere.h"
#include "metrology/twin/known_errors.h"
#include "metrology/twin/record_folder.h"
#include "metrology/twin/study.h"
#include "tools/chain.h"
#include "tools/measure/json_number.h"
#include "tools/measure/measure.h"

namespace thermotwin::tools {

namespace {

using metrology::Figures;
using metrology::RTestStudy;
using nlohmann::json;

/// "source_power:C.bearings:1.6" changes one parameter of the machine.
mesh::Machine with_hidden(const mesh::Machine& machine, const std::string& hidden) {
  const std::size_t first = hidden.find(':'), last = hidden.rfind(':');
  if (first == std::string::npos || last == first)
    throw core::UsageError("--hide needs KIND:WHERE:VALUE, such as source_power:C.bearings:1.6");
  double value = 0.0;
  try {
    value = std::stod(hidden.substr(last + 1));
  } catch (const std::exception&) {
    throw core::InputError("--hide", "'" + hidden.substr(last + 1) + "'", "a number behind the last colon");
  }
  return diagnosis::with_parameter(machine,
                                   diagnosis::make_parameter(diagnosis::kind_named(hidden.substr(0, first)),
                                                             hidden.substr(first + 1, last - first - 1)),
                                   value);
}

std::string pair_text(const Figures& figures) {
  std::string text;
  if (!std::isnan(figures.um)) text += fmt::format("{:.3g} um", figures.um);
  if (!std::isnan(figures.um_per_m)) text += fmt::format("{}{:.3g} um/m", text.empty() ? "" : ", ", figures.um_per_m);
  return text.empty() ? "-" : text;
}

json pair_json(const Figures& figures) {
  return {{"um", number_or_null(figures.um)}, {"um_per_m", number_or_null(figures.um_per_m)}};
}

std::string study_text(const RTestStudy& study) {
  std::vector<std::vector<std::string>> rows{{"", "lengths, angles"}};
  rows.push_back({"estimate less functional, largest (no noise, no drift)", ""});
  rows.push_back({"  table's side alone", pair_text(study.largest_difference)});
  rows.push_back({"  with the tool's side", pair_text(study.largest_with_tool)});
  rows.push_back({"drift during a cycle adds, RMS", pair_text(study.drift_adds)});
  rows.push_back({"the correction leaves of it, RMS", pair_text(study.drift_leaves)});
  rows.push_back({"what the errors do not explain of a coordinate, pooled", fmt::format("{:.3g} um", study.residual)});
  rows.push_back({"  of the table's side alone", fmt::format("{:.3g} um", study.residual_of_table)});
  std::string text = core::format_table(rows);
  if (study.draws > 0) {
    text += fmt::format("U (k = 2) covers {:.1f} % of {} draws of noise and calibration\n", study.covered_percent,
                        study.draws);
  }
  return text;
}

json study_json(const RTestStudy& study) {
  json errors = json::object();
  for (std::size_t e = 0; e < study.errors.size(); ++e) errors[study.errors[e]] = number_or_null(study.difference[e]);
  return {{"largest_difference", pair_json(study.largest_difference)},
          {"largest_with_tool", pair_json(study.largest_with_tool)},
          {"difference", errors},
          {"drift_adds_rms", pair_json(study.drift_adds)},
          {"drift_leaves_rms", pair_json(study.drift_leaves)},
          {"residual_um", number_or_null(study.residual)},
          {"residual_of_table_um", number_or_null(study.residual_of_table)},
          {"draws", study.draws},
          {"covered_percent", number_or_null(study.covered_percent)}};
}

}  // namespace

void measure_simulate(const MeasureSimulateOptions& options) {
  const Stopwatch clock;
  solver::Case machine_case = open_case(options.case_path, options.size, options.mesh_order);
  metrology::PlanFolder plan = metrology::read_plan(options.plan, machine_case.machine);
  if (options.no_noise) plan.probes.noise = plan.probes.repeatability = 0.0;
  mesh::Machine& machine = machine_case.machine;
  metrology::move_tool_point(machine, plan.tool_offset);
  if (options.machine_seed > 0) machine = compensation::perturbed(machine, options.machine_seed);
  if (!options.hide.empty()) machine = with_hidden(machine, options.hide);
  const solver::LoadProgram load = solver::LoadProgram::read(plan.load, machine);
  metrology::VirtualRunOptions how;
  if (plan.is_rtest) {
    const std::vector<solver::Vector6> none(plan.points.size(), solver::Vector6::Zero());
    how.quantities = metrology::record_of(machine, plan.points, none, 1.0).errors;
  }
  std::map<std::string, double> added;
  for (const std::string& text : options.add) {
    if (!added.insert(metrology::known_error(text)).second)
      throw core::InputError("--add", "'" + text + "'", "each error once");
  }
  if (!added.empty() && !plan.is_rtest && plan.kind != "volumetric_grid")
    throw core::UsageError("--add belongs to an R-Test or a volumetric grid, not to " + plan.kind);
  how.surface = options.surface;
  const solver::FullModel full = build(machine_case, options.out, options.solver);
  core::log_line(fmt::format("simulating {} points of {} on a machine of {} nodes", plan.points.size(), plan.kind,
                             full.mesh.nodes()));
  metrology::VirtualRun run = metrology::run_virtually(full, load, plan.points, how);
  json result = {{"kind", plan.kind},           {"points", plan.points.size()}, {"nodes", full.mesh.nodes()},
                 {"steps", run.load.run.steps}, {"seconds", clock.seconds()},   {"folder", options.out.string()}};
  std::string text;
  if (plan.is_rtest) {
    const RTestStudy study = metrology::study(machine, plan.points, run, plan.probes,
                                              std::max(1e-9, metrology::std_of(plan)), options.draws, options.seed + 1);
    text = study_text(study);
    result["study"] = study_json(study);
  }
  metrology::add_known_errors(machine, plan.points, added, run);
  const double sensor_noise = options.no_noise ? 0.0 : options.sensor_noise_K;
  metrology::write_record(options.out, options.plan, machine, plan, run, sensor_noise, options.seed);
  print_summary(options,
                text + fmt::format("{} points of {} on {} nodes, {:.0f} s; record in {}\n", plan.points.size(),
                                   plan.kind, full.mesh.nodes(), clock.seconds(), options.out.string()),
                result.dump());
}

}  // namespace thermotwin::tools
