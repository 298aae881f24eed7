// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/evaluation/evaluate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "compensation/evaluation/reduced_models.h"
#include "compensation/evaluation/result.h"
#include "compensation/evaluation/scoring.h"
#include "compensation/evaluation/standings.h"
#include "compensation/measurement/measurement_check.h"
#include "compensation/models/catalogue.h"
#include "compensation/models/fitted_model.h"
#include "core/error.h"
#include "core/range.h"
#include "core/text.h"
#include "core/units.h"

namespace thermotwin::compensation {
namespace {

using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double nothing_trains = -1.0;  // as train_until_s
constexpr std::ptrdiff_t least_training_rows = 3;

void require_displacements(const Measurement& measurement) {
  if (std::none_of(measurement.channels.begin(), measurement.channels.end(),
                   [](const auto& c) { return c.kind == ChannelKind::displacement; })) {
    throw InputError((measurement.folder / "channels.toml").string(), "no channel of kind displacement",
                     "at least one; models are compared on displacements");
  }
  if (const Index rows = measurement.data.rows(); rows < 2) {
    throw InputError(measurement.data.source, fmt::format("{} row{}", rows, rows == 1 ? "" : "s"),
                     "at least two rows; models are judged over time");
  }
  std::vector<std::string> silent;
  for (const MeasuredChannel& channel : measurement.channels) {
    if (channel.kind != ChannelKind::displacement) continue;
    if (known_range(measurement.values(channel)).first >= 0) return;
    silent.push_back(channel.id);
  }
  throw InputError(measurement.data.source, "no value of " + core::join(silent),
                   "values of at least one displacement; models are compared on displacements");
}

void require_channels(const std::vector<std::string>& check, const Measurement& measurement) {
  std::vector<std::string> ids;
  for (const MeasuredChannel& channel : measurement.channels) {
    if (channel.kind == ChannelKind::displacement) ids.push_back(channel.id);
  }
  for (const std::string& id : check) {
    if (std::find(ids.begin(), ids.end(), id) == ids.end()) {
      throw InputError((measurement.folder / "channels.toml").string(), "no displacement channel '" + id + "'",
                       "one of: " + core::join(ids) + " (nearest: " + core::nearest(id, ids) + ")");
    }
  }
}

/// The same channel must mean the same in all folders.
void require_same_channels(const Measurement& measurement, const Measurement& other) {
  for (const MeasuredChannel& channel : other.channels) {
    for (const MeasuredChannel& known : measurement.channels) {
      if (channel.id != known.id || (channel.unit == known.unit && channel.quantity == known.quantity)) continue;
      const auto words = [](const MeasuredChannel& c) {
        return fmt::format("unit \"{}\", {}", c.unit,
                           c.quantity.empty() ? "no quantity" : "quantity \"" + c.quantity + "\"");
      };
      throw InputError((other.folder / "channels.toml").string(),
                       fmt::format("channel '{}': {}", channel.id, words(channel)),
                       fmt::format("{}, as in {}", words(known), measurement.folder.string()));
    }
  }
}

/// What trains comes from the machine that is judged; a folder that states no machine may be of any.
void require_one_machine(const Measurement& judged, const std::vector<Measurement>& training_data) {
  const Measurement* stated = &judged;
  for (const Measurement& training : training_data) {
    require_recorded_on(training, stated->machine, stated->folder.string());
    if (stated->machine.empty()) stated = &training;
  }
}

/// Rows of the channels that the measurement has: others cannot be compared.
void add_rows(const std::vector<EvaluationRow>& rows, const Scorer& scorer, Evaluation& result) {
  for (const EvaluationRow& row : rows) {
    if (std::any_of(scorer.data().targets.begin(), scorer.data().targets.end(),
                    [&](const MeasuredChannel& c) { return c.id == row.channel; }))
      result.rows.push_back(row);
  }
}

/// Names of folders, with a number where an earlier one has the name: rows and files of two must not be taken for one.
std::vector<std::string> names_of(const std::vector<Measurement>& folders, std::set<std::string>& known) {
  std::vector<std::string> names;
  for (const Measurement& folder : folders) {
    const std::string own = std::filesystem::weakly_canonical(folder.folder).filename().string();
    std::string name = own;
    for (int i = 2; !known.insert(name).second; ++i) name = fmt::format("{}_{}", own, i);
    names.push_back(std::move(name));
  }
  return names;
}

/// Another folder is judged as a whole, or by its programs.
std::vector<EvaluationSegment> segments_of_other(const Measurement& other, const std::string& name, bool training) {
  std::vector<EvaluationSegment> segments;
  for (const Program& program : other.programs)
    segments.push_back({name + "/" + program.name, program.from_s, program.to_s, training});
  if (segments.empty()) {
    segments.push_back(
        {name, -std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), training});
  }
  return segments;
}

void score_machine(const Measurement& measurement, const reduction::ReducedModel* model, const std::string& name,
                   Scorer& scorer) {
  if (model == nullptr) return;
  score_reduced_model(measurement, *model, name, false, scorer);
  const bool any_sensor = std::any_of(measurement.channels.begin(), measurement.channels.end(),
                                      [](const MeasuredChannel& channel) { return !channel.sensor.empty(); });
  if (any_sensor) score_reduced_model(measurement, *model, name, true, scorer);
}

double training_hours(const Scorer& scorer) {
  double hours = 0.0;
  for (const EvaluationSegment& segment : scorer.segments()) {
    double first = std::numeric_limits<double>::infinity(), last = -first;
    for (Index i = 0; segment.training && i < scorer.data().rows(); ++i) {
      const double time = scorer.data().time[i];
      if (time < segment.from || time >= segment.to) continue;
      first = std::min(first, time);
      last = std::max(last, time);
    }
    if (last > first) hours += (last - first) / core::units::hour;
  }
  return hours;
}

/// ISO 230-3 warms a machine up for four hours; a model fitted on less has hardly seen it settle.
void note_short_training(Evaluation& result) {
  constexpr double least_hours = 4.0;
  if (!result.models.empty() && result.training_hours < least_hours) {
    result.notes.push_back(
        fmt::format("fitted on only {:.1f} h; the tests of ISO 230-3 last {:.0f} h, and slower parts of the machine "
                    "have not settled by then",
                    result.training_hours, least_hours));
  }
}

}  // namespace

