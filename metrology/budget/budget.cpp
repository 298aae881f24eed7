// SPDX-License-Identifier: GPL-3.0-or-later
#include "metrology/budget/budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/config.h"
#include "core/dense_algebra.h"
#include "core/error.h"
#include "core/text.h"
#include "metrology/budget/budget_keys.h"

namespace thermotwin::metrology {

using core::InputError;
using core::Node;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

constexpr std::size_t most_inputs = 200, most_quantities = 50;
/// Least degrees of freedom of a half width: w (1 +- sqrt(1.5 / 1.5)) reaches 0.
constexpr double inexact_limits = 1.5;
constexpr double most_values = 1e8;  ///< draws times measurands

struct Word {
  Distribution distribution;
  const char* word;
  double divisor;  ///< half width over standard deviation
};
const std::vector<Word> words = {{Distribution::normal, "normal", 0.0},
                                 {Distribution::rectangular, "rectangular", std::sqrt(3.0)},
                                 {Distribution::triangular, "triangular", std::sqrt(6.0)},
                                 {Distribution::arcsine, "arcsine", std::sqrt(2.0)}};

std::vector<std::string> names_of(const Budget& budget) {
  std::vector<std::string> names;
  for (const BudgetInput& input : budget.inputs) names.push_back(input.name);
  return names;
}

void require_name(const std::string& name, const std::string& place, const std::vector<std::string>& seen) {
  if (!Formula::may_name(name)) {
    throw InputError(place, "'" + name + "'",
                     "a letter, then letters, digits and _, at most 40; no name of a function or constant");
  }
  if (std::find(seen.begin(), seen.end(), name) != seen.end())
    throw InputError(place, "'" + name + "' a second time", "each name once");
}

BudgetInput read_input(const Node& node, VectorXd& readings) {
  BudgetInput input{node.text("name"), node.text("unit"), node.text("says")};
  const std::string word = node.choice("distribution");
  const Word& row = *std::find_if(words.begin(), words.end(), [&](const Word& w) { return w.word == word; });
  input.distribution = row.distribution;
  const bool normal = row.distribution == Distribution::normal;
  if (normal && node.has("half_width")) {
    throw InputError(
        node.place("half_width"),
        node.has("distribution") ? "half_width of a normal distribution" : "half_width without distribution",
        "distribution = \"rectangular\", \"triangular\" or \"arcsine\"; a normal one has std");
  }
  if (node.has("readings")) {
    for (const char* other : {"value", "std", "half_width", "degrees_of_freedom"})
      if (node.has(other)) throw InputError(node.place(other), "beside readings", "readings alone");
    if (!normal) throw InputError(node.place("distribution"), "'" + word + "' of readings", "normal");
    const std::vector<double> list = node.numbers("readings");
    const Index n = std::ssize(list);
    if (n < 2) throw InputError(node.place("readings"), fmt::format("{} readings", n), "at least 2");
    readings = Eigen::Map<const VectorXd>(list.data(), n);
    input.value = readings.mean();
    input.std = std::sqrt((readings.array() - input.value).square().sum() / (n - 1) / n);
    input.degrees_of_freedom = n - 1;
  } else if (normal) {
    input.value = node.number_or("value", 0.0);
    input.std = node.number("std");
    if (node.has("degrees_of_freedom")) input.degrees_of_freedom = node.number("degrees_of_freedom");
  } else {
    input.value = node.number_or("value", 0.0);
    input.std = node.has("std") ? node.number("std") : node.number("half_width") / row.divisor;
    if (node.has("degrees_of_freedom")) {
      input.degrees_of_freedom = node.number("degrees_of_freedom");
      // Fewer would let the half width be negative in some draws.
      if (input.degrees_of_freedom < inexact_limits)
        throw InputError(node.place("degrees_of_freedom"), fmt::format("{:g}", input.degrees_of_freedom),
                         fmt::format("{:g} or more of a distribution with limits", inexact_limits));
    }
  }
  node.finish();
  return input;
}

Index input_named(const std::vector<std::string>& names, const std::string& name, const std::string& place) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    throw InputError(place, "'" + name + "'",
                     "inputs: " + core::join(names) + " (nearest: " + core::nearest(name, names) + ")");
  }
  return found - names.begin();
}

