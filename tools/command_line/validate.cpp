// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/command_line/common.h"
#include "tools/command_line/verbs.h"
#include "tools/options.h"

namespace thermotwin::tools {

void add_validate_options(CLI::App& verb, ValidateOptions& validate) {
  verb.add_option("CASE", validate.case_path, "Case folder or case.toml.")->required();
  verb.add_option("--model", validate.model, "Reduced model model.rom.h5 (default: made from the case).");
  verb.add_option("--load", validate.loads, "Load programs (default: holdout of the case).");
  verb.add_option("--draws", validate.draws,
                  "Number of perturbed machines; full runs are kept in --out, so a repeated study continues.")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  verb.add_option("--first-seed", validate.first_seed, "Seed of the first machine; each further one adds 1 to it.")
      ->check(seeds())
      ->capture_default_str();
  verb.add_option("--perturb", validate.perturb,
                  "Perturbed parameters: all with std_percent; thermal: powers, films and contact conductances; none.")
      ->check(CLI::IsMember({"all", "thermal", "none"}))
      ->capture_default_str();
  verb.add_flag("--power-off", validate.power_off,
                "Study the return from a power-off: random work, hours without power, unknown state at the return.");
  verb.add_flag("--failed-sensors", validate.failed_sensors,
                "Study failed sensors: loss of accuracy and time to detection for each sensor, stuck, 2 K off, noisy "
                "and absent.")
      ->excludes("--power-off");
  auto* restart =
      verb.add_flag(
              "--restart", validate.restart,
              "Study a restart: each load program with an hour off in its midst; the compensator goes on from its "
              "state, beside one that never stopped.")
          ->excludes("--power-off")
          ->excludes("--failed-sensors");
  verb.add_option("--offset-rate", validate.rate_um_s,
                  "With --restart: limit of each offset's rate of change, um/s (default: as of compensate).")
      ->check(positive_number())
      ->needs(restart);
  verb.add_flag("--coolant", validate.coolant_rise,
                "Records of full models also hold the temperature rise of each coolant segment, outflow less inflow.");
  verb.add_flag("--no-noise", validate.no_noise, "Sensors and probes without noise.");
  auto* truth = verb.add_option("--truth", validate.reference,
                                "Reference model reference.rom.h5: with perturbed coefficients it replaces the full "
                                "models as the truth, which takes seconds and is an easier test.")
                    ->check(CLI::ExistingFile);
  verb.add_option(
          "--full-draws", validate.full_draws,
          "Number of machines that are also simulated on full models on a finer mesh (minutes each), for comparison.")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str()
      ->needs(truth);
  verb.add_option("--measured-size", validate.size_factor, "Factor on the element sizes of the virtual machine's mesh.")
      ->check(CLI::Range(0.05, 2.0))
      ->capture_default_str();
}

void add_validate(CLI::App& app) {
  const auto options = std::make_shared<ValidateOptions>();
  ValidateOptions& validate = *options;
  CLI::App* verb = add_verb(app, "validate",
                            "Validates the compensation on virtual machines with a finer mesh, another time scheme, "
                            "perturbed parameters and noise.",
                            "thermotwin validate cases/vmc5 --model out/model.rom.h5 --draws 20 --perturb thermal\n"
                            "  thermotwin validate cases/vmc5 --model out/model.rom.h5 --power-off --draws 20 --truth "
                            "out/reference.rom.h5 --full-draws 5",
                            options, &tools::validate);
  add_validate_options(*verb, validate);
}

}  // namespace thermotwin::tools
