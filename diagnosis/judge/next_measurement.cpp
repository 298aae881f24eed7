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
constexpr double coarser = 3.0;          ///< steps of planned programs: differences between causes need no more
constexpr double same_load = 0.05;       ///< of its length, and of an input's range in the mean: the same load again
constexpr double seen_already = 3.0;     ///< times its uncertainty that a channel of the record tells two apart
constexpr double own_load_counts = 1.5;  ///< another program has to be so much better than the same one again

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
/// @param channels  of the machine; it may know the time of day
Observations planned(const solver::LoadProgram& program, Index channels) {
  Observations plan;
  const std::vector<double> ends = program.step_ends(coarser);
  plan.points.resize(std::ssize(ends) + 1);
  plan.points[0] = 0.0;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const Index at = i;
    plan.points[at + 1] = ends[i];
    const Eigen::VectorXd row = program.row(plan.points[at], ends[i]);
    if (i == 0) plan.rows.setConstant(std::ssize(ends), std::max(channels, row.size()), solver::not_given);
    plan.rows.row(at).head(row.size()) = row.transpose();
  }
  plan.end = ends.back();
  plan.start_C = program.initial_C();
  return plan;
}

/// A cause that may be the one, with what it foretells.
struct Rival {
  Parameter parameter;  ///< none: the machine as stated
  double value = 0, probability = 0;
  std::string name() const { return parameter.name.empty() ? "the machine as stated" : name_of(parameter); }
};

/// Causes that are named or share; the most probable ones where there are none; the machine as stated beside a single
/// one. What something unknown does elsewhere nobody knows.
std::vector<Rival> rivals_of(const Diagnosis& diagnosis) {
  std::vector<Rival> rivals;
  const auto add = [&](const std::vector<RankedCause>& causes, std::size_t most) {
    for (const RankedCause& cause : causes) {
      const bool known = std::any_of(rivals.begin(), rivals.end(), [&](const Rival& rival) {
        return rival.parameter.kind == cause.parameter.kind && rival.parameter.where == cause.parameter.where;
      });
      const bool nameless = cause.parameter.kind == Kind::unknown || cause.parameter.kind == Kind::other_law;
      if (nameless || known || rivals.size() >= most) continue;
      rivals.push_back({cause.parameter, cause.value, cause.probability});
    }
  };
  add(diagnosis.causes, most_causes);
  add(diagnosis.ambiguous_set, most_causes);
  if (rivals.empty()) add(diagnosis.ranking, 2);
  if (rivals.size() == 1 && !rivals.front().parameter.name.empty()) {
    Rival stated;
    stated.probability = std::max(1.0 - rivals.front().probability, 0.01);
    rivals.push_back(stated);
  }
  return rivals;
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

NextMeasurement next_measurement(const Problem& problem, const reduction::ReducedModel& model,
                                 const std::vector<solver::LoadProgram>& programs, const Diagnosis& diagnosis,
                                 const DiagnoseOptions& options) {
  NextMeasurement next;
  const std::vector<Rival> rivals = rivals_of(diagnosis);
  if (rivals.size() < 2) return next;
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
      const Parameter& p = rivals[i].parameter;
      MachineInTime rival = p.name.empty() ? MachineInTime(machine) : with_parameter(machine, p, rivals[i].value);
      // Another program comes after the record, and after its steps.
      if (!own)
        for (LaterFactor& later : rival.later) later.from_s = std::numeric_limits<double>::lowest();
      seen[i] = response.elsewhere(rival, poses);
    });
    for (std::size_t c = 0; c < places.size(); ++c) {
      const auto column = static_cast<Index>(c);
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
    const Observations plan = planned(program, solver::Channels(machine).size());
    const std::span<const Observations> records = problem.observations.each();
    if (std::none_of(records.begin(), records.end(), [&](const Observations& one) { return repeats(plan, one); }))
      consider(plan, program.name(), false);
  }
  if (best >= tells_apart) return next;
  next = {};
  next.why = fmt::format(
      "no load program, sensor or pose of the machine distinguishes {} from {} (the largest difference is {:.1f} of "
      "its uncertainty)",
      rivals[0].name(), rivals[1].name(), best);
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
