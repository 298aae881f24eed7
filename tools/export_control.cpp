// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/export_control.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>

#include "compensation/control/control_fmu.h"
#include "compensation/control/control_model.h"
#include "compensation/control/control_source.h"
#include "compensation/control/model_order.h"
#include "compensation/control/twin.h"
#include "compensation/linuxcnc/hal_pieces.h"
#include "core/error.h"
#include "core/file.h"
#include "core/text.h"
#include "reduction/model/model_file.h"

namespace thermotwin::tools {
namespace {

namespace fs = std::filesystem;

const char* about_sensors(const tt_model& model) {
  return model.observer != 0 ? "temperature sensors correct it; offsets have standard deviations"
                             : "open loop: without sensors and standard deviations";
}

compensation::ControlModel control_model(const ControlExportOptions& options) {
  compensation::ControlOptions settings;
  settings.compensator.step_s = options.step_s;
  settings.compensator.start_C = options.start_C;
  settings.compensator.largest_um = options.largest_um;
  settings.compensator.rate_um_s = options.rate_um_s;
  settings.tolerance = options.tolerance;
  settings.observer = options.observer;
  settings.start_over_s = options.start_over_s;
  return compensation::ControlModel(compensation::model_of_order(reduction::read_model(options.model), options.order),
                                    settings);
}

void export_c(const ControlExportOptions& options) {
  const compensation::ControlModel control = control_model(options);
  const tt_model& model = control.model();
  std::vector<std::string> names;
  core::write_files_by(options.c_folder, [&](const fs::path& staged) {
    names = compensation::write_control_source(staged, control.data(), model);
    return std::vector<fs::path>(names.begin(), names.end());
  });
  const std::string folder = options.c_folder.string();
  const auto state = tt_twin_state_bytes(&model), work = tt_twin_work_bytes(&model);
  const std::string text = fmt::format(
      "{}: {} states, {} channels, {} offsets as C99 source\n{} files in {}; memory of a twin: {:.1f} kB of state, "
      "{:.1f} MB of work\n{}\n"
      "next: cd {} && cc -std=c99 -O3 -ffp-contract=off *.c -o twin -lm\n",
      model.name, model.order, model.channels, model.linear_axes, names.size(), folder, 1e-3 * state, 1e-6 * work,
      about_sensors(model), folder);
  const nlohmann::json json = {{"folder", folder},
                               {"files", names},
                               {"states", model.order},
                               {"channels", model.channels},
                               {"offsets", model.linear_axes},
                               {"observer", model.observer != 0},
                               {"state_bytes", state},
                               {"work_bytes", work},
                               {"model_hash", fmt::format("{:016x}", model.hash)}};
  print_summary(options, text, json.dump());
}

void export_fmu(const ControlExportOptions& options) {
  if (options.out.extension() != ".fmu")
    throw core::UsageError("--fmu writes one file; allowed: --out FILE.fmu, but it is '" + options.out.string() + "'");
  const compensation::ControlModel control = control_model(options);
  const tt_model& model = control.model();
  compensation::write_fmu(options.out, control.data(), options.fmu);
  const std::string text = fmt::format(
      "{}: {} states, {} inputs, {} offsets as FMU for co-simulation (FMI {}.0)\n{}: {:.1f} MB, for Linux x86-64 and "
      "as "
      "source\n{}\n",
      model.name, model.order, model.channels + (model.observer != 0 ? model.sensors : 0), model.linear_axes,
      options.fmu, options.out.string(), 1e-6 * fs::file_size(options.out), about_sensors(model));
  const nlohmann::json json = {{"fmu", options.out.string()},     {"states", model.order},
                               {"channels", model.channels},      {"offsets", model.linear_axes},
                               {"observer", model.observer != 0}, {"model_hash", fmt::format("{:016x}", model.hash)}};
  print_summary(options, text, json.dump());
}

void export_linuxcnc(const ControlExportOptions& options) {
  const compensation::HalConfig config = compensation::read_hal_config(options.linuxcnc);
  const compensation::ControlModel control = control_model(options);
  const fs::path folder = fs::absolute(options.out).lexically_normal();
  const compensation::HalPieces pieces = compensation::hal_pieces(config, control.data(), folder);
  std::vector<fs::path> names;
  core::write_files_by(folder, [&](const fs::path& staged) {
    return names = compensation::write_linuxcnc(staged, control.data(), control.model(), pieces);
  });
  std::string text = fmt::format("{} for {}: {} files in {}\nlinked: {}\nnot given yet: {}\n", control.model().name,
                                 options.linuxcnc.string(), names.size(), folder.string(), core::join(pieces.linked),
                                 pieces.unlinked.empty() ? "none" : core::join(pieces.unlinked));
  for (const std::string& file : config.unread)
    text += fmt::format("warning: {}; links in it are not known, and HAL refuses to link a pin twice\n", file);
  text += fmt::format("next: README.md in {}\n", folder.string());
  const nlohmann::json json = {{"folder", folder.string()},
                               {"linked", pieces.linked},
                               {"not_given", pieces.unlinked},
                               {"unread", config.unread},
                               {"model_hash", fmt::format("{:016x}", control.model().hash)}};
  print_summary(options, text, json.dump());
}

}  // namespace

void export_any(const ControlExportOptions& options) {
  const bool c = !options.c_folder.empty(), fmu = options.fmu > 0, linuxcnc = !options.linuxcnc.empty();
  if (!c && !fmu && !linuxcnc) return export_model(options);
  const std::array ways = {options.calculix, options.matrices, c, fmu, linuxcnc};
  if (std::count(ways.begin(), ways.end(), true) != 1)
    throw core::UsageError("export needs exactly one of --calculix, --matrices, --c, --fmu and --linuxcnc");
  if (c)
    export_c(options);
  else if (fmu)
    export_fmu(options);
  else
    export_linuxcnc(options);
}

}  // namespace thermotwin::tools
