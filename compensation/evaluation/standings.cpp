// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/evaluation/standings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "core/missing.h"
#include "core/text.h"

namespace thermotwin::compensation {

using core::missing;

namespace {

constexpr double rotation_lever = 0.3;  ///< m; offsets --table-radius has the same default
constexpr double sensors_worsen = 1.0;  ///< percent less removed than without sensors

using Place = std::tuple<std::string, std::string, double>;  ///< channel, segment, its begin

Place place_of(const EvaluationRow& row) { return {row.channel, row.segment, row.from_s}; }

double squares(double rows, double rms) { return rows > 0.0 ? rows * rms * rms : 0.0; }

/// The rows on which models are judged: one for each channel and segment, with the displacements as measured.
std::map<Place, const EvaluationRow*> judged_places(const std::vector<EvaluationRow>& rows) {
  std::set<Place> seen;
  for (const EvaluationRow& row : rows)
    if (row.training) seen.insert(place_of(row));
  std::map<Place, const EvaluationRow*> held_out, all;
  for (const EvaluationRow& row : rows) {
    all.emplace(place_of(row), &row);
    if (!seen.contains(place_of(row))) held_out.emplace(place_of(row), &row);
  }
  return held_out.empty() ? all : held_out;
}

/// Cautions of a model, the first ones in words.
std::string caution_of(const FittedModel& model) {
  constexpr std::size_t most = 2;
  const std::vector<std::string> all = model.cautions();
  const std::string words = core::join({all.begin(), all.begin() + (std::min(all.size(), most))}, "; ");
  return all.size() > most ? words + fmt::format("; and {} channels more", all.size() - most) : words;
}

using Channels = std::map<std::string, JudgedChannel>;

/// Mean over channels of RMS after over before, as a reduction.
double channel_mean_percent(const Channels& channels) {
  double shares = 0.0, moved = 0.0;
  for (const auto& [id, channel] : channels) {
    if (!(channel.before > 0.0)) continue;
    shares += channel.after / channel.before;
    moved += 1.0;
  }
  return moved > 0.0 ? 100.0 * (1.0 - std::sqrt(shares / moved)) : missing;
}

/// Over the channels that both predict.
double against_percent(const Channels& channels, const Channels& reference) {
  double gains = 0.0, compared = 0.0;
  for (const auto& [id, channel] : channels) {
    const JudgedChannel& other = reference.at(id);
    if (!(channel.predicted > 0.0 && other.predicted > 0.0 && other.after > 0.0)) continue;
    gains += 1.0 - std::sqrt(channel.after / other.after);
    compared += 1.0;
  }
  return compared > 0.0 ? 100.0 * gains / compared : missing;
}

}  // namespace

void JudgedChannel::add(const EvaluationRow& measured, const EvaluationRow* row) {
  unit = measured.unit;
  const double all = squares(measured.measured_rows, measured.measured_rms);
  rows += measured.measured_rows;
  before += all;
  if (row == nullptr) {
    after += all;
    return;
  }
  const double count = row->measures.count;
  predicted += count;
  after += squares(count, row->measures.rms) + std::max(0.0, all - squares(count, row->measures.rms_before));
}

double removed_percent(const std::map<std::string, JudgedChannel>& channels) {
  double before = 0.0, after = 0.0;
  for (const auto& [id, channel] : channels) {
    if (!(channel.rows > 0.0)) continue;
    const double lever = channel.unit == "um/m" ? rotation_lever : 1.0;
    before += lever * lever * channel.before / channel.rows;
    after += lever * lever * channel.after / channel.rows;
  }
  return before > 0.0 ? 100.0 * (1.0 - std::sqrt(after / before)) : missing;
}

std::vector<Standing> standings(const std::vector<EvaluationRow>& rows, const std::vector<FittedModel>& models) {
  const std::map<Place, const EvaluationRow*> places = judged_places(rows);
  std::vector<std::string> order;
  std::map<std::string, std::map<Place, const EvaluationRow*>> own;
  std::set<std::string> fitted_here;
  for (const EvaluationRow& row : rows) {
    if (!own.contains(row.model)) order.push_back(row.model);
    own[row.model].emplace(place_of(row), &row);
    if (row.training && places.contains(place_of(row))) fitted_here.insert(row.model);
  }
  std::map<std::string, Channels> judged;
  for (const std::string& model : order) {
    for (const auto& [place, measured] : places) {
      const auto row = own[model].find(place);
      judged[model][measured->channel].add(*measured, row == own[model].end() ? nullptr : row->second);
    }
  }
  const auto reference = judged.find("static_regression");
  std::vector<Standing> result;
  for (const std::string& model : order) {
    const Channels& channels = judged[model];
    Standing standing;
    standing.model = model;
    standing.reduction_percent = removed_percent(channels);
    standing.channel_mean_percent = channel_mean_percent(channels);
    standing.against_static_percent =
        reference == judged.end() ? missing : against_percent(channels, reference->second);
    standing.seen_by_fit = fitted_here.contains(model);
    double all = 0.0, predicted = 0.0;
    for (const auto& [id, channel] : channels) {
      standing.channels += channel.predicted > 0.0;
      all += channel.rows;
      predicted += channel.predicted;
    }
    standing.predicted_percent = all > 0.0 ? 100.0 * predicted / all : 0.0;
    for (const FittedModel& fitted : models) {
      if (model == fitted.name() || model == fitted.name() + "_as_is" || model == fitted.name() + "_corrected")
        standing.caution = caution_of(fitted);
    }
    result.push_back(std::move(standing));
  }
  std::stable_sort(result.begin(), result.end(), [](const Standing& a, const Standing& b) {
    if (a.caution.empty() != b.caution.empty()) return a.caution.empty();
    return a.reduction_percent > b.reduction_percent ||
           (std::isfinite(a.reduction_percent) && !std::isfinite(b.reduction_percent));
  });
  return result;
}

std::vector<std::string> worsened_by_sensors(const std::vector<Standing>& leaderboard) {
  std::vector<std::string> sentences;
  const auto find = [&](const std::string& model) {
    return std::find_if(leaderboard.begin(), leaderboard.end(), [&](const Standing& s) { return s.model == model; });
  };
  for (const std::string model : {"reduced_model", "extended_model"}) {
    const auto without = find(model), with = find(model + "_sensors");
    if (without == leaderboard.end() || with == leaderboard.end() ||
        !(with->reduction_percent < without->reduction_percent - sensors_worsen))
      continue;
    sentences.push_back(fmt::format(
        "the temperature sensors worsen {0}: it removes {1:.1f} % with them and {2:.1f} % without. A sensor reads "
        "another place than machine.toml states, or its offset is wrong; thermotwin diagnose judges each sensor, and "
        "compensate --no-sensors leaves them out",
        model, with->reduction_percent, without->reduction_percent));
  }
  return sentences;
}

}  // namespace thermotwin::compensation
