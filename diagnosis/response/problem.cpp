// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/problem.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/thread_pool.h"
#include "core/units.h"
#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/machine_value.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/causes/shared_causes.h"
#include "diagnosis/record/diagnose_options.h"
#include "diagnosis/response/mesh_allowance.h"
#include "diagnosis/statistics/statistics.h"

namespace thermotwin::diagnosis {

using Eigen::Index;

namespace {

using core::units::hour;
/// Samples of one interval are not independent: averaging stops helping at ten of them.
constexpr double least_noise_share = 0.1;
constexpr double slow_hours = 6.0, fast_hours = 0.5;  ///< time constants of wandering model errors
constexpr double start_std_K = 0.2;                   ///< of the uniform start, beside its spread

/// Surroundings may wander that fast, or slower in a long record: those that nobody measures (a tank
/// of cutting fluid warms within an hour), and what a measured one still leaves out.
constexpr double unmeasured_knot_s = 1.0 * hour, measured_knot_s = 3.0 * hour;
constexpr int most_knots = 30;
constexpr double measured_air_std_K = 0.1, unmeasured_std_K = 0.3;

/// Surroundings wander: those that nobody measures by their stated uncertainty, air by what a
/// single sensor in a hall cannot see.
void add_surroundings(const mesh::Machine& machine, const compensation::Measurement& measurement,
                      const Observations& obs, int record, std::vector<Disturbance>& all) {
  const double duration = obs.end - obs.start;
  for (int a = 0; a < std::ssize(machine.ambients); ++a) {
    const mesh::AmbientSpec& ambient = machine.ambients[a];
    const bool measured = std::any_of(measurement.channels.begin(), measurement.channels.end(),
                                      [&](const auto& channel) { return channel.input == ambient.id + ".T_C"; });
    const double stated = std::abs(ambient.default_C.value) * ambient.default_C.std_percent / 100.0;
    const double std_K = measured ? measured_air_std_K : std::max(unmeasured_std_K, stated);
    const double knot_s = measured ? measured_knot_s : unmeasured_knot_s;
    const int knots = std::clamp<long>(std::lround(duration / knot_s), 2, most_knots);
    const double width = duration / knots;
    for (int k = 0; k <= knots; ++k) {
      const double peak = obs.start + width * k;
      all.push_back({a, peak - width, peak, peak + width, std_K, record});
    }
  }
}

std::vector<Disturbance> surroundings(const mesh::Machine& machine, Records records, const Observations& obs) {
  std::vector<Disturbance> all;
  for (std::size_t k = 0; k < records.size(); ++k)
    add_surroundings(machine, records[k], obs.each()[k], static_cast<int>(k), all);
  return all;
}

/// (starts) of each column of Response::Linear::start
Eigen::VectorXd starts_std(const std::vector<Index>& starts, const Observations& obs) {
  Eigen::VectorXd std;
  for (std::size_t k = 0; k < starts.size(); ++k) {
    std.conservativeResize(std.size() + starts[k]);
    std.tail(starts[k]).setConstant(start_std(obs.each()[k]));
  }
  return std;
}

struct Floor {
  double noise, slow, fast;
};
/// Below this neither a sensor nor a mesh is exact, and a reduced model shows quick ripples where
/// the full one stands still: few vectors make a body's inside.
Floor floor_of(const ObservedChannel& channel) {
  return channel.is_temperature() ? Floor{0.005, 0.02, 0.05} : Floor{0.02, 0.1, 0.3};
}

/// No hypothesis has the footprint and the time course of the truth: a share of what is seen stays with
/// each channel, some of it for hours, some for all of the record.
constexpr double form_error_hours[] = {3.0, 24.0};
constexpr double form_error_share[] = {0.07, 0.03};
constexpr double least_course = 0.3;  ///< of what wanders with a motion, while nothing moves

struct MaterialSpread {
  double expansion = 0, heat = 0;  ///< largest stated relative standard deviations
};
MaterialSpread material_spread(const mesh::Machine& machine) {
  MaterialSpread spread;
  for (const mesh::Material& material : machine.materials) {
    spread.expansion = std::max(spread.expansion, material.expansion.std_percent / 100.0);
    spread.heat = std::max(spread.heat, material.specific_heat.std_percent / 100.0);
  }
  return spread;
}

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

/// Columns for zeros of displacements, which were read with noise themselves. Those of a test's channels are zeros of
/// its sums.
/// @param zeroed  channels of the columns from `first` on
void set_zeros(Problem& problem, const std::vector<std::size_t>& zeroed, Index first) {
  const std::vector<ObservedChannel>& channels = problem.observations.channels;
  const auto column_of = [&](std::size_t k) {
    return first + (std::find(zeroed.begin(), zeroed.end(), k) - zeroed.begin());
  };
  for (const std::size_t k : zeroed) {
    problem.columns.col(column_of(k)).segment(problem.first_row(k), channels[k].size()).setOnes();
    problem.prior_std[column_of(k)] = std::max(channels[k].channel.uncertainty, floor_of(channels[k]).noise);
  }
  for (const PointTest& test : problem.tests) {
    const Eigen::VectorXd gains = gains_of(test);
    for (Index k = 0; k < gains.size(); ++k) {
      const std::size_t of = test.channels[k];
      for (Index l = 0; l < gains.size(); ++l) {
        const std::size_t on = test.channels[l];
        problem.columns.col(column_of(of))
            .segment(problem.first_row(on), channels[on].size())
            .setConstant(test.from_sums(l, k));
      }
      problem.prior_std[column_of(of)] =
          std::max(channels[of].channel.uncertainty, gains[k] * floor_of(channels[of]).noise);
    }
  }
}

/// @param first  column of the mesh errors of all tests
void set_mesh_errors(Problem& problem, const std::vector<TestErrors>& errors, Index first) {
  for (std::size_t t = 0; t < errors.size(); ++t) {
    for (const Eigen::MatrixXd& one : errors[t].joint) {
      for (Index k = 0; k < one.cols(); ++k)
        problem.columns.col(first).segment(problem.first_row(problem.tests[t].channels[k]), one.rows()) = one.col(k);
      problem.prior_std[first++] = 1.0;
    }
  }
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

/// Of measured minus predicted without a cause, in the channels' own units.
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

/// ln of the Bayes factor at which two causes are told apart: that of what counts as identifiable.
constexpr double told_apart = 5.0;

struct Simpler {
  Kind kind;
  std::string where;
};
/// Simpler causes whose effect a parameter may have in a record: a material's in one of its bodies, an emissivity's as
/// its film, a pressure's as its contact.
std::vector<Simpler> simpler_causes(const mesh::Machine& machine, const Parameter& parameter) {
  if (parameter.kind == Kind::film_emissivity) return {{Kind::film_coefficient, parameter.where}};
  if (parameter.kind == Kind::contact_pressure) return {{Kind::contact_conductance, parameter.where}};
  std::vector<Simpler> bodies;
  if (row_of(parameter.kind).target != Target::body || machine.body_index(parameter.where) >= 0) return bodies;
  for (const mesh::BodySpec* body : bodies_of_material(machine, parameter.where))
    bodies.push_back({parameter.kind, body->id});
  return bodies;
}

/// A parameter that the record does not tell from a simpler cause is no cause beside it, but stays as uncertain as it
/// is: the other bodies of a material show nothing of it.
void drop_causes_like_simpler_ones(const mesh::Machine& machine, Problem& problem) {
  const Whitener whitener(problem.fitted_covariance());
  Eigen::MatrixXd nuisances;  // white, in units of their prior
  Eigen::LLT<Eigen::MatrixXd> factor;
  for (Parameter& broad : problem.parameters) {
    const std::vector<Simpler> simpler = simpler_causes(machine, broad);
    if (simpler.empty()) continue;
    if (nuisances.size() == 0) {
      nuisances = whitener.whiten(problem.fitted(problem.columns)) * problem.prior_std.asDiagonal();
      factor.compute(Eigen::MatrixXd::Identity(nuisances.cols(), nuisances.cols()) + nuisances.transpose() * nuisances);
    }
    // Inner products of white columns less what nuisances take of them; both per unit of their parameters.
    const auto product = [&](Index a, Index b) {
      const Eigen::VectorXd left = nuisances.col(a) / problem.prior_std[a],
                            right = nuisances.col(b) / problem.prior_std[b];
      const Eigen::VectorXd taken = factor.solve(nuisances.transpose() * right);
      return left.dot(right) - (nuisances.transpose() * left).dot(taken);
    };
    const Index own = &broad - problem.parameters.data();
    const auto log_evidence = [&](Index cause) {
      const Parameter& p = problem.parameters[cause];
      const double width = p.cause_std * p.cause_std - problem.prior_std[cause] * problem.prior_std[cause],
                   square = width * product(cause, cause), seen = product(cause, own) * broad.cause_std;
      return 0.5 * (width * seen * seen / (1.0 + square) - std::log1p(square));
    };
    const double of_broad = log_evidence(own);
    for (const Simpler& place : simpler) {
      const auto same = std::find_if(problem.parameters.begin(), problem.parameters.end(), [&](const Parameter& p) {
        return p.kind == place.kind && p.where == place.where;
      });
      if (same == problem.parameters.end()) continue;
      if (of_broad < log_evidence(same - problem.parameters.begin()) + told_apart) {
        broad.cause_std = broad.nominal_std;
        break;
      }
    }
  }
}

}  // namespace

double start_std(const Observations& record) { return std::hypot(start_std_K, record.start_spread_K); }

Index Problem::first_row(std::size_t channel) const {
  Index row = 0;
  for (std::size_t k = 0; k < channel; ++k) row += observations.channels[k].size();
  return row;
}

Eigen::MatrixXd Problem::decorrelated(const Eigen::MatrixXd& stacked) const {
  return tests.empty() ? stacked : with_sums(tests, observations, stacked);
}

Eigen::MatrixXd Problem::fitted(const Eigen::MatrixXd& as_measured) const {
  const Eigen::MatrixXd sums = tests.empty() ? Eigen::MatrixXd() : decorrelated(as_measured);
  const Eigen::MatrixXd& stacked = tests.empty() ? as_measured : sums;
  Index total = 0;
  for (const ObservedChannel& channel : observations.channels) total += channel.fitted;
  Eigen::MatrixXd result(total, stacked.cols());
  Index from = 0, to = 0;
  for (const ObservedChannel& channel : observations.channels) {
    result.middleRows(to, channel.fitted) = stacked.middleRows(from, channel.fitted);
    from += channel.size();
    to += channel.fitted;
  }
  return result;
}

std::vector<ChannelCovariance> Problem::fitted_covariance() const {
  std::vector<ChannelCovariance> result;
  for (std::size_t k = 0; k < covariance.size(); ++k)
    result.push_back(covariance[k].head(observations.channels[k].fitted));
  return result;
}

MachineInTime Problem::machine_around(const mesh::Machine& machine, const std::vector<int>& but) const {
  std::vector<Parameter> moved;
  std::vector<double> values;
  for (Index i = 0; i < around.size(); ++i) {
    if (around[i] == 0.0 || std::find(but.begin(), but.end(), i) != but.end()) continue;
    moved.push_back(parameters[i]);
    values.push_back(nominal[i] + around[i]);
  }
  return with_parameters(machine, moved, Eigen::Map<Eigen::VectorXd>(values.data(), std::ssize(values)));
}

Eigen::VectorXd Problem::moved_around(const std::vector<int>& but) const {
  Eigen::VectorXd moved = Eigen::VectorXd::Zero(measured.size());
  for (Index i = 0; i < around.size(); ++i)
    if (around[i] != 0.0 && std::find(but.begin(), but.end(), i) == but.end()) moved += around[i] * columns.col(i);
  return moved;
}

Problem make_problem(const mesh::Machine& machine, Records records, Observations observations, const Response& response,
                     const DiagnoseOptions& options, const Eigen::VectorXd& around) {
  Problem problem;
  problem.observations = std::move(observations);
  const Observations& obs = problem.observations;
  problem.parameters = candidates_of_records(machine, records, obs, response.has_parts());
  // A channel without data shows nothing.
  std::erase_if(problem.parameters, [&](const Parameter& p) {
    return acts_on_readings(p.kind) && std::none_of(obs.channels.begin(), obs.channels.end(),
                                                    [&](const ObservedChannel& c) { return c.is_called(p.where); });
  });
  const auto count = std::ssize(problem.parameters);
  problem.nominal.resize(count);
  for (Index i = 0; i < count; ++i) problem.nominal[i] = problem.parameters[i].nominal;

  problem.around = around.size() > 0 ? around : Eigen::VectorXd::Zero(count);
  const std::vector<Disturbance> wander = surroundings(machine, records, obs);
  Response::Linear linear =
      response.linearise(machine, problem.parameters, problem.nominal + problem.around, true, wander);
  problem.measured = obs.stacked();
  problem.predicted = linear.predicted - linear.sensitivity * problem.around;

  const MeshAllowance allowance(machine, response.mesh_error(), options);
  const MaterialSpread spread = response.has_parts() ? MaterialSpread{} : material_spread(machine);
  problem.tests = tests_of(machine, obs);
  std::vector<TestErrors> errors;
  Index meshed = 0;
  for (const PointTest& test : problem.tests) {
    errors.push_back(errors_of(machine, obs, test, response, allowance));
    meshed += std::ssize(errors.back().joint);
  }
  std::vector<std::size_t> zeroed;
  for (std::size_t k = 0; k < obs.channels.size(); ++k)
    if (!obs.channels[k].is_temperature()) zeroed.push_back(k);
  const auto air = std::ssize(wander);
  const Index starts = linear.start.cols(), held = linear.held.cols();
  problem.columns.setZero(obs.size(), count + starts + air + std::ssize(zeroed) + meshed + held);
  problem.prior_std.resize(problem.columns.cols());
  problem.columns.leftCols(count) = linear.sensitivity;
  for (Index i = 0; i < count; ++i) problem.prior_std[i] = problem.parameters[i].nominal_std;
  problem.columns.middleCols(count, starts) = linear.start;
  problem.prior_std.segment(count, starts) = starts_std(linear.starts, obs);
  problem.columns.middleCols(count + starts, air) = linear.disturbed;
  for (Index k = 0; k < air; ++k) problem.prior_std[count + starts + k] = wander[k].std_K;
  set_zeros(problem, zeroed, count + starts + air);
  set_mesh_errors(problem, errors, count + starts + air + std::ssize(zeroed));
  problem.columns.rightCols(held) = linear.held;
  for (Index k = 0; k < held; ++k) problem.prior_std[problem.prior_std.size() - held + k] = obs.may_hold[k].std;

  set_covariances(problem, allowance, spread, errors);
  problem.expected_std = expected_std(problem);
  drop_causes_like_simpler_ones(machine, problem);
  return problem;
}

void add_parameter(Problem& problem, const Parameter& parameter, const Eigen::VectorXd& column) {
  const auto at = std::ssize(problem.parameters), rest = problem.columns.cols() - at;
  problem.parameters.push_back(parameter);
  problem.nominal.conservativeResize(at + 1);
  problem.nominal[at] = parameter.nominal;
  const Eigen::MatrixXd behind = problem.columns.rightCols(rest);
  const Eigen::VectorXd std_behind = problem.prior_std.tail(rest);
  problem.columns.conservativeResize(Eigen::NoChange, at + 1 + rest);
  problem.prior_std.conservativeResize(at + 1 + rest);
  problem.columns.col(at) = column;
  problem.columns.rightCols(rest) = behind;
  problem.prior_std[at] = parameter.nominal_std;
  problem.prior_std.tail(rest) = std_behind;
}

}  // namespace thermotwin::diagnosis
