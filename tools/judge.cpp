// SPDX-License-Identifier: GPL-3.0-or-later
// The verbs that hold a model against measurements: evaluate, diagnose, validate.

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include <algorithm>

#include "compensation/evaluate.h"
#include "compensation/validation.h"
#include "core/error.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/grey_box.h"
#include "tools/chain.h"
#include "tools/options.h"

namespace thermotwin::tools {
namespace {

std::string evaluate_instead(const std::filesystem::path& data) {
  return "; for data that belong to no machine model leave CASE and --model away: thermotwin evaluate --data " + data.string() +
         " or thermotwin diagnose --data " + data.string();
}

/// @throws InputError unless the measurement is one of the machine
void require_measured_on(const mesh::Machine& machine, const compensation::Measurement& measurement) {
  const bool names_machine = std::any_of(measurement.channels.begin(), measurement.channels.end(),
                                         [](const auto& channel) { return !channel.quantity.empty() || !channel.input.empty(); });
  try {
    compensation::require_fits(measurement, machine);
  } catch (const core::InputError& error) {
    if (names_machine) throw;
    throw core::InputError(std::string(error.what()) + evaluate_instead(measurement.folder));
  }
}

/// The reduced model of the verb; a measurement that does not fit is refused before any long work.
reduction::ReducedModel model_of(const compensation::Measurement& measurement, const std::filesystem::path& case_path,
                                 const std::filesystem::path& model, const std::filesystem::path& out) {
  if (model.empty()) require_measured_on(open_case(case_path, "", 0).machine, measurement);
  reduction::ReducedModel made = model_for(case_path, model, out);
  require_measured_on(made.machine, measurement);
  return made;
}

}  // namespace

void evaluate(const EvaluateOptions& options) {
  const compensation::Measurement measurement = compensation::read_measurement(options.data);
  compensation::EvaluateOptions settings;
  settings.train_until_s = 3600.0 * options.train_until_h;
  const bool has_model = !options.model.empty() || !options.case_path.empty();
  compensation::Evaluation evaluation;
  if (has_model) {
    const reduction::ReducedModel model = model_of(measurement, options.case_path, options.model, options.out);
    evaluation = compensation::evaluate(measurement, &model, settings);
  } else {
    evaluation = compensation::evaluate(measurement, nullptr, settings);
  }
  const auto file = options.out / "evaluation" / "predictions.csv";
  core::write_csv(file, evaluation.predictions);
  nlohmann::json json = {{"predictions", file.string()}};
  for (const auto& row : evaluation.rows)
    json["rows"].push_back({{"model", row.model}, {"channel", row.channel}, {"part", row.part}, {"unit", row.unit},
                            {"fit", row.measures.fit}, {"peak_to_peak", row.measures.peak_to_peak},
                            {"rms", row.measures.rms}, {"rms_before", row.measures.rms_before},
                            {"rms_reduction_percent", row.measures.rms_reduction_percent}});
  json["notes"] = evaluation.notes;
  print_summary(options, fmt::format("{}\npredictions in {}\n", evaluation.brief(), file.string()), json.dump());
}

void diagnose(const DiagnoseOptions& options) {
  const compensation::Measurement measurement = compensation::read_measurement(options.data);
  const auto folder = options.out / "diagnosis";
  diagnosis::Diagnosis result;
  if (options.case_path.empty() && options.model.empty()) {
    result = diagnosis::diagnose_data(measurement, {});
    diagnosis::write_diagnosis(folder, result);
  } else {
    const reduction::ReducedModel model = model_of(measurement, options.case_path, options.model, options.out);
    result = diagnosis::diagnose(model, measurement, {});
    diagnosis::write_diagnosis(folder, result, model);
  }
  std::string text = result.sentence + "\n";
  for (std::size_t i = 0; i < result.ranking.size() && i < 5; ++i)
    text += fmt::format("  {:5.1f} %  {} {}\n", 100 * result.ranking[i].probability,
                        result.ranking[i].parameter.kind, result.ranking[i].parameter.where);
  text += fmt::format("TCP residual on held-out time: {:.2f} um before, {:.2f} um after ({:.0f} %, 95 % interval {:.0f} to {:.0f} %)\n",
                      result.heldout_rms_before_um, result.heldout_rms_after_um, result.reduction_percent,
                      result.ci95_low_percent, result.ci95_high_percent);
  text += fmt::format("report: {}\n", (folder / "report.html").string());
  print_summary(options, text, diagnosis::diagnosis_json(result));
}

void validate(const ValidateOptions& options) {
  const solver::Case machine_case = open_case(options.case_path, "", 0);
  const reduction::ReducedModel model = model_for(options.case_path, options.model, options.out);
  compensation::ValidationOptions settings;
  settings.loads = options.loads.empty() ? machine_case.holdout : options.loads;
  settings.draws = options.draws;
  settings.machine.size_factor = options.size_factor;
  settings.machine.mesh_cache = options.out / "cache";
  const Stopwatch time;
  const compensation::Validation validation = compensation::validate_online(machine_case, model, settings);
  nlohmann::json json = {{"draws", options.draws}, {"measured_nodes", validation.measured_nodes}};
  for (const auto& row : validation.rows)
    json["rows"].push_back({{"load", row.load}, {"draw", row.draw}, {"pose", row.pose},
                            {"rms_before_um", row.rms_before_um}, {"rms_model_um", row.rms_model_um},
                            {"rms_sensors_um", row.rms_sensors_um}});
  for (const std::string& load : settings.loads)
    json["median_reduction_percent"][load] = {{"no_sensors", validation.median_reduction(load, false)},
                                              {"with_sensors", validation.median_reduction(load, true)}};
  print_summary(options,
                fmt::format("{}\nmeasured machines: {} nodes; model: {}; {:.0f} s, peak memory {:.2f} GiB\n",
                            validation.brief(), validation.measured_nodes, model.size, time.seconds(),
                            peak_memory_GiB()),
                json.dump());
}

}  // namespace thermotwin::tools