void EvaluateOptions::validate() const {
  core::require_option(!std::isnan(train_until_s), "evaluate train_until_s", train_until_s,
                       "seconds from the first row, 0 (automatic) or below 0 (nothing trains)");
  for (const std::string& name : models) model_spec(name);
}

Evaluation evaluate(const Measurement& measurement, const reduction::ReducedModel* model,
                    const EvaluateOptions& options, const std::vector<Measurement>& others,
                    const std::vector<Measurement>& training_data) {
  options.validate();
  require_displacements(measurement);
  require_channels(options.check, measurement);
  for (const Measurement& other : others) require_displacements(other);
  for (const Measurement& other : training_data) require_displacements(other);
  require_one_machine(measurement, training_data);
  std::vector<const Measurement*> all{&measurement};
  for (const auto* more : {&others, &training_data}) {
    for (const Measurement& other : *more) {
      for (const Measurement* known : all) require_same_channels(*known, other);
      all.push_back(&other);
    }
  }
  EvaluateOptions own = options;
  // Whoever brings training data wants the measurement judged, but for what is said to train.
  if (!training_data.empty() && own.train_until_s == 0.0) own.train_until_s = nothing_trains;
  Scorer scorer(measurement, segments_of(measurement, own));
  std::vector<Scorer> other_scorers, training_scorers;
  std::set<std::string> known;
  const std::vector<std::string> names = names_of(others, known), training_names = names_of(training_data, known);
  for (std::size_t i = 0; i < others.size(); ++i)
    other_scorers.emplace_back(others[i], segments_of_other(others[i], names[i], false));
  for (std::size_t i = 0; i < training_data.size(); ++i)
    training_scorers.emplace_back(training_data[i], segments_of_other(training_data[i], training_names[i], true));

  Evaluation result;
  const TrainingRows rows = training_rows(scorer, training_scorers);
  const std::vector<bool> training = scorer.training();
  const auto trained = std::count(training.begin(), training.end(), true);
  if (own.train_until_s > 0.0 && trained < least_training_rows) {
    throw core::InputError(
        "--train-until",
        fmt::format("{:.4g} h, before which there are {} rows", own.train_until_s / core::units::hour, trained),
        fmt::format("a time with {} rows or more before it", least_training_rows));
  }
  if (others.empty() && std::all_of(training.begin(), training.end(), [](bool t) { return t; })) {
    scorer.note("all data are training data; the leaderboard shows the fit, not a prediction of held-out data");
  }
  Index incomplete = 0;
  for (Index i = 0; i < scorer.data().rows(); ++i) incomplete += !scorer.data().input_values.row(i).allFinite();
  if (incomplete > 0)
    scorer.note(fmt::format("{} rows lack an input; models that need it skip these rows", incomplete));
  std::vector<std::string> silent;
  for (const MeasuredChannel& channel : measurement.channels)
    if (known_range(measurement.values(channel)).first < 0) silent.push_back(channel.id);
  if (!silent.empty()) scorer.note("without any value in the record: " + core::join(silent));
  for (const ModelSpec* spec : chosen_models(options)) {
    FittedModel fitted(*spec);
    if (!fit_and_score(fitted, options.check, rows, scorer, training_scorers)) continue;
    for (Scorer& other : other_scorers) other.add(fitted.name(), fitted.predict(other.data()), false);
    result.models.push_back(std::move(fitted));
  }
  for (const auto& [name, machine] : {std::pair{"reduced_model", model}, {"extended_model", options.extended}}) {
    score_machine(measurement, machine, name, scorer);
    for (std::size_t i = 0; i < others.size(); ++i) score_machine(others[i], machine, name, other_scorers[i]);
    // A channel that no fit may use is judged in the training folders as well.
    for (std::size_t i = 0; i < training_data.size() && !options.check.empty(); ++i)
      score_machine(training_data[i], machine, name, training_scorers[i]);
  }

  result.predictions = scorer.predictions();
  result.rows = std::move(scorer.rows);
  result.notes = std::move(scorer.notes);
  result.observer = std::move(scorer.observer);
  result.training_hours = training_hours(scorer);
  result.inputs = scorer.data().input_values.cols();
  for (std::size_t i = 0; i < others.size(); ++i) {
    result.other_predictions.emplace_back(names[i], other_scorers[i].predictions());
    add_rows(other_scorers[i].rows, scorer, result);
  }
  for (const Scorer& other : training_scorers) {
    result.training_hours += training_hours(other);
    add_rows(other.rows, scorer, result);
  }
  note_short_training(result);
  // A channel that no fit may use is held out in every segment.
  for (EvaluationRow& row : result.rows) {
    if (std::find(options.check.begin(), options.check.end(), row.channel) != options.check.end()) row.training = false;
  }
  result.leaderboard = standings(result.rows, result.models);
  for (std::string& sentence : worsened_by_sensors(result.leaderboard)) result.notes.push_back(std::move(sentence));
  return result;
}

