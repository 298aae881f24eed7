// SPDX-License-Identifier: GPL-3.0-or-later
// The files of a diagnosis, each whole or not at all.
#include <system_error>

#include "core/file.h"
#include "diagnosis/diagnose.h"
#include "diagnosis/report.h"
#include "reduction/model_file.h"

namespace thermotwin::diagnosis {

void write_diagnosis(const std::filesystem::path& out, const Diagnosis& diagnosis,
                     const reduction::ReducedModel& model) {
  core::write_csv(out / "residuals.csv", diagnosis.series);
  if (!diagnosis.extended_machine_text.empty()) {
    reduction::ReducedModel extended = model;
    extended.machine = mesh::parse_machine(diagnosis.extended_machine_text, model.machine.path);
    core::write_file(out / "extended" / "machine.toml", diagnosis.extended_machine_text);
    reduction::write_model(out / "extended" / "model.rom.h5", extended);
  } else {
    // An extension of an earlier diagnosis would contradict this one.
    std::error_code ignored;
    std::filesystem::remove(out / "extended" / "machine.toml", ignored);
    std::filesystem::remove(out / "extended" / "model.rom.h5", ignored);
    std::filesystem::remove(out / "extended", ignored);
  }
  core::write_file(out / "report.html", report_html(diagnosis, model.machine));
  // Last: who finds it finds the rest as well.
  core::write_file(out / "diagnosis.json", diagnosis_json(diagnosis));
}

}  // namespace thermotwin::diagnosis
