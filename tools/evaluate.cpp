// SPDX-License-Identifier: GPL-3.0-or-later
// The verb evaluate: models on a measurement, as tables, pictures, JSON and a file of the models.

#include "compensation/evaluation/evaluate.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <optional>

#include "compensation/evaluation/plots.h"
#include "compensation/evaluation/result.h"
#include "compensation/models/fitted_model.h"
#include "core/error.h"
#include "core/file.h"
#include "core/units.h"
#include "mesh/machine/plausible_range.h"
#include "reduction/model/model_file.h"
#include "tools/chain.h"
#include "tools/evaluation_page.h"
#include "tools/measured_model.h"
#include "tools/options.h"
#include "tools/page.h"

namespace thermotwin::tools {
namespace {

constexpr long most_lines = 40;  ///< of tables on the terminal

nlohmann::json json_of(const compensation::EvaluationRow& row) {
  const compensation::Measures& m = row.measures;
  return {{"model", row.model},
          {"channel", row.channel},
          {"part", row.segment},
          {"unit", row.unit},
          {"seen_by_fit", row.training},
          {"from_s", row.from_s},
          {"to_s", row.to_s},
          {"count", m.count},
          {"fit", m.fit},
          {"peak_to_peak", m.peak_to_peak},
          {"peak_to_peak_before", m.peak_to_peak_before},
          {"peak_to_peak_reduction_percent", m.peak_to_peak_reduction_percent},
          {"rms", m.rms},
          {"rms_before", m.rms_before},
          {"rms_reduction_percent", m.rms_reduction_percent},
          {"mean", m.mean},
          {"mean_before", m.mean_before},
          {"maximum", m.maximum},
          {"maximum_before", m.maximum_before}};
}

/// A channel id as a file's name.
std::string file_name(const std::string& id) {
  std::string name = id;
  for (char& c : name) {
    if (c == '/' || c == '.' || c == '\\') c = '_';
  }
  return name;
}

void study_lengths(const EvaluateOptions& options, const compensation::Measurement& measurement, nlohmann::json& json,
                   std::string& text) {
  constexpr int lengths = 8, sections = 30;
  const compensation::LengthStudy study =
      compensation::length_study(measurement, options.length_study[0], options.length_study[1], lengths, sections);
  const auto file = options.out / "evaluation" / "length_study.svg";
  core::write_file(file, compensation::length_study_svg(study));
  text += fmt::format("\nlength study of {} on {}, {} sections per length; RMS residual in {}\n", study.model,
                      study.channel, sections, study.unit);
  for (Eigen::Index l = 0; l < study.hours.size(); ++l) {
    const compensation::Quartiles fit = compensation::quartiles(study.fit_rms.row(l)),
                                  rest = compensation::quartiles(study.rest_rms.row(l));
    text += fmt::format("  {:6.1f} h  fit {:.3f} ({:.3f} to {:.3f})  outside {:.3f} ({:.3f} to {:.3f})\n",
                        study.hours[l], fit.median, fit.low, fit.high, rest.median, rest.low, rest.high);
    json["length_study"].push_back({{"hours", study.hours[l]},
                                    {"fit_rms_median", fit.median},
                                    {"fit_rms_quartiles", {fit.low, fit.high}},
                                    {"outside_rms_median", rest.median},
                                    {"outside_rms_quartiles", {rest.low, rest.high}}});
  }
  text += "box plots in " + file.string() + "\n";
}

/// Folders that train are not judged and count once; --also may name the folder of --data.
void require_once(const EvaluateOptions& options) {
  std::vector<std::filesystem::path> known{options.data};
  known.insert(known.end(), options.also.begin(), options.also.end());
  for (const auto& folder : options.train_data) {
    std::error_code ignored;
    for (const auto& other : known) {
      if (std::filesystem::equivalent(folder, other, ignored)) {
        throw core::InputError(folder.string(), "named twice",
                               "each folder once in --train-data, without the folders of --data and --also");
      }
    }
    known.push_back(folder);
  }
}

/// Folders that train or are judged beside the measurement belong to the same machine.
void require_same_machine(const mesh::Machine& machine, std::vector<compensation::Measurement>& folders) {
  for (compensation::Measurement& folder : folders) {
    try {
      require_measured_on(machine, folder);
    } catch (const core::InputError& error) {
      throw core::InputError(
          fmt::format("{}: no record of machine '{}': {}", folder.folder.string(), machine.name, error.what()));
    }
  }
}

void write_tables(const compensation::Evaluation& evaluation, const std::filesystem::path& folder) {
  core::write_csv(folder / "predictions.csv", evaluation.predictions);
  for (const auto& [name, table] : evaluation.other_predictions)
    core::write_csv(folder / ("predictions_" + file_name(name) + ".csv"), table);
  std::string models = "schema = 1\n", explained;
  for (const compensation::FittedModel& model : evaluation.models) {
    models += model.to_toml();
    for (const std::string& line : model.explain()) explained += line + "\n";
  }
  for (const compensation::FittedModel& model : evaluation.models) {
    if (const std::string picture = compensation::step_responses_svg(model); !picture.empty())
      core::write_file(folder / ("step_response_" + model.name() + ".svg"), picture);
    for (const std::string& line : compensation::stability_lines(model)) explained += line + "\n";
  }
  core::write_file(folder / "models.toml", models);
  core::write_file(folder / "models.txt", explained);
  core::write_file(folder / "leaderboard.svg", compensation::leaderboard_svg(evaluation));
  for (const std::string& channel : compensation::scored_channels(evaluation)) {
    core::write_file(folder / (file_name(channel) + ".svg"), compensation::channel_svg(evaluation, channel));
  }
  core::write_file(folder / "tables.txt", evaluation.brief() + evaluation.tables());
  if (!evaluation.observer.empty()) core::write_file(folder / "observer.txt", evaluation.observer);
}

nlohmann::json json_of(const compensation::Evaluation& evaluation) {
  nlohmann::json json = {{"training_hours", evaluation.training_hours}, {"inputs", evaluation.inputs}};
  for (const auto& row : evaluation.rows) json["rows"].push_back(json_of(row));
  for (const auto& standing : evaluation.leaderboard) {
    json["leaderboard"].push_back({{"model", standing.model},
                                   {"channels", standing.channels},
                                   {"rms_reduction_percent", standing.reduction_percent},
                                   {"below_static_regression_percent", standing.against_static_percent},
                                   {"channel_mean_percent", standing.channel_mean_percent},
                                   {"predicted_percent", standing.predicted_percent},
                                   {"seen_by_fit", standing.seen_by_fit},
                                   {"caution", standing.caution}});
  }
  json["notes"] = evaluation.notes;
  if (!evaluation.observer.empty()) json["observer"] = evaluation.observer;
  return json;
}

/// All step responses, and one line about them; empty: no model is a linear filter.
std::string stability(const compensation::Evaluation& evaluation, nlohmann::json& json) {
  std::string slowest, names;
  double longest = -1.0;
  std::size_t count = 0, unstable = 0;
  for (const compensation::FittedModel& model : evaluation.models) {
    for (const auto& channel : model.step_responses()) {
      if (names.find(model.name() + ".svg") == std::string::npos)
        names += (names.empty() ? "" : ", ") + fmt::format("step_response_{}.svg", model.name());
      for (const auto& response : channel.responses) {
        count += 1;
        unstable += response.stable() ? 0 : 1;
        if (response.settling_s > longest) {
          longest = response.settling_s;
          slowest = fmt::format("{} {}, {}", model.name(), channel.channel, response.input);
        }
        json["step_responses"].push_back(
            {{"model", model.name()},
             {"channel", channel.channel},
             {"unit", channel.unit},
             {"input", response.input},
             {"stable", response.stable()},
             {"largest_pole", response.largest_pole},
             {"end", response.end},
             {"settling_h", response.settling_s / core::units::hour},
             {"interval_s", response.interval_s},
             {"values", std::vector<double>(response.values.begin(), response.values.end())}});
      }
    }
  }
  if (count == 0) return {};
  return fmt::format("stability   {} of {} step responses settle, the slowest after {:.3g} h ({}); {}\n",
                     count - unstable, count, longest / core::units::hour, slowest, names);
}

nlohmann::json json_of(const compensation::CrossExperiment& cross) {
  nlohmann::json json = {{"programs", cross.programs}, {"notes", cross.notes}};
  for (const auto& entry : cross.entries) {
    nlohmann::json rows = nlohmann::json::array();
    for (const auto& row : entry.reduction_percent.rowwise())
      rows.push_back(std::vector<double>(row.begin(), row.end()));
    json["models"].push_back({{"model", entry.model}, {"rms_reduction_percent", rows}});
  }
  return json;
}

}  // namespace

void evaluate(const EvaluateOptions& options) {
  compensation::Measurement measurement = compensation::read_measurement(options.data);
  std::vector<compensation::Measurement> others, training_data;
  for (const auto& folder : options.also) others.push_back(compensation::read_measurement(folder));
  for (const auto& folder : options.train_data) training_data.push_back(compensation::read_measurement(folder));
  require_once(options);
  compensation::EvaluateOptions settings{core::units::hour * options.train_until_h, options.train_programs,
                                         options.models, options.check};
  std::optional<reduction::ReducedModel> extended;
  if (!options.extended.empty()) settings.extended = &extended.emplace(reduction::read_model(options.extended));
  for (const std::string& name : options.models) compensation::model_spec(name);
  const auto keep_all_plausible = [&](const mesh::PlausibleRange& range) {
    keep_plausible(measurement, range);
    for (auto* folders : {&others, &training_data})
      for (compensation::Measurement& folder : *folders) keep_plausible(folder, range);
  };
  compensation::Evaluation evaluation;
  if (!options.fitted.empty()) {
    keep_all_plausible({});
    evaluation = compensation::transfer(measurement, compensation::FittedModel::read(options.fitted), settings);
  } else if (!options.model.empty() || !options.case_path.empty()) {
    const reduction::ReducedModel model = model_of(measurement, options.case_path, options.model, options.out);
    require_same_machine(model.machine, others);
    require_same_machine(model.machine, training_data);
    evaluation = compensation::evaluate(measurement, &model, settings, others, training_data);
  } else {
    keep_all_plausible({});
    evaluation = compensation::evaluate(measurement, nullptr, settings, others, training_data);
  }

  const auto folder = options.out / "evaluation";
  write_tables(evaluation, folder);
  nlohmann::json json = json_of(evaluation);
  const std::string predictions = (folder / "predictions.csv").string(), tables = evaluation.tables();
  json["predictions"] = predictions;
  const auto lines = std::count(tables.begin(), tables.end(), '\n');
  std::string text = evaluation.brief();
  text += lines <= most_lines
              ? tables
              : fmt::format("a table for each channel ({} lines) in {}\n", lines, (folder / "tables.txt").string());
  if (!evaluation.observer.empty()) text += "\n" + evaluation.observer;
  text += stability(evaluation, json);
  text += fmt::format("predictions in {}, models in models.toml and models.txt, pictures in *.svg beside it\n",
                      predictions);
  if (options.cross) {
    const compensation::CrossExperiment cross = compensation::cross_experiment(measurement, settings);
    text += "\n" + cross.brief();
    json["cross"] = json_of(cross);
  }
  if (!options.length_study.empty()) study_lengths(options, measurement, json, text);
  write_page(folder / "report.html", [&] { return evaluation_page(options, evaluation); });
  text += fmt::format("page in {}\n", (folder / "report.html").string());
  print_summary(options, text, json.dump());
}

}  // namespace thermotwin::tools
