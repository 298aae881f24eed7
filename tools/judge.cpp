// SPDX-License-Identifier: GPL-3.0-or-later
// The verbs that hold the machine's model against measurements: diagnose, validate.

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include <optional>

#include "compensation/validation.h"
#include "core/error.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/grey_box.h"
#include "diagnosis/words.h"
#include "reduction/model_file.h"
#include "tools/chain.h"
#include "tools/measured_model.h"
#include "tools/options.h"

namespace thermotwin::tools {

void diagnose(const DiagnoseOptions& options) {
  const compensation::Measurement measurement = compensation::read_measurement(options.data);
  const auto folder = options.out / "diagnosis";
  diagnosis::DiagnoseOptions how;
  how.displacement_error_percent = options.displacement_error_percent.value_or(how.displacement_error_percent);
  how.temperature_error_percent = options.temperature_error_percent.value_or(how.temperature_error_percent);
  diagnosis::Diagnosis result;
  if (options.case_path.empty() && options.model.empty()) {
    if (options.displacement_error_percent || options.temperature_error_percent)
      throw core::UsageError("--displacement-error and --temperature-error are of a mesh: a case or --model is needed");
    result = diagnosis::diagnose_data(measurement, {});
    diagnosis::write_diagnosis(folder, result);
  } else {
    const reduction::ReducedModel model = model_of(measurement, options.case_path, options.model, options.out);
    if (options.case_path.empty()) {
      result = diagnosis::diagnose(model, measurement, how);
      diagnosis::write_diagnosis(folder, result, model);
    } else {
      const solver::Case machine_case = solver::read_case(options.case_path);
      how.programs = programs_of(machine_case, model.machine);
      result = diagnosis::diagnose(model, measurement, how);
      diagnosis::write_diagnosis(folder, result, model, scene_of(machine_case.machine, result, options.out / "cache"));
    }
  }
  std::string text = result.sentence + "\n";
  for (const std::string& warning : result.warnings) text += "warning: " + warning + "\n";
  for (std::size_t i = 0; i < result.ranking.size() && i < 5; ++i)
    text += fmt::format("  {:5.1f} %  {} {}\n", 100 * result.ranking[i].probability,
                        result.ranking[i].parameter.kind, result.ranking[i].parameter.where);
  text += fmt::format("TCP residual on held-out time: {:.2f} um before, {:.2f} um after ({} %, 95 % interval {} to {} %)\n",
                      result.heldout_rms_before_um, result.heldout_rms_after_um, diagnosis::percent_text(result.reduction_percent),
                      diagnosis::percent_text(result.ci95_low_percent), diagnosis::percent_text(result.ci95_high_percent));
  text += fmt::format("report: {}\n", (folder / "report.html").string());
  print_summary(options, text, diagnosis::diagnosis_json(result));
}

void validate(const ValidateOptions& options) {
  const solver::Case machine_case = open_case(options.case_path, "", 0);
  const reduction::ReducedModel model = model_for(options.case_path, options.model, options.out);
  compensation::ValidationOptions settings;
  settings.loads = options.loads.empty() ? machine_case.holdout : options.loads;
  settings.draws = options.draws;
  settings.first_seed = options.first_seed;
  settings.machine.size_factor = options.size_factor;
  settings.machine.mesh_cache = options.out / "cache";
  settings.machine.what = options.perturb == "thermal" ? compensation::Perturb::thermal : compensation::Perturb::all;
  settings.keep = options.out / "measured" / options.perturb;
  std::optional<reduction::ReducedModel> reference;
  if (!options.reference.empty()) {
    reference = reduction::read_model(options.reference);
    settings.reference = &*reference;
    settings.keep = options.out / "measured" / "reduced";
    settings.machine.what = compensation::Perturb::thermal;  // all that its coefficients can be
  }
  const Stopwatch time;
  nlohmann::json json = {{"draws", options.draws}, {"perturbed", options.perturb}};
  std::string text;
  Eigen::Index nodes = 0;
  if (options.power_off) {
    const compensation::PowerOffStudy study = compensation::study_power_off(machine_case, model, settings);
    nodes = study.measured_nodes;
    for (const auto& row : study.rows)
      json["rows"].push_back({{"draw", row.draw}, {"off_h", row.off_h}, {"before_um", row.before_um}, {"left_um", row.left_um}});
    json["left_percent_30_min"] = {{"median", compensation::quantile(study.left_percent(1), 0.5)}, {"p90", compensation::quantile(study.left_percent(1), 0.9)}};
    json["left_percent_2_h"] = {{"median", compensation::quantile(study.left_percent(2), 0.5)}, {"p90", compensation::quantile(study.left_percent(2), 0.9)}};
    text = study.brief();
  } else if (options.failed_sensors) {
    const compensation::FailedSensorStudy study = compensation::study_failed_sensors(machine_case, model, settings);
    nodes = study.measured_nodes;
    for (const auto& row : study.rows)
      json["rows"].push_back({{"load", row.load}, {"draw", row.draw}, {"sensor", row.sensor}, {"fault", row.fault}, {"reduction_percent", row.whole_percent},
                              {"reduction_failed_percent", row.failed_percent}, {"named_after_min", row.named_min}});
    text = study.brief();
  } else {
    const compensation::Validation validation = compensation::validate_online(machine_case, model, settings);
    nodes = validation.measured_nodes;
    for (const auto& row : validation.rows)
      json["rows"].push_back({{"load", row.load}, {"draw", row.draw}, {"pose", row.pose},
                              {"rms_before_um", row.rms_before_um}, {"rms_model_um", row.rms_model_um}, {"rms_told_um", row.rms_told_um},
                              {"rms_sensors_um", row.rms_sensors_um}});
    for (const std::string& load : settings.loads) {
      const std::vector<double> with = validation.reductions(load, compensation::With::sensors);
      json["median_reduction_percent"][load] = {{"no_sensors", validation.median_reduction(load, false)},
                                                {"told", compensation::quantile(validation.reductions(load, compensation::With::told), 0.5)},
                                                {"with_sensors", compensation::quantile(with, 0.5)}};
      json["p10_reduction_percent"][load] = compensation::quantile(with, 0.1);
      json["median_cut_percent"][load] = compensation::quantile(validation.cuts(load), 0.5);
    }
    text = validation.brief();
  }
  json["measured_nodes"] = nodes;
  const std::string truth = reference ? fmt::format("reduced models of order {} of the same mesh", reference->system.order()) : fmt::format("{} nodes", nodes);
  print_summary(options,
                fmt::format("{}\nmeasured machines: {}, {} parameters perturbed; model: {}; {:.0f} s, peak memory {:.2f} GiB\n", text, truth,
                            reference ? "thermal" : options.perturb, model.size, time.seconds(), peak_memory_GiB()),
                json.dump());
}

}  // namespace thermotwin::tools
