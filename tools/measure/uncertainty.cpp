// SPDX-License-Identifier: GPL-3.0-or-later
// The verb measure uncertainty: a budget by both methods side by side.

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/file.h"
#include "core/text.h"
#include "metrology/budget/budget.h"
#include "metrology/budget/gum.h"
#include "metrology/budget/monte_carlo.h"
#include "tools/measure/json_number.h"
#include "tools/measure/measure.h"

namespace thermotwin::tools {
namespace {

using Eigen::Index;
using metrology::Budget;
using metrology::Comparison;
using metrology::CoverageInterval;
using metrology::GumResult;
using metrology::MonteCarloResult;
using nlohmann::json;

using Rows = std::vector<std::vector<std::string>>;

std::string number(double value) { return fmt::format("{:.5g}", value); }

/// A value with the digits that its uncertainty gives a meaning: two beyond the first of u, six at least.
std::string beside(double value, double std) {
  const bool counts = value != 0.0 && std > 0.0 && std::isfinite(value) && std::isfinite(std);
  const double digits = counts ? std::floor(std::log10(std::abs(value))) - std::floor(std::log10(std)) + 3.0 : 6.0;
  return fmt::format("{:.{}g}", value, std::lround(std::clamp(digits, 6.0, 17.0)));
}

std::string verdict(const Comparison& compared) {
  switch (compared.agreement) {
    case metrology::Agreement::agree: return "agree";
    case metrology::Agreement::disagree: return "disagree";
    default: return "undecided";
  }
}

/// Least degrees of freedom of the inputs that are drawn from t distributions: to 2 of them they have no variance, to 1
/// no mean either.
double least_degrees(const Budget& budget, const GumResult& linear, Index quantity) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < budget.inputs.size(); ++i) {
    const metrology::BudgetInput& input = budget.inputs[i];
    const bool counts = input.distribution == metrology::Distribution::normal && input.std > 0.0;
    if (counts && linear.sensitivity(quantity, i) != 0.0) least = std::min(least, input.degrees_of_freedom);
  }
  return least;
}

std::vector<Comparison> comparisons(const Budget& budget, const GumResult& linear, const MonteCarloResult& drawn) {
  std::vector<Comparison> all;
  for (Index i = 0; i < linear.value.size(); ++i) all.push_back(metrology::compare(budget, linear, drawn, i));
  return all;
}

json json_of(const Budget& budget, const GumResult& linear, const MonteCarloResult& drawn) {
  const std::vector<Comparison> compared = comparisons(budget, linear, drawn);
  const auto ends = [](const CoverageInterval& at) { return json{at.low, at.high}; };
  json quantities = json::array();
  for (Index i = 0; i < linear.value.size(); ++i) {
    const double least = least_degrees(budget, linear, i);
    json contributions = json::array(), gum_correlation = json::object(), drawn_correlation = json::object();
    for (Index k = 0; k < linear.contribution.cols(); ++k) {
      const metrology::BudgetInput& input = budget.inputs[k];
      contributions.push_back({{"input", input.name},
                               {"value", input.value},
                               {"std", input.std},
                               {"sensitivity", linear.sensitivity(i, k)},
                               {"contribution", linear.contribution(i, k)}});
    }
    for (Index k = 0; k < linear.value.size(); ++k) {
      gum_correlation[budget.quantities[k].name] = linear.correlation(i, k);
      drawn_correlation[budget.quantities[k].name] = drawn.correlation(i, k);
    }
    quantities.push_back({{"name", budget.quantities[i].name},
                          {"unit", budget.quantities[i].unit},
                          {"gum",
                           {{"value", linear.value[i]},
                            {"std", linear.std[i]},
                            {"degrees_of_freedom", number_or_null(linear.degrees_of_freedom[i])},
                            {"coverage_factor", linear.factor[i]},
                            {"expanded", linear.expanded[i]},
                            {"correlation", gum_correlation},
                            {"contributions", contributions}}},
                          {"monte_carlo",
                           {{"mean", least > 1.0 ? json(drawn.mean[i]) : json(nullptr)},
                            {"std", least > 2.0 ? json(drawn.std[i]) : json(nullptr)},
                            {"interval", ends(drawn.symmetric[i])},
                            {"shortest_interval", ends(drawn.shortest[i])},
                            {"interval_std", number_or_null(drawn.end_std[i])},
                            {"correlation", drawn_correlation}}},
                          {"tolerance", compared[i].tolerance},
                          {"ends_apart", {compared[i].low_apart, compared[i].high_apart}},
                          {"verdict", verdict(compared[i])},
                          {"enough_draws", compared[i].enough_draws}});
  }
  return {{"budget", budget.source},
          {"says", budget.says},
          {"probability", budget.probability},
          {"draws", budget.draws},
          {"quantities", quantities}};
}

