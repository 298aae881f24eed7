// SPDX-License-Identifier: GPL-3.0-or-later
// The verb that holds the machine's model against a measurement.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <optional>

#include "core/error.h"
#include "core/folder_lock.h"
#include "core/units.h"
#include "diagnosis/data/data_diagnosis.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/record/diagnose_options.h"
#include "diagnosis/report/diagnosis_json.h"
#include "diagnosis/report/words.h"
#include "diagnosis/report/write_diagnosis.h"
#include "reduction/model/model_file.h"
#include "solver/campaign/case.h"
#include "tools/accept.h"
#include "tools/chain.h"
#include "tools/measured_model.h"
#include "tools/options.h"
#include "tools/page.h"

namespace thermotwin::tools {
namespace {

constexpr std::size_t shown_explanations = 5;

/// @throws InputError for a record that is given twice: it would count twice
std::vector<compensation::Measurement> read_records(const std::vector<std::filesystem::path>& data) {
  std::vector<compensation::Measurement> records;
  for (std::size_t k = 0; k < data.size(); ++k) {
    records.push_back(compensation::read_measurement(data[k]));
    for (std::size_t other = 0; other < k; ++other) {
      if (std::filesystem::equivalent(data[k], data[other]))
        throw core::InputError("--data " + data[k].string(), "the same record twice", "each record once");
    }
  }
  return records;
}

/// @throws InputError where a model or case lies in the folder that the result replaces
void require_kept(const DiagnoseOptions& options, const std::filesystem::path& folder) {
  for (const auto& read : {options.model, options.case_path}) {
    std::error_code ignored;
    const auto place = std::filesystem::is_directory(read, ignored) ? read : read.parent_path();
    if (!read.empty() && std::filesystem::equivalent(place, folder / "extended", ignored))
      throw core::InputError(read.string(), "an earlier result in the folder that this diagnosis would overwrite",
                             "another folder as --out");
  }
}

/// How much of each of several records is left unexplained.
std::string records_in_words(const diagnosis::Diagnosis& result) {
  std::string text;
  for (std::size_t k = 0; k < result.records.size(); ++k) {
    const diagnosis::DiagnosedRecord& record = result.records[k];
    text += fmt::format("record {}: {:.1f} h, held-out data from {:.1f} h on", record.name,
                        (record.to_s - record.from_s) / core::units::hour,
                        (record.heldout_from_s - record.from_s) / core::units::hour);
    if (record.rms_before_um > 0.0) {
      text += fmt::format("; TCP residual on them {:.2f} um before, {:.2f} um after", record.rms_before_um,
                          record.rms_after_um);
    }
    text += "\n";
  }
  return text;
}

/// Without a machine.
diagnosis::Diagnosis diagnose_record(const DiagnoseOptions& options, std::vector<compensation::Measurement>& records,
                                     const std::filesystem::path& folder) {
  if (options.displacement_error_percent || options.temperature_error_percent)
    throw core::UsageError("--displacement-error and --temperature-error describe a mesh; they need a CASE or --model");
  if (records.size() > 1)
    throw core::UsageError("several --data are records of one machine; they need a CASE or --model");
  keep_plausible(records.front(), {});
  diagnosis::Diagnosis result = diagnosis::diagnose_data(records.front(), {});
  diagnosis::write_diagnosis(folder, result, steps_after(result, "", options.data, "", options.out));
  return result;
}

}  // namespace

void diagnose(const DiagnoseOptions& options) {
  require_acceptable(options);
  std::vector<compensation::Measurement> records = read_records(options.data);
  const auto folder = options.out / "diagnosis";
  require_kept(options, folder);
  const core::FolderLock lock(folder);
  diagnosis::DiagnoseOptions how;
  how.displacement_error_percent = options.displacement_error_percent;
  how.temperature_error_percent = options.temperature_error_percent;
  diagnosis::Diagnosis result;
  std::string accepted;
  const bool without_machine = options.case_path.empty() && options.model.empty();
  if (without_machine) {
    result = diagnose_record(options, records, folder);
  } else {
    const reduction::ReducedModel model = model_of(records.front(), options.case_path, options.model, options.out);
    for (std::size_t k = 1; k < records.size(); ++k) require_measured_on(model.machine, records[k]);
    if (options.case_path.empty()) {
      result = diagnosis::diagnose(model, records, how);
      diagnosis::write_diagnosis(folder, result, model, {},
                                 steps_after(result, "", options.data, options.model, options.out));
    } else {
      const solver::Case machine_case = solver::read_case(options.case_path);
      how.programs = programs_of(machine_case, model.machine);
      result = diagnosis::diagnose(model, records, how);
      diagnosis::write_diagnosis(folder, result, model, scene_of(machine_case.machine, result, options.out / "cache"),
                                 steps_after(result, options.case_path, options.data, options.model, options.out));
      if (!options.accept.empty()) accepted = accept_extension(options, folder, result, model, records, how);
    }
  }
  std::string text = result.sentence + "\n" + records_in_words(result);
  for (const std::string& action : result.actions) text += "to do: " + action + "\n";
  if (!result.next.channel.empty() && !without_machine) {
    text += fmt::format("next measurement: {} under {} ({:.3g} h); {}.\n", result.next.channel, result.next.load,
                        result.next.duration_h, result.next.why);
  }
  for (const std::string& warning : result.warnings) text += "warning: " + warning + "\n";
  for (std::size_t i = 0; i < std::min(result.explanations.size(), shown_explanations); ++i) {
    const diagnosis::Explanation& one = result.explanations[i];
    text += fmt::format("  {:5.1f} %  {}\n", 100 * one.probability, one.name);
  }
  // Each channel without a machine has a ranking of its own.
  for (const diagnosis::RankedCause& cause : result.ranking) {
    if (without_machine && cause.probability >= 0.01) {
      text += fmt::format("  {:5.1f} %  {} {}\n", 100 * cause.probability, name_of(cause.parameter.kind),
                          cause.parameter.where);
    }
  }
  const bool is_corrected =
      result.verdict != diagnosis::Verdict::no_discrepancy && result.verdict != diagnosis::Verdict::unexplained;
  if (without_machine ? result.causes.empty() : !is_corrected)
    text += fmt::format("{} on held-out data: {:.2f} um\n", without_machine ? "residual" : "TCP residual",
                        result.heldout_rms_before_um);
  else {
    text += fmt::format("{} on held-out data: {:.2f} um before, {:.2f} um after ({} %, 95 % interval {} to {} %)\n",
                        without_machine ? "residual" : "TCP residual", result.heldout_rms_before_um,
                        result.heldout_rms_after_um, diagnosis::percent_text(result.reduction_percent),
                        diagnosis::percent_text(result.ci95_low_percent),
                        diagnosis::percent_text(result.ci95_high_percent));
  }
  text += accepted;
  text += fmt::format("report: {}\n", (folder / "report.html").string());
  print_summary(options, text, diagnosis::diagnosis_json(result));
}

}  // namespace thermotwin::tools
