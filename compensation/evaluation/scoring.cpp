// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/evaluation/scoring.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "compensation/evaluation/result.h"
#include "compensation/models/fitted_model.h"
#include "core/error.h"
#include "core/missing.h"
#include "core/text.h"

namespace thermotwin::compensation {

using core::missing;
using core::InputError;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr double day_s = 86400.0;
constexpr double least_day_s = 3600.0;      // a rest shorter than that belongs to the day before
constexpr std::size_t most_segments = 100;  // a record of years: the rest in one segment

VectorXd within(const VectorXd& time, const VectorXd& values, const EvaluationSegment& segment) {
  VectorXd inside = values;
  for (Index i = 0; i < time.size(); ++i) {
    if (time[i] < segment.from || time[i] >= segment.to) inside[i] = missing;
  }
  return inside;
}

/// Training ends after a day, where a quarter of a day is left to judge; else half way. It begins with the
/// first displacement: a record may run for days before the probes do.
double automatic_training(const Measurement& measurement, const VectorXd& time) {
  Index first = time.size(), last = -1;
  for (const MeasuredChannel& channel : measurement.channels) {
    if (channel.kind != ChannelKind::displacement) continue;
    const auto [from, to] = known_range(measurement.values(channel));
    if (from < 0) continue;
    first = std::min(first, from);
    last = std::max(last, to);
  }
  if (last <= first) return 0.5 * (time[time.size() - 1] - time[0]);
  const double span = time[last] - time[first];
  constexpr double least_rest = 0.25 * day_s;
  return time[first] - time[0] + (span >= day_s + least_rest ? day_s : 0.5 * span);
}

}  // namespace

std::vector<EvaluationSegment> segments_of(const Measurement& measurement, const EvaluateOptions& options) {
  constexpr double forever = std::numeric_limits<double>::infinity();
  const VectorXd time = measurement.time();
  std::vector<EvaluationSegment> segments;
  if (!options.train_programs.empty()) {
    std::vector<std::string> names;
    for (const Program& program : measurement.programs) {
      const bool training = std::find(options.train_programs.begin(), options.train_programs.end(), program.name) !=
                            options.train_programs.end();
      segments.push_back({program.name, program.from_s, program.to_s, training});
      names.push_back(program.name);
    }
    for (const std::string& name : options.train_programs) {
      if (std::find(names.begin(), names.end(), name) != names.end()) continue;
      throw InputError(
          (measurement.folder / "channels.toml").string(), "no program '" + name + "'",
          names.empty() ? "[[program]] tables with name, from_s and to_s" : "one of: " + core::join(names));
    }
    return segments;
  }
  // Hours and days count from the first row: a clock may start anywhere.
  const double origin = time[0];
  const double until =
      options.train_until_s < 0.0
          ? -forever
          : origin + (options.train_until_s > 0.0 ? options.train_until_s : automatic_training(measurement, time));
  if (!measurement.programs.empty()) {
    for (const Program& program : measurement.programs) {
      // A program that the training's end cuts is judged from there on.
      if (program.from_s < until) {
        segments.push_back(
            {program.to_s <= until ? program.name : "training", program.from_s, std::min(program.to_s, until), true});
      }
      if (program.to_s > until)
        segments.push_back({program.name, std::max(program.from_s, until), program.to_s, false});
    }
    return segments;
  }
  double day = 0.0;
  for (Index i = 0; i < time.size(); ++i) {
    const bool training = time[i] < until;
    const double at_day = std::floor((time[i] - origin) / day_s);
    const bool begins = segments.empty() || (!training && (segments.back().training || at_day != day));
    if (!begins || segments.size() == most_segments) continue;
    if (!segments.empty()) segments.back().to = segments.back().training ? until : origin + (day + 1.0) * day_s;
    day = at_day;
    segments.push_back({training ? "training" : fmt::format("day {:.0f}", day), time[i], forever, training});
  }
  if (segments.size() > 1 && !segments[segments.size() - 2].training &&
      time[time.size() - 1] - segments.back().from < least_day_s)
    segments.pop_back();
  if (!segments.empty()) {
    const double end = std::nextafter(time[time.size() - 1], forever);
    segments.back().to = segments.back().training ? std::min(until, end) : end;
  }
  return segments;
}

Scorer::Scorer(const Measurement& measurement, std::vector<EvaluationSegment> segments)
    : data_(make_dataset(measurement)),
      segments_(std::move(segments)) {
  names_.push_back("time_s");
  columns_.push_back(data_.time);
  for (std::size_t t = 0; t < data_.targets.size(); ++t) {
    names_.push_back(data_.targets[t].id + "_measured");
    columns_.push_back(data_.target_values.col(t));
  }
}

