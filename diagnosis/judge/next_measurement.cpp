// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/next_measurement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>

#include "core/text.h"
#include "core/thread_pool.h"
#include "core/units.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/judge/ranking.h"
#include "diagnosis/response/mesh_allowance.h"
#include "diagnosis/statistics/statistics.h"
#include "mesh/machine/kinematics.h"
#include "solver/operation/channels.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr double tells_apart = 1.0;  ///< RMS difference over time in units of a channel's uncertainty
constexpr std::size_t most_causes = 4;
constexpr double least_probability = 0.01;  ///< of a rival that is compared
constexpr double coarser = 3.0;             ///< steps of planned programs: differences between causes need no more
constexpr double same_load = 0.05;          ///< of its length, and of an input's range in the mean: the same load again
constexpr double seen_already = 3.0;        ///< times its uncertainty that a channel of the record tells two apart
constexpr double own_load_counts = 1.5;     ///< another program has to be so much better than the same one again

/// What a reading is uncertain by at least.
constexpr double least_K = 0.05, least_um = 0.5;

struct Place {
  std::string name;  ///< sensor, or direction and pose
  double uncertainty = 1;
  const char* unit = "K";
  bool measured = false;  ///< in the measurement at hand
  bool is_sensor = false;
};

/// The machine's sensors, then dx, dy, dz of each pose: columns of Response::elsewhere.
std::vector<Place> places_of(const Problem& problem, const mesh::Machine& machine,
                             const std::vector<mesh::Pose>& poses) {
  const auto& channels = problem.observations.channels;
  double probe = least_um;
  for (const ObservedChannel& c : channels)
    if (c.is_gauge()) probe = std::max(probe, c.channel.uncertainty);
  std::vector<Place> places;
  for (const mesh::SensorSpec& sensor : machine.sensors) {
    const bool read = std::any_of(channels.begin(), channels.end(),
                                  [&](const ObservedChannel& c) { return c.channel.sensor == sensor.id; });
    places.push_back({sensor.id, std::max(sensor.uncertainty, least_K), "K", read, true});
  }
  for (const mesh::Pose& pose : poses) {
    for (const char* direction : {"dx", "dy", "dz"}) {
      const std::string text = mesh::format_pose(machine, pose);
      const bool read = std::any_of(channels.begin(), channels.end(), [&](const ObservedChannel& c) {
        return !c.is_temperature() && c.channel.quantity == direction && mesh::format_pose(machine, c.pose) == text;
      });
      places.push_back({std::string(direction) + " at " + text, probe, "um", read});
    }
  }
  return places;
}

/// A program as if it had been measured, without a channel.
/// @param machine  it may know the time of day
Observations planned(const solver::LoadProgram& program, const mesh::Machine& machine) {
  const solver::Channels channels(machine);
  Observations plan;
  const std::vector<double> ends = program.step_ends(coarser);
  plan.points.resize(std::ssize(ends) + 1);
  plan.points[0] = 0.0;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const Index at = i;
    plan.points[at + 1] = ends[i];
    const Eigen::VectorXd row = program.row(plan.points[at], ends[i]);
    if (i == 0) plan.rows.setConstant(std::ssize(ends), std::max(channels.size(), row.size()), solver::not_given);
    plan.rows.row(at).head(row.size()) = row.transpose();
  }
  plan.end = ends.back();
  plan.start_C = program.initial_C();
  return plan;
}

bool is_nameless(const RankedCause& cause) {
  return cause.parameter.kind == Kind::unknown || cause.parameter.kind == Kind::other_law;
}

MachineInTime machine_of(const mesh::Machine& machine, const Rival& rival) {
  MachineInTime changed(machine);
  for (const RankedCause& cause : rival.causes) changed = with_parameter(changed, cause.parameter, cause.value);
  return changed;
}