Evaluation transfer(const Measurement& measurement, std::vector<FittedModel> models, const EvaluateOptions& options) {
  options.validate();
  require_displacements(measurement);
  Scorer scorer(measurement, segments_of(measurement, options));
  for (FittedModel& model : models) {
    const MatrixXd as_is = model.predict(scorer.data());
    if (known_range(as_is.reshaped()).first < 0) {
      scorer.note(model.name() + " left out: it predicts none of these channels from the inputs present");
      continue;
    }
    scorer.add(model.name() + "_as_is", as_is, false);
    scorer.note(model.name() + " corrected: " + model.correct(scorer.data(), scorer.training()));
    scorer.add(model.name() + "_corrected", model.predict(scorer.data()), true);
  }
  Evaluation result;
  result.predictions = scorer.predictions();
  result.rows = std::move(scorer.rows);
  result.notes = std::move(scorer.notes);
  result.training_hours = training_hours(scorer);
  result.inputs = scorer.data().input_values.cols();
  result.models = std::move(models);
  result.leaderboard = standings(result.rows, result.models);
  return result;
}

CrossExperiment cross_experiment(const Measurement& measurement, const EvaluateOptions& options) {
  options.validate();
  require_displacements(measurement);
  Measurement cut = measurement;
  if (cut.programs.empty()) {
    EvaluateOptions by_day;
    by_day.train_until_s = nothing_trains;  // every day is a segment of its own
    for (const EvaluationSegment& segment : segments_of(measurement, by_day)) {
      if (!segment.training) cut.programs.push_back({segment.name, segment.from, segment.to});
    }
  }
  CrossExperiment cross;
  for (const Program& program : cut.programs) cross.programs.push_back(program.name);
  const auto n = std::ssize(cross.programs);
  if (n < 2) {
    throw InputError(measurement.folder.string(), fmt::format("{} program or day", n),
                     "at least two: one to fit, another to judge");
  }
  for (const ModelSpec* spec : chosen_models(options)) {
    CrossExperiment::Entry entry{spec->name, MatrixXd::Constant(n, n, std::numeric_limits<double>::quiet_NaN())};
    for (Index from = 0; from < n; ++from) {
      EvaluateOptions one = options;
      one.train_programs = {cross.programs[from]};
      Scorer scorer(cut, segments_of(cut, one));
      FittedModel model(*spec);
      std::vector<Scorer> none;
      const bool fitted = fit_and_score(model, options.check, training_rows(scorer), scorer, none);
      // A fit that runs away in one channel is refused as a whole: the others alone would look better than it is.
      for (const std::string& reason : model.refused())
        cross.notes.push_back("fitted on " + cross.programs[from] + ", refused: " + reason);
      if (!fitted || !model.refused().empty()) continue;
      for (Index to = 0; to < n; ++to) {
        std::map<std::string, JudgedChannel> channels;
        for (const EvaluationRow& row : scorer.rows)
          if (row.segment == cross.programs[to]) channels[row.channel].add(row, &row);
        entry.reduction_percent(from, to) = removed_percent(channels);
      }
    }
    if (entry.reduction_percent.array().isFinite().any()) cross.entries.push_back(std::move(entry));
  }
  return cross;
}

