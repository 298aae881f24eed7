// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/channel_errors.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/units.h"
#include "diagnosis/statistics/statistics.h"

namespace thermotwin::diagnosis {

using Eigen::Index;

namespace {

using core::units::hour;

/// Samples of one interval are not independent: averaging stops helping at ten of them.
constexpr double least_noise_share = 0.1;
constexpr double slow_hours = 6.0, fast_hours = 0.5;  ///< time constants of wandering model errors

/// No hypothesis has the footprint and the time course of the truth: a share of what is seen stays with
/// each channel, some of it for hours, some for all of the record.
constexpr double form_error_hours[] = {3.0, 24.0};
constexpr double form_error_share[] = {0.07, 0.03};
constexpr double least_course = 0.3;  ///< of what wanders with a motion, while nothing moves

bool same_pose(const ObservedChannel& a, const ObservedChannel& b) {
  return &a != &b && a.record == b.record && !a.is_temperature() && !b.is_temperature() && a.channel.points.empty() &&
         b.channel.points.empty() && a.channel.unit == b.channel.unit && a.channel.pose_text == b.channel.pose_text;
}

/// What the other directions at a displacement's pose move, at its times: of the whole motion a mesh turns a little
/// into each. (n x others)
Eigen::MatrixXd moves_beside(const Problem& problem, std::size_t of) {
  const std::vector<ObservedChannel>& channels = problem.observations.channels;
  const ObservedChannel& channel = channels[of];
  Eigen::MatrixXd moves(channel.size(), 0);
  for (std::size_t k = 0; k < channels.size(); ++k) {
    const ObservedChannel& other = channels[k];
    if (!same_pose(channel, other) || other.size() == 0) continue;
    const auto predicted = problem.predicted.segment(problem.first_row(k), other.size());
    const double at_start = other.channel.zero == compensation::Zero::first ? 0.0 : predicted[0];
    moves.conservativeResize(Eigen::NoChange, moves.cols() + 1);
    Index next = 0;  // the mean of the same interval, or the one after where that has none
    for (Index i = 0; i < channel.size(); ++i) {
      while (next + 1 < other.size() && other.interval[next] < channel.interval[i]) ++next;
      moves(i, moves.cols() - 1) = predicted[next] - at_start;
    }
  }
  return moves;
}

/// A machine that is symmetric in x hardly moves in x, but its mesh turns a share of the whole motion there.
struct ModelError {
  double share;
  bool of_whole_motion;  ///< of the motion in all directions, else of the channel's own change
};

/// A series as it is compared: a channel, or a sum of a test's channels in its place.
struct Compared {
  const ObservedChannel& channel;  ///< its times and samples
  Eigen::VectorXd value, predicted;
  double noise;  ///< stated
  Floor floor;
};

/// Less its start.
Eigen::VectorXd moved_of(const Compared& series, double start_C) {
  const bool from_first = series.channel.channel.zero == compensation::Zero::first;
  const double at_start = from_first ? 0.0 : series.channel.is_temperature() ? start_C : series.predicted[0];
  return series.predicted.array() - at_start;
}

double amplitude_of(const Compared& series, const Eigen::VectorXd& moved) {
  // Held-out values must not enter, not even the size of an error term.
  const bool from_first = series.channel.channel.zero == compensation::Zero::first;
  const Eigen::VectorXd measured =
      series.value.head(series.channel.fitted).array() - (from_first ? 0.0 : series.value[0]);
  return std::max({root_mean_square(moved), root_mean_square(measured), 3.0 * series.floor.slow});
}

/// An error of the mesh or of material data grows with what has moved so far: where a machine stands at rest there is
/// little yet. @param motion  (n) of the channel and beside it  @return (n) least_course to 1
Eigen::VectorXd course_of(const Compared& series, const Eigen::VectorXd& motion, double amplitude) {
  const Index fitted = series.channel.fitted;  // held-out values must not enter
  Eigen::VectorXd course(motion.size());
  double most = 0.0;
  for (Index i = 0; i < motion.size(); ++i) {
    most = std::max(most, std::abs(motion[i]));
    if (i < fitted) most = std::max(most, std::abs(series.value[i] - series.value[0]));
    course[i] = std::clamp(most / amplitude, least_course, 1.0);
  }
  return course;
}

/// @param shapes  (n x any)  @param slow  error of mesh and material data that wanders, with its course (n)
ChannelCovariance covariance_of(const Compared& series, Eigen::MatrixXd shapes, double slow,
                                const Eigen::VectorXd& course = {}) {
  const ObservedChannel& channel = series.channel;
  ChannelCovariance cov;
  cov.time = channel.time;
  const double noise = std::max(series.noise, series.floor.noise);
  cov.noise_variance = noise * noise * channel.samples.cwiseInverse().cwiseMax(least_noise_share);
  cov.shapes = std::move(shapes);
  cov.wander = {{series.floor.slow, slow_hours * hour, {}},
                {series.floor.fast, fast_hours * hour, {}},
                {slow, slow_hours * hour, course},
                {0.5 * slow, fast_hours * hour, course}};
  const double seen = root_mean_square((series.value - series.predicted).head(channel.fitted));
  for (std::size_t i = 0; i < std::size(form_error_share); ++i)
    cov.wander.push_back({form_error_share[i] * seen, form_error_hours[i] * hour, {}});
  return cov;
}

/// Where a model does not know its parts, the stated spread of expansion and heat capacity is not a
/// parameter but part of the model error: a factor of displacements, a wandering error of transients.
/// @param model_error  of mesh and discretisation
/// @param beside  (n x others) what the other directions at the pose move
ChannelCovariance channel_covariance(const Compared& series, const Eigen::MatrixXd& beside, double start_C,
                                     const MaterialSpread& spread, const ModelError& model_error, double& amplitude) {
  const ObservedChannel& channel = series.channel;
  const Eigen::VectorXd moved = moved_of(series, start_C);
  amplitude = amplitude_of(series, moved);
  const double factor = channel.is_temperature() ? model_error.share : std::hypot(model_error.share, spread.expansion);
  Eigen::MatrixXd shapes(channel.size(), 1 + beside.cols());
  shapes << factor * moved, model_error.share * beside;
  double motion = amplitude;
  Eigen::VectorXd moves = moved;
  if (model_error.of_whole_motion && beside.size() > 0) {
    motion = std::hypot(amplitude, beside.norm() / std::sqrt(1.0 * channel.size()));
    moves = (moved.array().square() + beside.rowwise().squaredNorm().array()).sqrt();
  }
  return covariance_of(series, std::move(shapes), std::hypot(model_error.share * motion, 0.5 * spread.heat * amplitude),
                       course_of(series, moves, motion));
}

/// Covariances of the sums of a test in the places of its channels.
void set_covariance(Problem& problem, const PointTest& test, const TestErrors& errors, const MaterialSpread& spread) {
  const Eigen::VectorXd measured = problem.decorrelated(problem.measured),
                        predicted = problem.decorrelated(problem.predicted), gains = gains_of(test);
  for (Index k = 0; k < gains.size(); ++k) {
    const std::size_t of = test.channels[k];
    const ObservedChannel& channel = problem.observations.channels[of];
    const Index first = problem.first_row(of), n = channel.size();
    const Floor floor = floor_of(channel);
    const Compared series{channel,
                          measured.segment(first, n),
                          predicted.segment(first, n),
                          channel.channel.uncertainty,
                          {gains[k] * floor.noise, gains[k] * floor.slow, gains[k] * floor.fast}};
    const Eigen::VectorXd moved = moved_of(series, 0.0);
    problem.amplitude[of] = amplitude_of(series, moved);
    problem.covariance[of] = covariance_of(
        series, spread.expansion * moved, std::hypot(errors.independent[k], 0.5 * spread.heat * problem.amplitude[of]));
  }
}

}  // namespace

Floor floor_of(const ObservedChannel& channel) {
  return channel.is_temperature() ? Floor{0.005, 0.02, 0.05} : Floor{0.02, 0.1, 0.3};
}

MaterialSpread material_spread(const mesh::Machine& machine) {
  MaterialSpread spread;
  for (const mesh::Material& material : machine.materials) {
    spread.expansion = std::max(spread.expansion, material.expansion.std_percent / 100.0);
    spread.heat = std::max(spread.heat, material.specific_heat.std_percent / 100.0);
  }
  return spread;
}

void set_covariances(Problem& problem, const MeshAllowance& allowance, const MaterialSpread& spread,
                     const std::vector<TestErrors>& errors) {
  const Observations& obs = problem.observations;
  const auto channels = obs.channels.size();
  problem.amplitude.resize(std::ssize(obs.channels));
  problem.covariance.resize(channels);
  for (std::size_t k = 0; k < channels; ++k) {
    const ObservedChannel& channel = obs.channels[k];
    if (!channel.channel.points.empty()) continue;
    const Index first = problem.first_row(k), n = channel.size();
    const Compared series{channel, problem.measured.segment(first, n), problem.predicted.segment(first, n),
                          channel.channel.uncertainty, floor_of(channel)};
    problem.covariance[k] =
        channel_covariance(series, moves_beside(problem, k), obs.each()[channel.record].start_C, spread,
                           {allowance.of(channel), allowance.is_of_whole_motion()}, problem.amplitude[k]);
  }
  for (std::size_t t = 0; t < errors.size(); ++t) set_covariance(problem, problem.tests[t], errors[t], spread);
}

Eigen::VectorXd expected_std(const Problem& problem) {
  const std::vector<ObservedChannel>& channels = problem.observations.channels;
  Eigen::VectorXd variance(problem.measured.size());
  for (std::size_t k = 0; k < channels.size(); ++k)
    variance.segment(problem.first_row(k), channels[k].size()) = problem.covariance[k].variance();
  const Eigen::VectorXd of_sums = variance;
  for (const PointTest& test : problem.tests) {
    for (std::size_t k = 0; k < test.channels.size(); ++k) {
      const Index n = channels[test.channels[k]].size();
      auto own = variance.segment(problem.first_row(test.channels[k]), n);
      own.setZero();
      for (std::size_t l = 0; l < test.channels.size(); ++l) {
        const double share = test.from_sums(k, l);
        own += share * share * of_sums.segment(problem.first_row(test.channels[l]), n);
      }
    }
  }
  variance += (problem.columns * problem.prior_std.asDiagonal()).rowwise().squaredNorm();
  return variance.cwiseSqrt();
}

}  // namespace thermotwin::diagnosis
