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
  return &a != &b && a.record == b.record && !a.is_temperature() && !b.is_temperature() &&
         a.channel.unit == b.channel.unit && a.channel.pose_text == b.channel.pose_text;
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

/// Where a model does not know its parts, the stated spread of expansion and heat capacity is not a
/// parameter but part of the model error: a factor of displacements, a wandering error of transients.
/// @param model_error  of mesh and discretisation
/// @param beside  (n x others) what the other directions at the pose move
ChannelCovariance channel_covariance(const ObservedChannel& channel, const Eigen::VectorXd& predicted,
                                     const Eigen::MatrixXd& beside, double start_C, const MaterialSpread& spread,
                                     const ModelError& model_error, double& amplitude) {
  const Floor floor = floor_of(channel);
  ChannelCovariance cov;
  cov.time = channel.time;
  const double noise = std::max(channel.channel.uncertainty, floor.noise);
  cov.noise_variance = noise * noise * channel.samples.cwiseInverse().cwiseMax(least_noise_share);
  const bool from_first = channel.channel.zero == compensation::Zero::first;
  const double at_start = from_first ? 0.0 : channel.is_temperature() ? start_C : predicted[0];
  const Eigen::VectorXd moved = predicted.array() - at_start;
  // Held-out values must not enter, not even the size of an error term.
  const Eigen::VectorXd measured_moved =
      channel.value.head(channel.fitted).array() - (from_first ? 0.0 : channel.value[0]);
  amplitude = std::max({root_mean_square(moved), root_mean_square(measured_moved), 3.0 * floor.slow});
  const double factor = channel.is_temperature() ? model_error.share : std::hypot(model_error.share, spread.expansion);
  cov.shapes.resize(channel.size(), 1 + beside.cols());
  cov.shapes << factor * moved, model_error.share * beside;
  double motion = amplitude;
  if (model_error.of_whole_motion && beside.size() > 0)
    motion = std::hypot(amplitude, beside.norm() / std::sqrt(static_cast<double>(channel.size())));
  const double slow = std::hypot(model_error.share * motion, 0.5 * spread.heat * amplitude);
  cov.wander = {{std::hypot(slow, floor.slow), slow_hours * hour},
                {std::hypot(0.5 * slow, floor.fast), fast_hours * hour}};
  const double seen = root_mean_square((channel.value - predicted).head(channel.fitted));
  for (std::size_t i = 0; i < std::size(form_error_share); ++i)
    cov.wander.push_back({form_error_share[i] * seen, form_error_hours[i] * hour});
  return cov;
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

Eigen::MatrixXd Problem::fitted(const Eigen::MatrixXd& stacked) const {
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

  std::vector<std::size_t> zeroed;  // displacements: the zero itself was read with noise
  for (std::size_t k = 0; k < obs.channels.size(); ++k)
    if (!obs.channels[k].is_temperature()) zeroed.push_back(k);
  const auto air = std::ssize(wander);
  const Index starts = linear.start.cols(), held = linear.held.cols();
  problem.columns.setZero(obs.size(), count + starts + air + std::ssize(zeroed) + held);
  problem.prior_std.resize(problem.columns.cols());
  problem.columns.leftCols(count) = linear.sensitivity;
  for (Index i = 0; i < count; ++i) problem.prior_std[i] = problem.parameters[i].nominal_std;
  problem.columns.middleCols(count, starts) = linear.start;
  problem.prior_std.segment(count, starts) = starts_std(linear.starts, obs);
  problem.columns.middleCols(count + starts, air) = linear.disturbed;
  for (Index k = 0; k < air; ++k) problem.prior_std[count + starts + k] = wander[k].std_K;
  for (Index z = 0; z < std::ssize(zeroed); ++z) {
    const ObservedChannel& channel = obs.channels[zeroed[z]];
    const Index column = count + starts + air + z;
    problem.columns.col(column).segment(problem.first_row(zeroed[z]), channel.size()).setOnes();
    problem.prior_std[column] = std::max(channel.channel.uncertainty, floor_of(channel).noise);
  }

  problem.columns.rightCols(held) = linear.held;
  for (Index k = 0; k < held; ++k) problem.prior_std[problem.prior_std.size() - held + k] = obs.may_hold[k].std;

  const MeshAllowance allowance(machine, response.mesh_error(), options);
  const MaterialSpread spread = response.has_parts() ? MaterialSpread{} : material_spread(machine);
  problem.amplitude.resize(std::ssize(obs.channels));
  problem.expected_std.resize(obs.size());
  for (std::size_t k = 0; k < obs.channels.size(); ++k) {
    const ObservedChannel& channel = obs.channels[k];
    const Index first = problem.first_row(k);
    problem.covariance.push_back(channel_covariance(channel, problem.predicted.segment(first, channel.size()),
                                                    moves_beside(problem, k), obs.each()[channel.record].start_C,
                                                    spread, {allowance.of(channel), allowance.is_of_whole_motion()},
                                                    problem.amplitude[k]));
    problem.expected_std.segment(first, channel.size()) = problem.covariance.back().variance();
  }
  problem.expected_std += (problem.columns * problem.prior_std.asDiagonal()).rowwise().squaredNorm();
  problem.expected_std = problem.expected_std.cwiseSqrt();
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