std::vector<bool> Scorer::training() const {
  std::vector<bool> used(data_.rows(), false);
  for (const EvaluationSegment& segment : segments_) {
    for (Index i = 0; segment.training && i < data_.rows(); ++i) {
      if (data_.time[i] >= segment.from && data_.time[i] < segment.to) used[i] = true;
    }
  }
  return used;
}

void Scorer::add(const std::string& model, std::size_t target, const VectorXd& given, bool fitted) {
  const MeasuredChannel& channel = data_.targets[target];
  const VectorXd measured = data_.target_values.col(target);
  VectorXd predicted = given;
  const std::vector<bool> seen = training();
  for (std::size_t s = 0; channel.zero == Zero::first && s < data_.starts.size(); ++s) {
    const Index from = data_.starts[s], to = data_.stretch_end(s);
    // What was not fitted to this stretch knows nothing of its zero.
    if (fitted && std::find(seen.begin() + from, seen.begin() + to, true) != seen.begin() + to) continue;
    for (Index i = from; i < to; ++i) {
      if (!std::isfinite(measured[i]) || !std::isfinite(predicted[i])) continue;
      predicted.segment(from, to - from).array() -= predicted[i] - measured[i];
      break;
    }
  }
  for (const EvaluationSegment& segment : segments_) {
    const VectorXd inside = within(data_.time, measured, segment);
    const Measures measures = measure(inside, predicted);
    if (measures.count == 0) continue;
    const Measures all = measure(inside, VectorXd::Zero(inside.size()));
    rows.push_back({model, channel.id, segment.name, segment.from, segment.to, measures, channel.unit,
                    fitted && segment.training, all.count, all.rms_before});
  }
  names_.push_back(channel.id + "_" + model);
  columns_.push_back(std::move(predicted));
}

void Scorer::add(const std::string& model, const MatrixXd& predicted, bool fitted) {
  if (known_range(predicted.reshaped()).first < 0) {
    note(fmt::format("{} cannot predict {}, which lacks an input that the model was fitted with", model, data_.source));
  }
  for (std::size_t t = 0; t < data_.targets.size(); ++t) {
    const VectorXd series = predicted.col(t);
    if (known_range(series).first >= 0) add(model, t, series, fitted);
  }
}

core::Table Scorer::predictions() const {
  core::Table table;
  table.source = "predictions";
  table.columns = names_;
  table.values.resize(data_.rows(), std::ssize(columns_));
  for (std::size_t i = 0; i < columns_.size(); ++i) table.values.col(i) = columns_[i];
  return table;
}

std::vector<const ModelSpec*> chosen_models(const EvaluateOptions& options) {
  std::vector<const ModelSpec*> chosen;
  if (options.models.empty()) {
    for (const ModelSpec& spec : model_specs()) chosen.push_back(&spec);
  }
  for (const std::string& name : options.models) chosen.push_back(&model_spec(name));
  return chosen;
}

TrainingRows training_rows(const Scorer& scorer, const std::vector<Scorer>& further) {
  if (further.empty()) return {scorer.data(), scorer.training()};
  std::vector<const Scorer*> scorers;
  for (const Scorer& other : further) scorers.push_back(&other);
  scorers.push_back(&scorer);
  TrainingRows rows;
  std::vector<const Dataset*> segments;
  for (const Scorer* one : scorers) {
    segments.push_back(&one->data());
    const std::vector<bool> used = one->training();
    rows.used.insert(rows.used.end(), used.begin(), used.end());
  }
  rows.data = join_datasets(segments);
  return rows;
}

bool fit_and_score(FittedModel& model, const std::vector<std::string>& check, const TrainingRows& rows, Scorer& scorer,
                   std::vector<Scorer>& further) {
  try {
    model.fit(rows.data, rows.used, check);
  } catch (const InputError& error) {
    scorer.note(model.name() + " left out: " + error.what());
    return false;
  }
  // A model that no channel carries says so once.
  if (model.empty() && !model.left_out().empty()) {
    scorer.note("left out: " + model.left_out().front());
    return false;
  }
  MatrixXd predicted = model.predict(rows.data);
  model.refuse_diverging(rows.data, rows.used, predicted);
  for (const std::string& reason : model.left_out()) scorer.note("left out: " + reason);
  for (const std::string& reason : model.refused()) scorer.note("refused: " + reason);
  if (model.empty()) return false;
  scorer.add(model.name(), further.empty() ? predicted : model.predict(scorer.data()), true);
  for (Scorer& other : further) other.add(model.name(), model.predict(other.data()), true);
  return true;
}

}  // namespace thermotwin::compensation