/// Why no measurement separates causes from the machine as stated: this record does.
std::string separated_already(const Diagnosis& d, const Rival& named) {
  double evidence = 0.0;
  for (const RankedCause& cause : named.causes) evidence = std::max(evidence, cause.log_evidence);
  if (!d.explanations.empty()) evidence = std::max(evidence, d.explanations.front().log_evidence.value_or(0.0));
  if (d.causes.empty() || evidence < strong) return "";
  return fmt::format(
      "this record already distinguishes {} from the machine as stated (ln Bayes factor {:.1f}), so that another "
      "measurement does not decide between them; a check on the machine does",
      named.name(), evidence);
}

/// Why no place distinguishes what acts on readings alone: temperatures and displacements are the same.
std::string by_second_sensor(const std::vector<Rival>& rivals) {
  std::vector<std::string> readings;
  for (const Rival& rival : rivals) {
    for (const RankedCause& cause : rival.causes)
      if (acts_on_readings(cause.parameter.kind)) readings.push_back(name_of(cause.parameter));
  }
  if (readings.empty()) return "";
  return "; a second sensor beside it, read by another logger, shows " + core::join(readings);
}

/// The value that differs most from the first one. @param over_time  (points)
double furthest(const Eigen::VectorXd& over_time) {
  Index at = 0;
  (over_time.array() - over_time[0]).abs().maxCoeff(&at);
  return over_time[at] - over_time[0];
}

/// Of one channel under one program.
struct Merit {
  double all = 0;         ///< mean over pairs by how probable they are, in units of expected
  double difference = 0;  ///< RMS of the pair that counts most
  double expected = 0;    ///< deviation of a reading from a right model: uncertainty and discretisation error
  std::pair<std::size_t, std::size_t> pair{0, 1};
};
/// @param mesh_error  of what a channel changes by, as a share
Merit merit_of(const std::vector<Rival>& rivals, const std::vector<MatrixXd>& seen, Index channel, double uncertainty,
               double mesh_error) {
  Merit merit;
  double sum = 0.0, weights = 0.0, most = -1.0, change = 0.0;
  for (const MatrixXd& of : seen) change = std::max(change, root_mean_square(of.col(channel).array() - of(0, channel)));
  merit.expected = std::hypot(uncertainty, mesh_error * change);
  for (std::size_t i = 0; i < rivals.size(); ++i) {
    for (std::size_t j = i + 1; j < rivals.size(); ++j) {
      const double weight = std::max(rivals[i].probability * rivals[j].probability, 1e-12);
      const double rms = root_mean_square(seen[i].col(channel) - seen[j].col(channel));
      sum += weight * rms * rms;
      weights += weight;
      if (weight * rms > most) most = weight * rms, merit.difference = rms, merit.pair = {i, j};
    }
  }
  merit.all = std::sqrt(sum / weights) / merit.expected;
  return merit;
}

}  // namespace

std::string Rival::name() const {
  if (causes.empty()) return "the machine as stated";
  std::vector<std::string> names;
  for (const RankedCause& cause : causes) names.push_back(name_of(cause.parameter));
  return core::join(names, " with ") + (alone ? " alone" : "");
}

std::vector<Rival> rivals_of(const Diagnosis& diagnosis) {
  std::vector<Rival> rivals;
  const auto add = [&](const RankedCause& cause) {
    if (is_nameless(cause) || rivals.size() >= most_causes) return;
    Rival rival{diagnosis.causes, cause.probability};
    const bool known = std::any_of(rival.causes.begin(), rival.causes.end(), [&](const RankedCause& named) {
      return named.parameter.kind == cause.parameter.kind && named.parameter.where == cause.parameter.where;
    });
    if (known) return;
    if (cause.parameter.name.empty())
      rival.causes.clear();
    else
      rival.causes.push_back(cause);
    rivals.push_back(std::move(rival));
  };
  if (!diagnosis.causes.empty()) rivals.push_back({diagnosis.causes, diagnosis.causes.front().probability});
  for (const RankedCause& cause : diagnosis.ambiguous_set) add(cause);
  if (rivals.empty()) {
    std::vector<RankedCause> best = diagnosis.ranking;
    // Beside something unknown the probabilities are hardly more than priors.
    if (diagnosis.verdict == Verdict::unexplained) {
      std::stable_sort(best.begin(), best.end(),
                       [](const RankedCause& a, const RankedCause& b) { return a.log_evidence > b.log_evidence; });
    }
    for (const RankedCause& cause : best)
      if (rivals.size() < 2) add(cause);
  }
  double others = 0.0;
  for (std::size_t i = 1; i < rivals.size(); ++i) others += rivals[i].probability;
  if (!diagnosis.causes.empty() && rivals.size() > 1) {
    rivals.front().probability = std::max(1.0 - others, least_probability);
    rivals.front().alone = true;
  }
  if (rivals.size() == 1 && !rivals.front().causes.empty())
    rivals.push_back({{}, std::max(1.0 - rivals.front().probability, least_probability)});
  return rivals;
}