LengthStudy length_study(const Measurement& measurement, const std::string& name, const std::string& channel,
                         int lengths, int sections) {
  require_channels({channel}, measurement);
  if (lengths < 2 || sections < 2)
    throw InputError("length study", fmt::format("{} lengths, {} sections", lengths, sections), "at least 2 each");
  Dataset data = make_dataset(measurement);
  std::size_t target = 0;
  while (data.targets[target].id != channel) ++target;
  const auto [first, last] = known_range(data.target_values.col(target));
  if (first < 0 || first == last) {
    throw InputError(measurement.folder.string(), "channel '" + channel + "' without rows",
                     "a channel with values in data.csv");
  }
  const MeasuredChannel kept = data.targets[target];
  const VectorXd values = data.target_values.col(target);
  data.targets = {kept};
  data.target_values = values;
  const double begin = data.time[first], span = data.time[last] - begin;

  LengthStudy study{name,
                    channel,
                    kept.unit,
                    VectorXd(lengths),
                    MatrixXd::Constant(lengths, sections, std::numeric_limits<double>::quiet_NaN()),
                    {}};
  study.rest_rms = study.fit_rms;
  std::mt19937_64 engine(5);
  const ModelSpec& spec = model_spec(name);
  for (int l = 0; l < lengths; ++l) {
    const double length = span * (0.08 + 0.72 * l / (lengths - 1.0));
    study.hours[l] = length / core::units::hour;
    for (int s = 0; s < sections; ++s) {
      const double from = begin + (span - length) * (engine() >> 11U) * 0x1p-53;
      std::vector<bool> training(data.rows());
      VectorXd inside = values, outside = values;
      for (Index i = 0; i < data.rows(); ++i) {
        const bool in = data.time[i] >= from && data.time[i] < from + length;
        training[i] = in;
        (in ? outside : inside)[i] = std::numeric_limits<double>::quiet_NaN();
      }
      FittedModel model(spec);
      model.fit(data, training, {});
      if (model.empty()) continue;
      MatrixXd all = model.predict(data);
      model.refuse_diverging(data, training, all);
      if (model.empty()) continue;
      const VectorXd predicted = all.col(0);
      study.fit_rms(l, s) = measure(inside, predicted).rms;
      study.rest_rms(l, s) = measure(outside, predicted).rms;
    }
  }
  return study;
}

}  // namespace thermotwin::compensation
