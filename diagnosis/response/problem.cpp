// SPDX-License-Identifier: GPL-3.0-or-later
#include "diagnosis/response/problem.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>

#include "diagnosis/causes/kinds.h"
#include "diagnosis/causes/parameter.h"
#include "diagnosis/causes/shared_causes.h"
#include "diagnosis/record/diagnose_options.h"
#include "diagnosis/response/channel_errors.h"
#include "diagnosis/response/mesh_allowance.h"
#include "diagnosis/response/simpler_causes.h"
#include "diagnosis/response/start_modes.h"
#include "diagnosis/response/surroundings.h"

namespace thermotwin::diagnosis {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

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
    const VectorXd gains = gains_of(test);
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
    for (const MatrixXd& one : errors[t].joint) {
      for (Index k = 0; k < one.cols(); ++k)
        problem.columns.col(first).segment(problem.first_row(problem.tests[t].channels[k]), one.rows()) = one.col(k);
      problem.prior_std[first++] = 1.0;
    }
  }
}

/// @param first, starts, held  columns of starts, and number of the last columns
std::shared_ptr<const OpenState> open_state(const Problem& problem, Index first, Index starts, Index held) {
  const auto each = problem.observations.each();
  const auto is_open = [](const Observations& record) {
    return begins_warm(record) ||
           std::any_of(record.may_hold.begin(), record.may_hold.end(), [](const auto& may) { return may.in_pause; });
  };
  if (std::none_of(each.begin(), each.end(), is_open)) return nullptr;
  const Whitener whitener(problem.fitted_covariance());
  const MatrixXd white = whitener.whiten(problem.fitted(problem.columns));
  MatrixXd precision = white.transpose() * white;
  precision.diagonal() += problem.prior_std.cwiseMax(1e-9).cwiseAbs2().cwiseInverse();
  std::vector<Index> open;
  for (Index c = 0; c < problem.columns.cols(); ++c)
    if ((c >= first && c < first + starts) || c >= problem.columns.cols() - held) open.push_back(c);
  const MatrixXd estimates = precision.llt().solve(white.transpose());
  return std::make_shared<const OpenState>(
      OpenState{problem.columns(Eigen::all, open), estimates(open, Eigen::all), whitener});
}

}  // namespace

Index Problem::first_row(std::size_t channel) const {
  Index row = 0;
  for (std::size_t k = 0; k < channel; ++k) row += observations.channels[k].size();
  return row;
}

MatrixXd Problem::decorrelated(const MatrixXd& stacked) const {
  return tests.empty() ? stacked : with_sums(tests, observations, stacked);
}

MatrixXd Problem::fitted(const MatrixXd& as_measured) const {
  const MatrixXd sums = tests.empty() ? MatrixXd() : decorrelated(as_measured);
  const MatrixXd& stacked = tests.empty() ? as_measured : sums;
  Index total = 0;
  for (const ObservedChannel& channel : observations.channels) total += channel.fitted;
  MatrixXd result(total, stacked.cols());
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
  return with_parameters(machine, moved, Eigen::Map<VectorXd>(values.data(), std::ssize(values)));
}

VectorXd Problem::moved_around(const std::vector<int>& but) const {
  VectorXd moved = VectorXd::Zero(measured.size());
  for (Index i = 0; i < around.size(); ++i)
    if (around[i] != 0.0 && std::find(but.begin(), but.end(), i) == but.end()) moved += around[i] * columns.col(i);
  return moved;
}

VectorXd Problem::settled(const VectorXd& predicted) const {
  if (!open_state) return predicted;
  return predicted +
         open_state->columns * (open_state->gain * open_state->whitener.whiten(fitted(measured - predicted)));
}

Problem make_problem(const mesh::Machine& machine, Records records, Observations observations, const Response& response,
                     const DiagnoseOptions& options, const VectorXd& around) {
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

  problem.around = around.size() > 0 ? around : VectorXd::Zero(count);
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
  problem.prior_std.segment(count, starts) = linear.start_std;
  problem.columns.middleCols(count + starts, air) = linear.disturbed;
  for (Index k = 0; k < air; ++k) problem.prior_std[count + starts + k] = wander[k].std_K;
  set_zeros(problem, zeroed, count + starts + air);
  set_mesh_errors(problem, errors, count + starts + air + std::ssize(zeroed));
  problem.columns.rightCols(held) = linear.held;
  for (Index k = 0; k < held; ++k) problem.prior_std[problem.prior_std.size() - held + k] = obs.may_hold[k].std;

  set_covariances(problem, allowance, spread, errors);
  problem.open_state = open_state(problem, count, starts, held);
  problem.expected_std = expected_std(problem);
  drop_causes_like_simpler_ones(machine, problem);
  return problem;
}

void add_parameter(Problem& problem, const Parameter& parameter, const VectorXd& column) {
  const auto at = std::ssize(problem.parameters), rest = problem.columns.cols() - at;
  problem.parameters.push_back(parameter);
  problem.nominal.conservativeResize(at + 1);
  problem.nominal[at] = parameter.nominal;
  const MatrixXd behind = problem.columns.rightCols(rest);
  const VectorXd std_behind = problem.prior_std.tail(rest);
  problem.columns.conservativeResize(Eigen::NoChange, at + 1 + rest);
  problem.prior_std.conservativeResize(at + 1 + rest);
  problem.columns.col(at) = column;
  problem.columns.rightCols(rest) = behind;
  problem.prior_std[at] = parameter.nominal_std;
  problem.prior_std.tail(rest) = std_behind;
}

}  // namespace thermotwin::diagnosis
