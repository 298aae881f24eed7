// SPDX-License-Identifier: GPL-3.0-or-later
// The verb that validates in units. A unit is a machine that is measured virtually on the full model; the gathering
// judges the compensation on all of them, as `validate` does.

#include "tools/validate.h"

#include <fmt/format.h>

#include <cstdint>

#include "compensation/evaluation/measured_machines.h"
#include "compensation/evaluation/validation.h"
#include "core/error.h"
#include "core/file.h"
#include "core/quoted.h"
#include "study/units/resources.h"
#include "tools/chain.h"
#include "tools/page.h"
#include "tools/study/cluster.h"
#include "tools/study/study.h"

namespace thermotwin::tools {
namespace {

namespace fs = std::filesystem;

class ValidateStudy {
public:
  explicit ValidateStudy(const StudyValidateOptions& options)
      : options_(options),
        machine_case_(open_case(options.case_path, "", 0)),
        settings_(validation_settings(options, machine_case_)) {
    compensation::require_check_points(machine_case_);
    settings_.machine.checkpoint_s = options.checkpoint_every_s;
    study_.origin = machine_case_.folder;
    study_.folder = options.out / "study" / "validate";
    study_.units = units();
    study_.command = words();
    study_.compute = [this](std::size_t unit, const fs::path& folder) { return compute(unit, folder); };
    study_.disk_bytes = [this](std::size_t unit) { return disk_bytes(unit); };
    study_.memory = [this](const std::vector<std::size_t>&) {
      const Eigen::Index nodes =
          study::nodes_of_mesh(machine_case_.machine, settings_.machine.size_factor, settings_.machine.mesh_cache);
      return study::MemoryWanted{study::model_bytes(nodes), fmt::format("measured machines of {} nodes", nodes),
                                 "more memory, or a larger --measured-size"};
    };
    study_.gather = [this](const study::Work&) { gather(); };
  }

  void carry_out() {
    open_study(options_.cluster, study_.folder, machine_case_.folder);
    tools::carry_out(options_, options_.cluster, study_);
  }

private:
  std::uint64_t seed_of(std::size_t unit) const { return options_.first_seed + unit; }

  std::vector<study::Unit> units() const {
    const std::string of_case = study::hash_of_case(machine_case_, fmt::format("validate 1 {}", THERMOTWIN_VERSION));
    std::vector<study::Unit> units;
    for (int draw = 0; draw < full_draws(options_); ++draw) {
      compensation::VirtualOptions machine = settings_.machine;
      machine.seed = seed_of(draw);
      std::string inputs = of_case + " " + compensation::words_of_measured(machine_case_, machine);
      for (const compensation::MeasuredLoad& load : measured_loads(options_, machine_case_, settings_, machine.seed))
        inputs += " " + load.program.name() + " " + core::content_hash(load.text);
      units.push_back({core::content_hash(inputs), fmt::format("machine {} (seed {})", draw + 1, machine.seed)});
    }
    return units;
  }

  /// Measurements in the unit's folder, and their copies in measured/.
  double disk_bytes(std::size_t unit) const {
    const mesh::Machine& machine = machine_case_.machine;
    const double channels = 1 + machine.sensors.size() + 3 * machine_case_.check_points.size();
    double rows = 0;
    for (const compensation::MeasuredLoad& load : measured_loads(options_, machine_case_, settings_, seed_of(unit)))
      rows += load.program.output_times().size();
    return 2.0 * study::table_bytes(rows * channels);
  }

  std::string words() const {
    const auto path = [](const char* option, const fs::path& file) {
      return file.empty() ? std::string() : fmt::format(" {} {}", option, core::shell_word(fs::absolute(file)));
    };
    std::string words = fmt::format(
        "study validate {} --checkpoint-every {:g} --draws {} --first-seed {} --perturb {} --measured-size {}",
        core::shell_word(fs::absolute(options_.case_path)), options_.checkpoint_every_s, options_.draws,
        options_.first_seed, options_.perturb, options_.size_factor);
    words += path("--model", options_.model) + path("--truth", options_.reference);
    if (options_.full_draws > 0) words += fmt::format(" --full-draws {}", options_.full_draws);
    if (options_.power_off) words += " --power-off";
    if (options_.restart) words += " --restart";
    if (options_.failed_sensors) words += " --failed-sensors";
    if (options_.coolant_rise) words += " --coolant";
    if (options_.no_noise) words += " --no-noise";
    for (const std::string& load : options_.loads) words += " --load " + core::shell_word(load);
    return words;
  }

  study::UnitFiles compute(std::size_t unit, const fs::path& folder) {
    const fs::path kept = measured_folder(options_);
    compensation::VirtualOptions machine = settings_.machine;
    machine.checkpoints = folder;
    compensation::MeasuredMachines machines(machine_case_, machine, folder / kept, nullptr);
    study::UnitFiles files;
    for (const compensation::MeasuredLoad& load : measured_loads(options_, machine_case_, settings_, seed_of(unit))) {
      machines.measure(seed_of(unit), load);
      const fs::path measured = kept / load.program.name() / fmt::format("machine_{}", seed_of(unit));
      for (const char* file : {"data.csv", "channels.toml", "made_from.txt"}) files.push_back(measured / file);
    }
    return files;
  }

  void gather() {
    const study::Standing standing = study::standing_of(study_.folder, study_.units);
    write_failures(study_, standing);
    for (const std::size_t u : standing.done) study::publish(study_.folder, study_.units[u], options_.out);
    require_none_missing(study_, study::missing_words(study_.units, standing));
    require_none_failed(study_, standing);
    validate(options_);
  }

  const StudyValidateOptions& options_;
  const solver::Case machine_case_;
  compensation::ValidationOptions settings_;
  UnitStudy study_;
};

}  // namespace

void study_validate(const StudyValidateOptions& given) {
  StudyValidateOptions options = given;
  study::part_of(options.cluster.part);
  require_draws(options);
  if (full_draws(options) == 0) {
    throw core::UsageError(
        "study validate: with --truth alone a machine takes seconds and nothing is left for units; use `validate`, or "
        "add --full-draws");
  }
  if (options.model.empty() && fs::exists(options.out / "model.rom.h5")) options.model = options.out / "model.rom.h5";
  if (options.model.empty() && !is_local(options.cluster))
    throw core::UsageError(
        "study validate on several hosts, or with --dry-run, needs --model, or model.rom.h5 in --out");
  ValidateStudy(options).carry_out();
}

}  // namespace thermotwin::tools
