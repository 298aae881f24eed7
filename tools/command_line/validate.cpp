// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"
#include "tools/options.h"

namespace thermotwin::tools {

void add_validate(CLI::App& app) {
  const auto options = std::make_shared<ValidateOptions>();
  ValidateOptions& validate = *options;
  CLI::App* verb = add_verb(app, "validate",
                            "online validation on machines measured virtually: finer mesh, another time "
                            "scheme, perturbed parameters, noise. Full runs are kept in --out: a stopped study goes on",
                            "thermotwin validate cases/vmc5 --model out/model.rom.h5 --draws 20 --perturb thermal\n"
                            "  thermotwin validate cases/vmc5 --model out/model.rom.h5 --power-off --draws 20 --truth "
                            "out/reference.rom.h5 --full-draws 5",
                            options, &tools::validate);
  verb->add_option("CASE", validate.case_path, "case folder or case.toml")->required();
  verb->add_option("--model", validate.model, "model.rom.h5 (absent: made from the case)");
  verb->add_option("--load", validate.loads, "load programs (absent: the case's holdout list)");
  verb->add_option("--draws", validate.draws, "number of perturbed machines")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  verb->add_option("--first-seed", validate.first_seed, "machine i is drawn with this seed + i")->capture_default_str();
  verb->add_option("--perturb", validate.perturb,
                   "all: every value with std_percent; thermal: powers, films and contact conductances only")
      ->check(CLI::IsMember({"all", "thermal"}))
      ->capture_default_str();
  verb->add_flag(
      "--power-off", validate.power_off,
      "instead of load programs: work at random, hours without power, and a start that knows nothing before");
  verb->add_flag("--failed-sensors", validate.failed_sensors,
                 "each sensor fails in each way (stuck, 2 K off, ten times the noise, absent): what it costs, how soon "
                 "it is named")
      ->excludes("--power-off");
  auto* truth = verb->add_option("--truth", validate.reference,
                                 "reference.rom.h5: machines are its perturbed coefficients instead of full models "
                                 "(seconds; an easier truth)")
                    ->check(CLI::ExistingFile);
  verb->add_option("--full-draws", validate.full_draws,
                   "so many of the machines are measured on full models on a finer mesh too (minutes each), printed "
                   "side by side")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str()
      ->needs(truth);
  verb->add_option("--measured-size", validate.size_factor, "size factor of the measured machine's mesh")
      ->check(CLI::Range(0.05, 2.0))
      ->capture_default_str();
}

}  // namespace thermotwin::tools