void read_simultaneous(const Node& root, const std::vector<VectorXd>& readings, Budget& budget) {
  const std::vector<std::string> names = names_of(budget), together = root.texts_or_empty("simultaneous");
  const std::string place = root.has("simultaneous") ? root.place("simultaneous") : "";
  std::vector<Index> at;
  for (const std::string& name : together) {
    const Index i = input_named(names, name, place);
    if (readings[i].size() == 0) throw InputError(place, "'" + name + "' without readings", "inputs with readings");
    if (readings[i].size() != readings[at.empty() ? i : at.front()].size()) {
      throw InputError(place, fmt::format("{} readings of '{}'", readings[i].size(), name),
                       fmt::format("as many as '{}' has: {}", together.front(), readings[at.front()].size()));
    }
    if (std::find(at.begin(), at.end(), i) != at.end()) throw InputError(place, "'" + name + "' twice", "each once");
    at.push_back(i);
  }
  for (const Index a : at) {
    for (const Index b : at) {
      if (a == b) continue;
      const VectorXd x = readings[a].array() - readings[a].mean(), y = readings[b].array() - readings[b].mean();
      const double norm = x.norm() * y.norm();
      budget.correlation(a, b) = norm > 0.0 ? x.dot(y) / norm : 0.0;
    }
  }
}

void read_correlations(const Node& root, Budget& budget) {
  const std::vector<std::string> names = names_of(budget);
  for (const Node& node : root.tables("correlation")) {
    const std::vector<std::string> pair = node.texts("between");
    const std::string place = node.place("between");
    if (pair.size() != 2) throw InputError(place, fmt::format("{} names", pair.size()), "the names of two inputs");
    const Index a = input_named(names, pair[0], place), b = input_named(names, pair[1], place);
    if (a == b) throw InputError(place, "'" + pair[0] + "' with itself", "two inputs");
    if (budget.correlation(a, b) != 0.0)
      throw InputError(place, "'" + pair[0] + "' and '" + pair[1] + "' a second time", "each pair once");
    budget.correlation(a, b) = budget.correlation(b, a) = node.number("coefficient");
    node.finish();
  }
  const double smallest =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(budget.correlation, Eigen::EigenvaluesOnly).eigenvalues()[0];
  if (smallest < -1e-9) {
    throw InputError(budget.source + " correlation",
                     fmt::format("coefficients with a negative variance: smallest eigenvalue {:.4g}", smallest),
                     "coefficients that quantities can have together: no eigenvalue below 0");
  }
}

/// Numbers the parts of the graph of correlations.
void find_groups(Budget& budget) {
  const int n = budget.inputs.size();
  std::vector<int> group(n);
  std::iota(group.begin(), group.end(), 0);
  for (bool changed = true; changed;) {
    changed = false;
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < i; ++k) {
        if (budget.correlation(i, k) == 0.0 || group[i] == group[k]) continue;
        group[i] = group[k] = std::min(group[i], group[k]);
        changed = true;
      }
    }
  }
  for (int i = 0; i < n; ++i) budget.inputs[i].group = group[i];
}

