// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/placement/responses.h"

#include <algorithm>
#include <cmath>

#include "compensation/measurement/virtual_measurement.h"
#include "compensation/online/uncertain_quantities.h"
#include "core/progress.h"
#include "core/thread_pool.h"
#include "diagnosis/causes/hypothesis.h"
#include "reduction/model/reduced_simulation.h"
#include "study/plan/items.h"

namespace thermotwin::study {

using diagnosis::Kind;
using Eigen::MatrixXd;

namespace {

constexpr Kind ratio_kinds[] = {Kind::source_power,     Kind::film_coefficient, Kind::contact_conductance,
                                Kind::coolant_coupling, Kind::coolant_flow,     Kind::volume_exchange};

std::vector<Eigen::VectorXd> states_of(const reduction::ReducedModel& model, const mesh::Machine& machine,
                                       const solver::LoadProgram& load) {
  reduction::RunRecord record;
  reduction::ReducedRun how;
  how.tell = false;
  how.record = &record;
  reduction::simulate_reduced(model, machine, load, {mesh::home_pose(machine)}, how);
  std::vector<Eigen::VectorXd> states;
  for (const auto& output : record.outputs) states.push_back(output.state);
  return states;
}

Eigen::VectorXd priors(const mesh::Machine& machine, const std::vector<UncertainParameter>& parameters,
                       const solver::LoadProgram& load) {
  Eigen::VectorXd shares = Eigen::VectorXd::Ones(std::ssize(parameters));
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    if (parameters[p].parameter.kind != Kind::ambient_offset) continue;
    const int at = machine.ambient_index(parameters[p].parameter.where);
    if (at < 0 || compensation::is_told(machine.ambients[at])) continue;
    const double half_gap_K = 0.5 * (load.initial_C() - machine.ambients[at].default_C.value);
    shares[p] = std::hypot(parameters[p].std, half_gap_K) / parameters[p].std;
  }
  return shares;
}

}  // namespace

std::vector<UncertainParameter> uncertain_parameters(const reduction::ReducedModel& model) {
  const mesh::Machine& machine = model.machine;
  std::vector<UncertainParameter> found;
  for (const Kind kind : ratio_kinds) {
    for (const Item& item : items_of(machine, kind)) {
      if (!(item.std() > 0.0)) continue;
      found.push_back({diagnosis::make_parameter(kind, item.id), item.std(), compensation::machine_memory_s});
    }
  }
  for (const compensation::UncertainQuantity& quantity : compensation::uncertain_quantities(model)) {
    if (quantity.ambient < 0) continue;
    const std::string& id = machine.ambients[quantity.ambient].id;
    found.push_back({diagnosis::make_parameter(Kind::ambient_offset, id), quantity.std, quantity.memory});
  }
  return found;
}

LoadResponses responses(const reduction::ReducedModel& model, const std::vector<UncertainParameter>& parameters,
                        const solver::LoadProgram& load, double every_s) {
  const std::vector<double> outputs = load.output_times();
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::round(every_s / load.output_interval())));
  LoadResponses found;
  found.load = load.name();
  found.prior = priors(model.machine, parameters, load);
  std::vector<std::size_t> kept;
  for (std::size_t i = stride; i < outputs.size(); i += stride) kept.push_back(i);
  if (kept.empty()) kept.push_back(outputs.size() - 1);
  for (const std::size_t i : kept) found.times.push_back(outputs[i]);
  const auto count = std::ssize(parameters);
  found.states.assign(kept.size(), MatrixXd::Zero(model.system.order(), count));
  core::Progress progress("responses of '" + load.name() + "'", parameters.size());
  core::parallel_for(0, parameters.size(), [&](std::size_t p) {
    const UncertainParameter& of = parameters[p];
    const auto run = [&](double sign) {
      return states_of(
          model, diagnosis::with_parameter(model.machine, of.parameter, of.parameter.nominal + sign * of.std), load);
    };
    const auto above = run(1.0), below = run(-1.0);
    for (std::size_t t = 0; t < kept.size(); ++t) found.states[t].col(p) = 0.5 * (above[kept[t]] - below[kept[t]]);
    progress.advance();
  });
  return found;
}

}  // namespace thermotwin::study
