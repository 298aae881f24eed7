// SPDX-License-Identifier: GPL-3.0-or-later
// The verb that holds the compensator against machines measured virtually: unseen programs, return from a
// power-off, failed sensors; on full models, on a reduced model of larger order, or on both side by side.

#include "tools/validate.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <functional>
#include <optional>

#include "compensation/evaluation/failed_sensors.h"
#include "compensation/evaluation/power_off.h"
#include "compensation/evaluation/restart.h"
#include "compensation/evaluation/validation.h"
#include "core/error.h"
#include "core/text.h"
#include "reduction/model/model_file.h"
#include "solver/campaign/case.h"
#include "tools/chain.h"
#include "tools/options.h"
#include "tools/page.h"
#include "tools/second_mesh.h"
#include "tools/validation_page.h"

namespace thermotwin::tools {
namespace {

using compensation::quantile;
using nlohmann::json;

json results(const compensation::PowerOffStudy& study) {
  json found;
  for (const auto& row : study.rows) {
    found["rows"].push_back({{"draw", row.draw},
                             {"off_h", row.off_h},
                             {"before_um", row.before_um},
                             {"left_um", row.left_um},
                             {"unmoved_um", row.unmoved_um}});
  }
  found["unmoved_directions"] = study.unmoved_directions;
  const char* const moments[] = {"left_percent_return", "left_percent_30_min", "left_percent_2_h"};
  for (int k = 0; k < 3; ++k) {
    found[moments[k]] = {{"median", quantile(study.left_percent(k), 0.5)},
                         {"p90", quantile(study.left_percent(k), 0.9)}};
  }
  return found;
}

json results(const compensation::FailedSensorStudy& study) {
  json found = {{"false_alarms", study.false_alarms()}};
  for (const auto& row : study.rows) {
    found["rows"].push_back({{"load", row.load},
                             {"draw", row.draw},
                             {"sensor", row.sensor},
                             {"fault", row.fault},
                             {"reduction_percent", row.whole_percent},
                             {"reduction_failed_percent", row.failed_percent},
                             {"named_after_min", row.named_min}});
  }
  return found;
}

json results(const compensation::RestartStudy& study) {
  json found;
  for (const auto& row : study.rows) {
    found["rows"].push_back({{"load", row.load},
                             {"draw", row.draw},
                             {"off_at_h", row.off_at_h},
                             {"rms_before_um", row.before_um},
                             {"rms_through_um", row.through_um},
                             {"rms_restarted_um", row.restarted_um},
                             {"rms_restarted_at_once_um", row.at_once_um}});
    found["offset_rate_um_s"] = row.rate_um_s;
  }
  for (const std::string& load : study.loads()) {
    found["ratio"][load] = study.ratio(load);
    found["ratio_at_once"][load] = study.ratio_at_once(load);
  }
  return found;
}

json results(const compensation::Validation& validation) {
  json found;
  for (const auto& row : validation.rows) {
    found["rows"].push_back({{"load", row.load},
                             {"draw", row.draw},
                             {"pose", row.pose},
                             {"rms_before_um", row.rms_before_um},
                             {"rms_model_um", row.rms_model_um},
                             {"rms_told_um", row.rms_told_um},
                             {"rms_sensors_um", row.rms_sensors_um},
                             {"rms_unmoved_um", row.rms_unmoved_um}});
    if (found["median_reduction_percent"].contains(row.load)) continue;
    const std::vector<double> with = validation.reductions(row.load, compensation::With::sensors);
    found["median_reduction_percent"][row.load] = {
        {"no_sensors", validation.median_reduction(row.load, false)},
        {"told", quantile(validation.reductions(row.load, compensation::With::told), 0.5)},
        {"with_sensors", quantile(with, 0.5)}};
    found["p10_reduction_percent"][row.load] = quantile(with, 0.1);
    found["median_cut_percent"][row.load] = quantile(validation.cuts(row.load), 0.5);
    const std::vector<double> moved = validation.moved_reductions(row.load, compensation::With::sensors);
    found["median_reduction_moved_percent"][row.load] = quantile(moved, 0.5);
    found["p10_reduction_moved_percent"][row.load] = quantile(moved, 0.1);
  }
  found["unmoved_directions"] = validation.unmoved_directions;
  return found;
}

/// With a reduced truth all that its coefficients can be.
std::string perturbed_words(const ValidateOptions& options) {
  return options.reference.empty() || options.perturb == "none" ? options.perturb : "thermal";
}

std::string scheme_of(const solver::TimeOptions& time, double refine) {
  return fmt::format("TR-BDF2 with error control, {:.3g} K a step", time.tolerance_K * refine);
}

/// The summaries of several truths, one table: for each of their rows a row of each truth.
std::string side_by_side(const std::vector<std::pair<std::string, compensation::Rows>>& truths) {
  compensation::Rows table{{"truth"}};
  const compensation::Rows& first = truths.front().second;
  table.front().insert(table.front().end(), first.front().begin(), first.front().end());
  for (std::size_t i = 1; i < first.size(); ++i) {
    for (const auto& [truth, rows] : truths) {
      table.push_back({truth});
      table.back().insert(table.back().end(), rows[i].begin(), rows[i].end());
    }
  }
  return core::format_table(table);
}

/// Runs one study on the truths asked for and prints what came of it.
template <class Study>
void on_truths(const ValidateOptions& options, compensation::ValidationOptions settings,
               const reduction::ReducedModel& model,
               const std::function<Study(const compensation::ValidationOptions&)>& run) {
  const Stopwatch time;
  std::optional<reduction::ReducedModel> reference;
  if (!options.reference.empty()) reference = reduction::read_model(options.reference);
  settings.traced_draws = 1;
  std::optional<Study> on_full, on_reduced;
  if (full_draws(options) > 0) {
    compensation::ValidationOptions full = settings;
    full.keep = options.out / measured_folder(options);
    full.draws = full_draws(options);
    on_full = run(full);
  }
  if (reference) {
    settings.reference = &*reference;
    settings.keep = options.out / "measured" / "reduced";
    on_reduced = run(settings);
  }

  const Study& main = on_reduced ? *on_reduced : *on_full;
  json found = results(main);
  found["draws"] = options.draws;
  found["perturbed"] = perturbed_words(options);
  found["measured_nodes"] = on_full ? on_full->measured_nodes : 0;
  std::string text, truth;
  if (on_full) {
    truth = fmt::format("full models, {} nodes, {}", on_full->measured_nodes,
                        scheme_of(settings.machine.time, settings.machine.refine));
    found["time_scheme"] = solver::word(settings.machine.time.scheme);
    found["tolerance_K"] = settings.machine.time.tolerance_K * settings.machine.refine;
    truth += ", on " + about_measured_mesh(model, on_full->measured_nodes);
    found["measured_mesh"] = about_measured_mesh(model, on_full->measured_nodes);
    text += (on_reduced ? "full models\n" : "") + on_full->brief() + "\n";
  }
  if (on_reduced) {
    truth += fmt::format(
        "{}reduced models of order {} of {}, matrix exponentials", on_full ? "; " : "", reference->system.order(),
        reference->size == model.size ? "the judged model's mesh" : "another mesh, " + reference->size);
    text += (on_full ? "reduced models\n" : "") + on_reduced->brief() + "\n";
  }
  if (on_full && on_reduced) {
    found["full"] = results(*on_full);
    found["full"]["draws"] = options.full_draws;
    const std::string nodes = fmt::format("full, {} nodes", on_full->measured_nodes);
    text += side_by_side({{nodes, on_full->summary()},
                          {"reduced, same machines", on_reduced->first(options.full_draws).summary()},
                          {"reduced, all machines", on_reduced->summary()}}) +
            "\n";
  }
  write_page(options.out / "validation" / "report.html", [&] {
    return validation_page({options, model.machine.name, truth, found["perturbed"].get<std::string>()}, main,
                           on_full && on_reduced ? &*on_full : nullptr);
  });
  text += fmt::format("page in {}\n", (options.out / "validation" / "report.html").string());
  print_summary(
      options,
      fmt::format("{}measured machines: {}; {} parameters perturbed; model: {}; {:.0f} s, peak memory {:.2f} GiB\n",
                  text, truth, found["perturbed"].get<std::string>(), model.size, time.seconds(), peak_memory_GiB()),
      found.dump());
}

}  // namespace

void require_draws(const ValidateOptions& options) {
  if (options.full_draws <= options.draws) return;
  throw core::UsageError(
      fmt::format("--full-draws {}: more than the {} machines of --draws", options.full_draws, options.draws));
}

int full_draws(const ValidateOptions& options) {
  return options.reference.empty() ? options.draws : options.full_draws;
}

std::filesystem::path measured_folder(const ValidateOptions& options) {
  return std::filesystem::path("measured") / perturbed_words(options);
}

compensation::ValidationOptions validation_settings(const ValidateOptions& options, const solver::Case& machine_case) {
  compensation::ValidationOptions settings;
  settings.loads = options.loads.empty() ? machine_case.holdout : options.loads;
  settings.draws = options.draws;
  settings.first_seed = options.first_seed;
  settings.rate_um_s = options.rate_um_s;
  settings.machine.size_factor = options.size_factor;
  settings.machine.mesh_cache = options.out / "cache";
  settings.machine.coolant_rise = options.coolant_rise;
  if (options.no_noise) settings.machine.sensor_noise_K = settings.machine.probe_noise_um = 0.0;
  const std::string perturbed = perturbed_words(options);
  settings.machine.what = perturbed == "none"      ? compensation::Perturb::none
                          : perturbed == "thermal" ? compensation::Perturb::thermal
                                                   : compensation::Perturb::all;
  return settings;
}

std::vector<compensation::MeasuredLoad> measured_loads(const ValidateOptions& options, const solver::Case& machine_case,
                                                       const compensation::ValidationOptions& settings,
                                                       std::uint64_t seed) {
  if (options.power_off) return {compensation::power_off_load(machine_case.machine, seed)};
  if (options.restart) return compensation::restart_loads(machine_case, settings);
  if (options.failed_sensors) return compensation::failed_sensor_loads(machine_case, settings);
  return compensation::validation_loads(machine_case, settings);
}

void validate(const ValidateOptions& options) {
  require_draws(options);
  const solver::Case machine_case = open_case(options.case_path, "", 0);
  const compensation::ValidationOptions settings = validation_settings(options, machine_case);
  compensation::require_check_points(machine_case);
  // Refused before a campaign for the model.
  if (!options.power_off) load_programs(machine_case, settings.loads);
  const reduction::ReducedModel model = model_for(options.case_path, options.model, options.out);
  using compensation::ValidationOptions;
  if (options.power_off) {
    on_truths<compensation::PowerOffStudy>(options, settings, model, [&](const ValidationOptions& how) {
      return study_power_off(machine_case, model, how);
    });
  } else if (options.restart) {
    on_truths<compensation::RestartStudy>(options, settings, model, [&](const ValidationOptions& how) {
      return study_restart(machine_case, model, how);
    });
  } else if (options.failed_sensors) {
    on_truths<compensation::FailedSensorStudy>(options, settings, model, [&](const ValidationOptions& how) {
      return study_failed_sensors(machine_case, model, how);
    });
  } else {
    on_truths<compensation::Validation>(options, settings, model, [&](const ValidationOptions& how) {
      return validate_online(machine_case, model, how);
    });
  }
}

}  // namespace thermotwin::tools
