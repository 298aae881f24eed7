// SPDX-License-Identifier: GPL-3.0-or-later
// The files of a diagnosis, each whole or not at all.

#include "diagnosis/report/write_diagnosis.h"

#include <system_error>
#include <vector>

#include "core/file.h"
#include "diagnosis/causes/machine_text.h"
#include "diagnosis/causes/parameter_sizes.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/report/diagnosis_json.h"
#include "diagnosis/report/report.h"
#include "mesh/machine/file.h"
#include "reduction/model/model_file.h"

namespace thermotwin::diagnosis {

namespace {

/// An extension of an earlier diagnosis would contradict this one.
void remove_extension(const std::filesystem::path& out) {
  std::error_code ignored;
  std::filesystem::remove_all(out / "extended/cad", ignored);
  for (const char* name : {"extended/machine.toml", "extended/model.rom.h5", "extended"})
    std::filesystem::remove(out / name, ignored);
}

/// Series of an earlier diagnosis that this one does not have.
void remove_series(const std::filesystem::path& out, const Diagnosis& diagnosis) {
  std::error_code ignored;
  for (std::size_t i = 0; i < 4; ++i) {
    if (i >= diagnosis.causes.size() || diagnosis.causes[i].series.rows() == 0)
      std::filesystem::remove(out / series_file(i + 1), ignored);
  }
}

/// @param extend  writes further files into the folder and names them
template <class Extend>
void write_files(const std::filesystem::path& out, const Diagnosis& diagnosis, const mesh::Machine* machine,
                 const Scene& scene, const std::vector<core::NextStep>& steps, const Extend& extend) {
  using std::filesystem::path;
  core::write_files_by(out, [&](const path& staged) {
    std::vector<path> files{"residuals.csv", "report.html"};
    core::write_csv(staged / "residuals.csv", diagnosis.series);
    core::write_file(staged / "report.html", report_html(diagnosis, machine, scene, steps));
    for (std::size_t i = 0; i < diagnosis.causes.size(); ++i) {
      if (diagnosis.causes[i].series.rows() > 0) {
        files.emplace_back(series_file(i + 1));
        core::write_csv(staged / files.back(), diagnosis.causes[i].series);
      }
    }
    extend(staged, files);
    // Last: who finds it finds the rest as well.
    core::write_file(staged / "diagnosis.json", diagnosis_json(diagnosis));
    files.emplace_back("diagnosis.json");
    return files;
  });
  remove_series(out, diagnosis);
}

}  // namespace

void write_diagnosis(const std::filesystem::path& out, const Diagnosis& diagnosis, const reduction::ReducedModel& model,
                     const Scene& scene, const std::vector<core::NextStep>& steps) {
  using std::filesystem::path;
  const bool extends = !diagnosis.extended_machine_text.empty();
  write_files(out, diagnosis, &model.machine, scene, steps, [&](const path& staged, std::vector<path>& files) {
    if (!extends) return;
    const path machine_file = path("extended") / "machine.toml", model_file = path("extended") / "model.rom.h5";
    const MovableText movable = movable_text(diagnosis.extended_machine_text, model.machine);
    const reduction::ReducedModel extended =
        model_of_changed(model, mesh::parse_machine(movable.text, std::filesystem::absolute(out / machine_file)));
    for (const auto& [from, to] : movable.files) {
      files.push_back("extended" / to);
      std::filesystem::create_directories((staged / files.back()).parent_path());
      std::filesystem::copy_file(from, staged / files.back());
    }
    core::write_file(staged / machine_file, movable.text);
    reduction::write_model(staged / model_file, extended);
    files.insert(files.end(), {machine_file, model_file});
  });
  if (!extends) remove_extension(out);
}

void write_diagnosis(const std::filesystem::path& out, const Diagnosis& diagnosis,
                     const std::vector<core::NextStep>& steps) {
  write_files(out, diagnosis, nullptr, {}, steps,
              [](const std::filesystem::path&, std::vector<std::filesystem::path>&) {});
  remove_extension(out);
}

}  // namespace thermotwin::diagnosis
