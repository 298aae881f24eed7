// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/accept.h"

#include <fmt/format.h>

#include "compensation/evaluation/evaluate.h"
#include "core/error.h"
#include "diagnosis/diagnose.h"
#include "reduction/model/model_file.h"
#include "solver/campaign/case.h"

namespace thermotwin::tools {

namespace fs = std::filesystem;

namespace {

/// The case with another machine: written beside its place and then moved there, so that it appears whole.
void copy_case(const fs::path& from, const fs::path& machine_name, const fs::path& extended, const fs::path& to) {
  fs::path part = to;
  part += ".part";
  fs::remove_all(part);
  if (to.has_parent_path()) fs::create_directories(to.parent_path());
  fs::copy(from, part, fs::copy_options::recursive);
  fs::copy(extended / "machine.toml", part / machine_name, fs::copy_options::overwrite_existing);
  if (fs::is_directory(extended / "cad")) {
    fs::copy(extended / "cad", part / machine_name.parent_path() / "cad",
             fs::copy_options::recursive | fs::copy_options::overwrite_existing);
  }
  fs::rename(part, to);
}

}  // namespace

void require_acceptable(const DiagnoseOptions& options) {
  if (options.accept.empty()) return;
  if (options.case_path.empty())
    throw core::InputError("--accept " + options.accept.string(), "no case to copy", "diagnose CASE --data DIR");
  if (fs::exists(options.accept))
    throw core::InputError("--accept " + options.accept.string(), "a folder that exists", "a new folder");
  const fs::path folder = fs::is_directory(options.case_path) ? options.case_path : options.case_path.parent_path();
  const fs::path from_case = fs::weakly_canonical(options.accept).lexically_relative(fs::weakly_canonical(folder));
  if (!from_case.empty() && *from_case.begin() != "..")
    throw core::InputError("--accept " + options.accept.string(), "a folder inside of the case",
                           "a new folder outside of " + folder.string());
}

std::string accept_extension(const DiagnoseOptions& options, const fs::path& diagnosis_folder,
                             const diagnosis::Diagnosis& diagnosed, const reduction::ReducedModel& nominal,
                             const std::vector<compensation::Measurement>& records,
                             const diagnosis::DiagnoseOptions& how) {
  if (diagnosed.extended_machine_text.empty())
    return "accepted: nothing, since no extension is recommended; no case was written\n";
  const solver::Case machine_case = solver::read_case(options.case_path);
  const fs::path extended = diagnosis_folder / "extended";
  copy_case(machine_case.folder, fs::relative(machine_case.machine.path, machine_case.folder), extended,
            options.accept);
  const reduction::ReducedModel model = reduction::read_model(extended / "model.rom.h5");
  std::string text = fmt::format("accepted: {} is a copy of the case with the extended machine\n",
                                 (options.accept / "case.toml").string());
  text += "diagnosed again with the extended model: " + diagnosis::diagnose(model, records, how).sentence + "\n";
  compensation::EvaluateOptions settings;
  settings.extended = &model;
  settings.models = {"static_regression"};
  for (const compensation::Measurement& record : records) {
    const std::string of = records.size() > 1 ? " on " + record.folder.filename().string() : "";
    try {
      text += "compensation with the nominal and the extended model" + of + ":\n" +
              compensation::evaluate(record, &nominal, settings).brief();
    } catch (const core::InputError& error) {
      text += "compensation was not evaluated" + of + ": " + error.what() + "\n";
    }
  }
  return text;
}

}  // namespace thermotwin::tools
