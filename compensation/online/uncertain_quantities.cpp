// SPDX-License-Identifier: GPL-3.0-or-later
#include "compensation/online/uncertain_quantities.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/units.h"
#include "solver/operation/layout.h"

namespace thermotwin::compensation {
namespace {

using core::units::hour;
using Eigen::Index;

// Even a stated certainty leaves the mesh and the laws' form: shares of the nominal.
constexpr double least_source = 0.02, least_film = 0.03, least_contact = 0.05, least_wall = 0.05, least_flow = 0.02;
constexpr double air_std_K = 0.2, ambient_std_K = 0.3, inlet_std_K = 0.2;
constexpr double air_memory = 6.0 * hour, ambient_memory = 24.0 * hour;

double share(const core::Uncertain& nominal, double least) { return std::max(nominal.std_percent / 100.0, least); }

int root_ambient(const mesh::Machine& machine, int ambient) {
  for (std::size_t steps = 0; steps < machine.ambients.size(); ++steps) {
    const std::string& follows = machine.ambients[ambient].follows;
    if (follows.empty()) break;
    if (const int next = machine.ambient_index(follows); next >= 0) ambient = next;
  }
  return ambient;
}

void add_sources(const reduction::ReducedModel& model, std::vector<UncertainQuantity>& quantities) {
  const std::vector<solver::Input>& inputs = model.system.layout.inputs;
  int item = 0;
  for (const mesh::SourceSpec& source : model.machine.sources) {
    UncertainQuantity quantity{
        "power of source " + source.id, "1", share(source.scale, least_source), machine_memory_s, {}, {}, {}, -1};
    for (Index k = 0; k < std::ssize(inputs); ++k) {
      if (inputs[k].kind == solver::InputKind::source && inputs[k].item == item) quantity.inputs.push_back(k);
    }
    if (!quantity.inputs.empty()) quantities.push_back(std::move(quantity));
    ++item;
  }
}

void add_terms(const reduction::ReducedModel& model, std::vector<UncertainQuantity>& quantities) {
  const mesh::Machine& machine = model.machine;
  /// @param part  -1: all
  const auto add = [&](const std::string& name, double std, solver::TermKind kind, int item, int part = -1) {
    std::vector<int> terms;
    for (Index t = 0; t < std::ssize(model.system.layout.terms); ++t) {
      const solver::Term& term = model.system.layout.terms[t];
      if (term.kind == kind && term.item == item && (part < 0 || term.part == part)) terms.push_back(t);
    }
    if (!terms.empty()) quantities.push_back({name, "1", std, machine_memory_s, std::move(terms), {}, {}, -1});
  };
  for (int i = 0; i < std::ssize(machine.films); ++i) {
    add("film " + machine.films[i].id, share(machine.films[i].coefficient, least_film), solver::TermKind::film, i);
  }
  for (int i = 0; i < std::ssize(machine.joints); ++i) {
    add("conductance of joint " + machine.joints[i].id, share(machine.joints[i].conductance, least_contact),
        solver::TermKind::contact, i);
  }
  for (int i = 0; i < std::ssize(machine.coolants); ++i) {
    const mesh::CoolantSpec& coolant = machine.coolants[i];
    for (int s = 0; s < std::ssize(coolant.segments); ++s) {
      add("wall film of coolant " + coolant.id + ", segment " + coolant.segments[s].id,
          share(coolant.segments[s].film_coefficient, least_wall), solver::TermKind::coolant_wall, i, s);
    }
    add("flow of coolant " + coolant.id, share(coolant.flow, least_flow), solver::TermKind::coolant_flow, i);
  }
}

void add_ambients(const reduction::ReducedModel& model, std::vector<UncertainQuantity>& quantities) {
  const mesh::Machine& machine = model.machine;
  const solver::Layout& layout = model.system.layout;
  std::vector<std::vector<int>> of_ambient(machine.ambients.size()), of_coolant(machine.coolants.size());
  for (Index k = 0; k < std::ssize(layout.inputs); ++k) {
    const solver::Input& input = layout.inputs[k];
    const int item = input.item;
    int ambient = -1;
    if (input.kind == solver::InputKind::film_ambient) ambient = machine.ambient_index(machine.films[item].ambient);
    if (input.kind == solver::InputKind::contact_ambient) ambient = machine.ambient_index(machine.joints[item].ambient);
    if (ambient >= 0) of_ambient[root_ambient(machine, ambient)].push_back(k);
    if (input.kind == solver::InputKind::coolant_inlet) of_coolant[item].push_back(k);
  }
  for (int i = 0; i < std::ssize(machine.ambients); ++i) {
    if (of_ambient[i].empty()) continue;
    const mesh::AmbientSpec& ambient = machine.ambients[i];
    const bool air = ambient.id == "air";
    // The air is measured, its stated default then does not matter; others mostly are not.
    const double std =
        air ? air_std_K
            : std::max(ambient_std_K, std::abs(ambient.default_C.value) * ambient.default_C.std_percent / 100.0);
    const double memory = air ? air_memory : ambient_memory;
    quantities.push_back({"temperature of ambient " + ambient.id, "K", std, memory, {}, {}, of_ambient[i], i});
  }
  for (int i = 0; i < std::ssize(of_coolant); ++i) {
    if (of_coolant[i].empty()) continue;
    const std::string name = "inlet temperature of coolant " + machine.coolants[i].id;
    quantities.push_back({name, "K", inlet_std_K, ambient_memory, {}, {}, of_coolant[i], -1});
  }
}

}  // namespace

std::vector<UncertainQuantity> uncertain_quantities(const reduction::ReducedModel& model) {
  std::vector<UncertainQuantity> quantities;
  add_sources(model, quantities);
  add_terms(model, quantities);
  add_ambients(model, quantities);
  return quantities;
}

std::vector<std::vector<int>> inputs_of_terms(const reduction::ReducedModel& model) {
  const solver::Layout& layout = model.system.layout;
  std::vector<std::vector<int>> inputs(layout.terms.size());
  for (int k = 0; k < std::ssize(layout.inputs); ++k) {
    if (layout.inputs[k].term >= 0) inputs[layout.inputs[k].term].push_back(k);
  }
  return inputs;
}

Eigen::MatrixXd quantity_rates(const reduction::ReducedModel& model, const std::vector<UncertainQuantity>& quantities,
                               const std::vector<std::vector<int>>& inputs_of_term, const Eigen::VectorXd& p,
                               const Eigen::VectorXd& q, const Eigen::VectorXd& state) {
  const reduction::ReducedSystem& system = model.system;
  Eigen::MatrixXd result(system.order(), std::ssize(quantities));
  Eigen::VectorXd rate(system.order());
  for (Eigen::Index k = 0; k < result.cols(); ++k) {
    const UncertainQuantity& quantity = quantities[k];
    rate.setZero();
    const auto add_input = [&](int input, double amount) {
      if (amount != 0.0) rate += amount * system.inputs.col(input);
    };
    for (const int term : quantity.terms) {
      if (p[term] == 0.0) continue;
      const Eigen::MatrixXd& matrix = system.terms[term];
      if (system.layout.terms[term].kind == solver::TermKind::coolant_flow) {
        rate.noalias() -= p[term] * (matrix * state);
      } else {
        rate.noalias() -= p[term] * (matrix.selfadjointView<Eigen::Lower>() * state);  // half the memory
      }
      for (const int input : inputs_of_term[term]) add_input(input, q[input]);
    }
    for (const int input : quantity.inputs) add_input(input, q[input]);
    for (const int input : quantity.ambient_inputs) add_input(input, p[system.layout.inputs[input].term]);
    result.col(k) = rate;
  }
  return result;
}

}  // namespace thermotwin::compensation