bool repeats(const Observations& plan, const Observations& record) {
  const double duration = record.end - record.start;
  if (std::abs(plan.end - plan.start - duration) > same_load * duration) return false;
  const Index rows = record.rows.rows();
  const Index inputs = std::min(record.rows.cols(), plan.rows.cols());
  for (Index input = 0; input < inputs; ++input) {
    double low = std::numeric_limits<double>::infinity(), high = -low, off = 0.0, time = 0.0;
    for (Index i = 0; i < rows; ++i) {
      const double from = record.points[i], width = record.points[i + 1] - from;
      const double since = from + 0.5 * width - record.start + plan.start;
      const auto at = std::upper_bound(plan.points.begin(), plan.points.end(), since);
      const Index row = std::clamp<Index>(at - plan.points.begin() - 1, 0, plan.rows.rows() - 1);
      const double recorded = record.rows(i, input), planned = plan.rows(row, input);
      if (!std::isfinite(recorded) || !std::isfinite(planned)) continue;
      low = std::min({low, recorded, planned});
      high = std::max({high, recorded, planned});
      off += width * std::abs(recorded - planned);
      time += width;
    }
    if (off > same_load * time * (high - low)) return false;
  }
  return true;
}

namespace {

/// Steps or a creep that nothing explains: the same load again shows whether they belong to it.
NextMeasurement repetition(const Problem& problem, const Diagnosis& diagnosis) {
  NextMeasurement next;
  next.load = "the same load as " + diagnosis.measurement;
  next.channel = core::join(diagnosis.steps.channels, " and ");
  next.duration_h = (problem.observations.end - problem.observations.start) / core::units::hour;
  if (diagnosis.steps.creeps()) {
    next.why = "it shows whether the creep belongs to the load";
    next.outcomes = {
        "Without a creep what was clamped has settled, and the new record alone shows what else differs.",
        "The same creep again comes from the machine under this load: look for heat or a film near these channels that "
        "the model lacks."};
    return next;
  }
  next.why = "it shows whether the steps belong to the load";
  next.outcomes = {
      "Without steps they were an event, and the new record alone shows what else differs.",
      "Steps at the same times of the load come from the machine: look for clearance, a clamp or a switch there."};
  return next;
}

}  // namespace

