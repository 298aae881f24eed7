// SPDX-License-Identifier: GPL-3.0-or-later
#include "solver/thermal/heat_balance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "solver/operation/layout.h"

namespace thermotwin::solver {

using Eigen::Index;
using Eigen::VectorXd;

HeatBalance::HeatBalance(const mesh::Machine& machine, const ThermalSystem& system) {
  const VectorXd ones = VectorXd::Ones(system.size);
  capacity_ = system.capacity.transpose() * ones;
  std::vector<double> signs;
  const auto item = [&](const std::string& name) -> int {
    const std::size_t place = std::find(names_.begin(), names_.end(), name) - names_.begin();
    if (place == names_.size()) {
      names_.push_back(name);
      const bool coolant = name.starts_with("coolant ");
      std::string column = name + (coolant ? ".cooling_power_W" : ".power_W");
      std::replace(column.begin(), column.end(), ' ', '.');
      columns_.push_back(std::move(column));
      signs.push_back(coolant ? -1.0 : 1.0);
    }
    return place;
  };
  const auto name_of = [&](TermKind kind, int index) {
    const std::size_t i = index;
    switch (kind) {
      case TermKind::film: return "film " + machine.films[i].id;
      case TermKind::contact: return "joint " + machine.joints[i].id;
      case TermKind::coolant_wall:
      case TermKind::coolant_flow: return "coolant " + machine.coolants[i].id;
      case TermKind::volume_exchange:
      case TermKind::volume_given: return "volume " + machine.volumes[i].id;
    }
    return std::string();
  };
  // What radiation has from place to place beside its films' own coefficients.
  if (system.local) local_item_ = item("radiation from place to place");
  for (std::size_t k = 0; k < machine.sources.size(); ++k) item("source " + machine.sources[k].id);
  for (std::size_t j = 0; j < system.terms.size(); ++j) {
    const VectorXd sums = system.terms[j].transpose() * ones;
    // Between two bodies the sums are rounding errors.
    const double least = 1e-12 * (system.terms[j].nonZeros() > 0 ? system.terms[j].coeffs().abs().maxCoeff() : 0.0);
    Sum sum{sums.sparseView(1.0, least), -1};
    if (sum.of.nonZeros() > 0) sum.item = item(name_of(system.layout.terms[j].kind, system.layout.terms[j].item));
    terms_.push_back(std::move(sum));
    const Term& term = system.layout.terms[j];
    const auto within = [&](std::string column, double sign) {
      VectorXd on_bodies = ones;
      on_bodies.tail(system.size - system.nodes).setZero();
      const VectorXd walls = system.terms[j].transpose() * on_bodies;
      inner_.push_back({std::move(column), j, sign, walls.sparseView(1.0, least)});
    };
    if (term.kind == TermKind::coolant_wall) {
      const mesh::CoolantSpec& coolant = machine.coolants[term.item];
      within("coolant." + coolant.id + "." + coolant.segments[term.part].id + ".cooling_power_W", 1.0);
    } else if (term.kind == TermKind::film && machine.volume_index(machine.films[term.item].ambient) >= 0) {
      within("film." + machine.films[term.item].id + ".power_W", -1.0);
    }
  }
  for (std::size_t k = 0; k < system.layout.inputs.size(); ++k) {
    const Input& input = system.layout.inputs[k];
    const std::string name = input.kind == InputKind::source
                                 ? "source " + machine.sources[input.item].id
                                 : name_of(system.layout.terms[input.term].kind, input.item);
    inputs_.emplace_back(system.inputs.col(k).sum(), item(name));
  }
  heat_ = VectorXd::Zero(std::ssize(names_));
  sign_ = Eigen::Map<const VectorXd>(signs.data(), heat_.size());
  carried_ = VectorXd::Zero(std::ssize(inner_));
}

void HeatBalance::add(const VectorXd& start, const VectorXd& end, const VectorXd& mean, const VectorXd& p,
                      const VectorXd& q, double step_s, const LocalTerms::Change* local) {
  const VectorXd rise = end - start;
  stored_ += capacity_.dot(rise);
  VectorXd heat = VectorXd::Zero(heat_.size());
  const auto flow = [&](int item, double power) { heat[item] += step_s * power; };
  for (std::size_t j = 0; j < terms_.size(); ++j) {
    if (const double coefficient = p[j]; coefficient != 0.0 && terms_[j].item >= 0)
      flow(terms_[j].item, -coefficient * terms_[j].of.dot(mean));
  }
  for (std::size_t i = 0; i < inner_.size(); ++i)
    carried_[i] += inner_[i].sign * step_s * p[inner_[i].term] * inner_[i].walls.dot(mean);
  for (std::size_t k = 0; k < inputs_.size(); ++k)
    if (const double amount = q[k]; amount != 0.0) flow(inputs_[k].second, amount * inputs_[k].first);
  if (local && !local->empty()) {
    stored_ += (local->capacity * rise).sum();
    flow(local_item_, local->source.sum() - (local->conduction * mean).sum());
  }
  heat_ += heat;
  throughput_ += heat.cwiseAbs().sum();
}

std::vector<HeatBalance::Item> HeatBalance::items() const {
  std::vector<Item> list;
  for (std::size_t i = 0; i < names_.size(); ++i) list.push_back({names_[i], heat_[i]});
  return list;
}

std::vector<std::string> HeatBalance::columns() const {
  std::vector<std::string> list{"stored_W"};
  list.insert(list.end(), columns_.begin(), columns_.end());
  for (const Inner& inner : inner_) list.push_back(inner.column);
  return list;
}

VectorXd HeatBalance::amounts() const {
  VectorXd list(1 + heat_.size() + carried_.size());
  list << stored_, sign_.cwiseProduct(heat_), carried_;
  return list;
}

double HeatBalance::gap() const {
  constexpr double nothing_K = 1e-9;  // where all is at one temperature, what flows is rounding
  return std::abs(stored_ - heat_.sum()) / std::max(throughput_, nothing_K * capacity_.sum());
}

std::string HeatBalance::brief() const {
  double in = 0.0, out = 0.0;
  for (Index i = 0; i < heat_.size(); ++i) (heat_[i] > 0.0 ? in : out) += heat_[i];
  const auto kJ = [](double J) { return std::round(1e-2 * J) / 10.0 + 0.0; };  // no -0.0
  return fmt::format("heat balance: {:.1f} kJ in, {:.1f} kJ out, {:.1f} kJ stored; imbalance {:.1e} of the throughput",
                     kJ(in), kJ(-out), kJ(stored_), gap());
}

void HeatBalance::save(core::BinaryWriter& out) const {
  out.matrix(heat_);
  out.matrix(carried_);
  out.number(stored_);
  out.number(throughput_);
}

void HeatBalance::load(core::BinaryReader& in) {
  heat_ = in.matrix();
  carried_ = in.matrix();
  stored_ = in.number();
  throughput_ = in.number();
}

}  // namespace thermotwin::solver