void read_quantities(const Node& root, Budget& budget) {
  std::vector<std::string> names = names_of(budget);
  for (const Node& node : root.tables("quantity")) {
    BudgetQuantity quantity{node.text("name"), node.text("unit"), node.text("formula")};
    require_name(quantity.name, node.place("name"), names);
    Formula(quantity.formula, names, node.place("formula"));
    node.finish();
    names.push_back(quantity.name);
    budget.quantities.push_back(std::move(quantity));
  }
  const std::size_t count = budget.quantities.size();
  if (count == 0 || count > most_quantities) {
    throw InputError(budget.source + " quantity", fmt::format("{} of them", count),
                     fmt::format("1 to {} [[quantity]] tables", most_quantities));
  }
  VectorXd at(std::ssize(budget.inputs));
  for (Index i = 0; i < at.size(); ++i) at[i] = budget.inputs[i].value;
  const VectorXd values = Budget::Model(budget)(at);
  for (Index i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) {
      throw InputError(fmt::format("{} quantity[{}].formula", budget.source, i + 1),
                       fmt::format("{} at the inputs' values from '{}'", values[i], budget.quantities[i].formula),
                       "a finite value");
    }
  }
}

void read_options(const Node& root, Budget& budget) {
  if (const auto coverage = root.table_if("coverage")) {
    budget.probability = coverage->number("probability");
    if (coverage->has("factor")) {
      budget.factor = coverage->number("factor");
      // The draws get the probability that the factor has of a normal distribution.
      if (!coverage->has("probability"))
        budget.probability = std::clamp(std::erf(*budget.factor / std::sqrt(2.0)), 0.5, 0.9999);
    }
    coverage->finish();
  }
  if (const auto monte_carlo = root.table_if("monte_carlo")) {
    budget.draws = monte_carlo->integer("draws");
    budget.seed = monte_carlo->integer("seed");
    budget.digits = monte_carlo->integer("digits");
    monte_carlo->finish();
  }
  const double values = 1.0 * budget.draws * budget.quantities.size();
  if (values > most_values) {
    throw InputError(budget.source + " monte_carlo.draws", fmt::format("{}", budget.draws),
                     fmt::format("at most {:.0f} with {} quantities", most_values / budget.quantities.size(),
                                 budget.quantities.size()));
  }
}

Budget read(const core::Config& config) {
  const Node root = config.root();
  root.schema(1);
  Budget budget;
  budget.source = config.source();
  budget.says = root.text_or("says", "");
  std::vector<VectorXd> readings;
  for (const Node& node : root.tables("input")) {
    readings.emplace_back();
    BudgetInput input = read_input(node, readings.back());
    require_name(input.name, node.place("name"), names_of(budget));
    budget.inputs.push_back(std::move(input));
  }
  const std::size_t count = budget.inputs.size();
  if (count == 0 || count > most_inputs) {
    throw InputError(budget.source + " input", fmt::format("{} of them", count),
                     fmt::format("1 to {} [[input]] tables", most_inputs));
  }
  budget.correlation = MatrixXd::Identity(std::ssize(budget.inputs), std::ssize(budget.inputs));
  read_simultaneous(root, readings, budget);
  read_correlations(root, budget);
  find_groups(budget);
  read_quantities(root, budget);
  read_options(root, budget);
  root.finish();
  return budget;
}

}  // namespace

Budget Budget::load(const std::filesystem::path& path) { return read(core::Config::load(path, &budget_keys())); }
Budget Budget::parse(const std::string& text, const std::string& source) {
  return read(core::Config::parse(text, source, &budget_keys()));
}

Budget::Model::Model(const Budget& budget) : inputs_(std::ssize(budget.inputs)) {
  std::vector<std::string> names = names_of(budget);
  for (const BudgetQuantity& quantity : budget.quantities) {
    formulas_.emplace_back(quantity.formula, names, budget.source + " formula of " + quantity.name);
    names.push_back(quantity.name);
  }
  values_ = VectorXd::Zero(std::ssize(names));
}

VectorXd Budget::Model::operator()(const VectorXd& inputs) const {
  values_.head(inputs_) = inputs;
  for (std::size_t i = 0; i < formulas_.size(); ++i) values_[inputs_ + i] = formulas_[i](values_.data());
  return values_.tail(std::ssize(formulas_));
}

}  // namespace thermotwin::metrology