NextMeasurement next_measurement(const Problem& problem, const reduction::ReducedModel& model,
                                 const std::vector<solver::LoadProgram>& programs, const Diagnosis& diagnosis,
                                 const DiagnoseOptions& options) {
  if (diagnosis.verdict == Verdict::unexplained && !diagnosis.steps.steps.empty())
    return repetition(problem, diagnosis);
  NextMeasurement next;
  const std::vector<Rival> rivals = rivals_of(diagnosis);
  if (rivals.size() < 2) return next;
  if (rivals.size() == 2 && rivals.back().causes.empty()) next.why = separated_already(diagnosis, rivals.front());
  if (!next.why.empty()) return next;
  const mesh::Machine& machine = model.machine;
  const std::vector<mesh::Pose> poses = mesh::workspace_poses(machine);
  const std::vector<Place> places = places_of(problem, machine, poses);

  const MeshAllowance allowance(machine, model.mesh_error, options);
  double best = 0.0, seen_best = 0.0;  // merits: of what can be measured, of what was
  std::string seen_by;
  const auto consider = [&](const Observations& plan, const std::string& load, bool own) {
    const Response response(model, plan);
    std::vector<MatrixXd> seen(rivals.size());
    core::parallel_for(0, rivals.size(), [&](std::size_t i) {
      MachineInTime rival = machine_of(machine, rivals[i]);
      // Another program comes after the record, and after its steps.
      if (!own)
        for (LaterFactor& later : rival.later) later.from_s = std::numeric_limits<double>::lowest();
      seen[i] = response.elsewhere(rival, poses);
    });
    for (std::size_t c = 0; c < places.size(); ++c) {
      const Index column = c;
      const double mesh_error = places[c].is_sensor ? allowance.of_sensor(places[c].name)
                                                    : allowance.of_displacement(places[c].name.substr(0, 2));
      const Merit merit = merit_of(rivals, seen, column, places[c].uncertainty, mesh_error);
      if (own && places[c].measured) {
        if (merit.all > seen_best) seen_best = merit.all, seen_by = places[c].name;
        continue;
      }
      const double weighed = own ? own_load_counts * merit.all : merit.all;
      if (weighed <= best) continue;
      best = weighed;
      next.load = load;
      next.channel = places[c].name;
      next.duration_h = (plan.end - plan.start) / core::units::hour;
      next.why = fmt::format(
          "{} and {} differ there by {:.2g} {} RMS, {:.1f} times what it is uncertain by, "
          "the discretisation error included",
          rivals[merit.pair.first].name(), rivals[merit.pair.second].name(), merit.difference, places[c].unit,
          merit.difference / merit.expected);
      next.outcomes.clear();
      for (std::size_t i = 0; i < rivals.size(); ++i) {
        next.outcomes.push_back(fmt::format("{} changes by {:+.3g} {} at most under {}.", places[c].name,
                                            furthest(seen[i].col(column)), places[c].unit, rivals[i].name()));
      }
    }
  };
  consider(problem.observations, "the same load as " + diagnosis.measurement, true);
  const bool stated_is_rival = std::any_of(diagnosis.ambiguous_set.begin(), diagnosis.ambiguous_set.end(),
                                           [](const RankedCause& cause) { return cause.parameter.kind == Kind::none; });
  if (rivals.size() == 2 && stated_is_rival && seen_best >= seen_already) {
    next = {};
    next.why = fmt::format(
        "{} and {} differ by {:.1f} times the uncertainty of {} in this record already, so that another measurement "
        "does not decide; the stated uncertainty of {} does",
        rivals[0].name(), rivals[1].name(), seen_best, seen_by, rivals[0].name());
    return next;
  }
  for (const solver::LoadProgram& program : programs) {
    const Observations plan = planned(program, machine);
    const std::span<const Observations> records = problem.observations.each();
    if (std::none_of(records.begin(), records.end(), [&](const Observations& one) { return repeats(plan, one); }))
      consider(plan, program.name(), false);
  }
  if (best >= tells_apart) return next;
  next = {};
  next.why = fmt::format(
      "no load program, sensor or pose of the machine distinguishes {} from {} (the largest difference is {:.1f} of "
      "its uncertainty){}",
      rivals[0].name(), rivals[1].name(), best, by_second_sensor(rivals));
  return next;
}

std::string nothing_to_decide(const std::vector<Detectable>& kinds) {
  std::vector<std::string> unseen;
  for (const Detectable& row : kinds)
    if (row.best.empty() && row.invisible > 0) unseen.push_back(name_of(row.kind));
  const std::string fits = "the machine as stated fits the record, so that nothing has to be decided";
  if (unseen.empty()) return fits + "; the table of what the record can show has the size from which a cause is seen";
  return fits + "; this record would not have shown a change of " + core::join(unseen) +
         ", which needs other loads, poses or sensors";
}

}  // namespace thermotwin::diagnosis
