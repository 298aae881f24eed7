// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/judge/next_measurement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/thread_pool.h"
#include "diagnosis/judge/diagnosis.h"
#include "diagnosis/statistics/statistics.h"
#include "mesh/machine/kinematics.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr double tells_apart = 1.0;  ///< RMS difference over time in units of a channel's uncertainty
constexpr std::size_t most_causes = 4;
constexpr double coarser = 3.0;          ///< steps of planned programs: differences between causes need no more
constexpr double own_load_counts = 1.5;  ///< another program has to be so much better than the same one again

/// What a reading is uncertain by at least.
constexpr double least_K = 0.05, least_um = 0.5;

struct Place {
  std::string name;  ///< sensor, or direction and pose
  double uncertainty = 1;
  const char* unit = "K";
  bool measured = false;  ///< in the measurement at hand
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
    places.push_back({sensor.id, std::max(sensor.uncertainty, least_K), "K", read});
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
Observations planned(const solver::LoadProgram& program) {
  Observations plan;
  const std::vector<double> ends = program.step_ends(coarser);
  plan.points.resize(std::ssize(ends) + 1);
  plan.points[0] = 0.0;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const Index at = i;
    plan.points[at + 1] = ends[i];
    const Eigen::VectorXd row = program.row(plan.points[at], ends[i]);
    if (i == 0) plan.rows.resize(std::ssize(ends), row.size());
    plan.rows.row(at) = row.transpose();
  }
  plan.end = ends.back();
  plan.start_C = program.initial_C();
  return plan;
}

}  // namespace

NextMeasurement next_measurement(const Problem& problem, const reduction::ReducedModel& model,
                                 const std::vector<solver::LoadProgram>& programs, const Diagnosis& diagnosis) {
  NextMeasurement next;
  std::vector<RankedCause> set = diagnosis.ambiguous_set;
  std::erase_if(set, [](const RankedCause& cause) {
    return cause.parameter.name.empty();
  });  // what something unknown does elsewhere nobody knows
  if (set.size() < 2) return next;
  const mesh::Machine& machine = model.machine;
  const std::vector<mesh::Pose> poses = mesh::workspace_poses(machine);
  const std::vector<Place> places = places_of(problem, machine, poses);
  const std::size_t causes = std::min(set.size(), most_causes);

  double best = 0.0;  // merit
  const auto consider = [&](const Observations& plan, const std::string& load, bool own) {
    const Response response(model, plan);
    std::vector<MatrixXd> seen(causes);
    core::parallel_for(0, causes, [&](std::size_t i) {
      seen[i] = response.elsewhere(with_parameter(machine, set[i].parameter, set[i].value), poses);
    });
    for (std::size_t c = 0; c < places.size(); ++c) {
      if (own && places[c].measured) continue;
      // Mean over pairs by how probable they are; the pair that counts most gives the words.
      double sum = 0.0, weights = 0.0, most = -1.0, difference = 0.0;
      std::pair<std::size_t, std::size_t> pair{0, 1};
      for (std::size_t i = 0; i < causes; ++i) {
        for (std::size_t j = i + 1; j < causes; ++j) {
          const double weight = std::max(set[i].probability * set[j].probability, 1e-12);
          const double rms = root_mean_square(seen[i].col(c) - seen[j].col(c));
          sum += weight * rms * rms;
          weights += weight;
          if (weight * rms > most) most = weight * rms, difference = rms, pair = {i, j};
        }
      }
      const double ratio = std::sqrt(sum / weights) / places[c].uncertainty,
                   merit = own ? own_load_counts * ratio : ratio;
      if (merit <= best) continue;
      best = merit;
      next.load = load;
      next.channel = places[c].name;
      next.why = fmt::format("{} of {} and {} of {} differ there by {:.2g} {} RMS, {:.1f} times its uncertainty",
                             name_of(set[pair.first].parameter.kind), set[pair.first].parameter.where,
                             name_of(set[pair.second].parameter.kind), set[pair.second].parameter.where, difference,
                             places[c].unit, difference / places[c].uncertainty);
    }
  };
  consider(problem.observations, "the same load as " + diagnosis.measurement, true);
  for (const solver::LoadProgram& program : programs) consider(planned(program), program.name(), false);
  if (best >= tells_apart) return next;
  next.why = fmt::format(
      "no load program, sensor or pose of the machine distinguishes {} of {} from {} of {} (the largest difference is "
      "{:.1f} of its uncertainty)",
      name_of(set[0].parameter.kind), set[0].parameter.where, name_of(set[1].parameter.kind), set[1].parameter.where,
      best);
  next.load.clear();
  next.channel.clear();
  return next;
}

}  // namespace thermotwin::diagnosis