std::string contributions_text(const Budget& budget, const GumResult& linear) {
  Rows rows{{"input", "unit", "value", "u", "measurand", "c", "c u"}};
  for (Index i = 0; i < linear.value.size(); ++i) {
    for (Index k = 0; k < linear.contribution.cols(); ++k) {
      const metrology::BudgetInput& input = budget.inputs[k];
      if (linear.contribution(i, k) == 0.0 && linear.sensitivity(i, k) == 0.0) continue;
      rows.push_back({input.name, input.unit, beside(input.value, input.std), number(input.std),
                      budget.quantities[i].name, number(linear.sensitivity(i, k)), number(linear.contribution(i, k))});
    }
  }
  return core::format_table(rows);
}

std::string results_text(const Budget& budget, const GumResult& linear, const MonteCarloResult& drawn) {
  Rows rows{{"measurand", "unit", "method", "value", "u", "dof", "k", "U", "low", "high"}};
  for (Index i = 0; i < linear.value.size(); ++i) {
    const metrology::BudgetQuantity& quantity = budget.quantities[i];
    rows.push_back({quantity.name, quantity.unit, "GUM", beside(linear.value[i], linear.std[i]), number(linear.std[i]),
                    number(linear.degrees_of_freedom[i]), number(linear.factor[i]), number(linear.expanded[i]),
                    beside(linear.value[i] - linear.expanded[i], linear.std[i]),
                    beside(linear.value[i] + linear.expanded[i], linear.std[i])});
    const double least = least_degrees(budget, linear, i), std = least > 2.0 ? drawn.std[i] : linear.std[i];
    rows.push_back({quantity.name, quantity.unit, "draws", least > 1.0 ? beside(drawn.mean[i], std) : "-",
                    least > 2.0 ? number(std) : "-", "", "", "", beside(drawn.symmetric[i].low, std),
                    beside(drawn.symmetric[i].high, std)});
  }
  return core::format_table(rows);
}

std::string comparison_text(const Budget& budget, const GumResult& linear, const MonteCarloResult& drawn) {
  std::string text;
  const std::vector<Comparison> compared = comparisons(budget, linear, drawn);
  for (Index i = 0; i < linear.value.size(); ++i) {
    const Comparison& at = compared[i];
    text += fmt::format("{}: GUM and Monte Carlo: {}: ends {:.2g} and {:.2g} apart, tolerance {:.2g}{}\n",
                        budget.quantities[i].name, verdict(at), at.low_apart, at.high_apart, at.tolerance,
                        at.enough_draws ? "" : "; the ends need more draws");
  }
  for (Index i = 0; i < linear.value.size(); ++i) {
    const double least = least_degrees(budget, linear, i);
    if (least > 2.0) continue;
    text +=
        fmt::format("{}: an input with {:.3g} degrees of freedom: its t distribution has no {}, the interval counts\n",
                    budget.quantities[i].name, least, least > 1.0 ? "variance" : "mean and no variance");
  }
  if (budget.factor) {
    text += fmt::format("the factor {:.3g} is stated; intervals of the draws have a probability of {:.4g}\n",
                        *budget.factor, budget.probability);
  }
  for (Index i = 0; i < linear.value.size(); ++i) {
    for (Index k = i + 1; k < linear.value.size(); ++k) {
      if (std::abs(linear.correlation(i, k)) < 5e-4) continue;
      text += fmt::format("correlation of {} and {}: {:.3f}, of the draws {:.3f}\n", budget.quantities[i].name,
                          budget.quantities[k].name, linear.correlation(i, k), drawn.correlation(i, k));
    }
  }
  return text;
}

}  // namespace

void measure_uncertainty(const MeasureOptions& options) {
  if (options.file.empty() == options.arcs_deg.empty())
    throw core::UsageError("measure uncertainty takes either BUDGET or --arc");
  if (!options.arcs_deg.empty()) return measure_arcs(options);
  const Budget budget = Budget::load(options.file);
  const GumResult linear = metrology::gum(budget);
  const MonteCarloResult drawn = metrology::monte_carlo(budget);
  json result = json_of(budget, linear, drawn);
  const std::filesystem::path file = options.out / "uncertainty.json";
  core::write_file(file, result.dump(1) + "\n");
  result["file"] = file.string();
  print_summary(options,
                contributions_text(budget, linear) + "\n" + results_text(budget, linear, drawn) + "\n" +
                    comparison_text(budget, linear, drawn) + "all in " + file.string() + "\n",
                result.dump());
}

}  // namespace thermotwin::tools
