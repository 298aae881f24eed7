// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/plan/design.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>
#include <utility>

#include "core/statistics.h"
#include "diagnosis/causes/hypothesis.h"

namespace thermotwin::study {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Every combination of the fixed values, the last parameter fastest.
std::vector<VectorXd> combinations(const StudyPlan& plan) {
  const auto count = std::ssize(plan.parameters);
  std::vector<VectorXd> made{VectorXd::Constant(count, std::numeric_limits<double>::quiet_NaN())};
  for (Eigen::Index p = 0; p < count; ++p) {
    const Distribution& distribution = plan.parameters[p].distribution;
    if (distribution.is_drawn()) continue;
    std::vector<VectorXd> longer;
    for (const VectorXd& before : made) {
      for (const double value : distribution.values) {
        longer.push_back(before);
        longer.back()[p] = value;
      }
    }
    made = std::move(longer);
  }
  return made;
}

/// (rows x drawn) values of the design.
MatrixXd draws(const StudyPlan& plan, const std::vector<int>& drawn) {
  const int dimensions = drawn.size();
  const bool pick_freeze = plan.sampling == Sampling::pick_freeze;
  const auto valued = [&](MatrixXd shares) {
    for (Eigen::Index i = 0; i < shares.rows(); ++i) {
      for (int k = 0; k < shares.cols(); ++k) {
        const Distribution& distribution = plan.parameters[drawn[k % dimensions]].distribution;
        shares(i, k) = distribution.at(shares(i, k));
      }
    }
    return shares;
  };
  if (!pick_freeze) return valued(drawn_shares(plan.samples, dimensions, plan.seed, plan.sampling == Sampling::latin));
  const MatrixXd both = valued(drawn_shares(plan.samples, 2 * dimensions, plan.seed, false));
  MatrixXd rows(plan.samples * (dimensions + 2), dimensions);
  for (int s = 0; s < plan.samples; ++s) {
    const auto a = both.row(s).head(dimensions), b = both.row(s).tail(dimensions);
    const int first = s * (dimensions + 2);
    rows.row(first) = a;
    rows.row(first + 1) = b;
    for (int i = 0; i < dimensions; ++i) {
      rows.row(first + 2 + i) = a;
      rows(first + 2 + i, i) = b[i];
    }
  }
  return rows;
}

}  // namespace

std::vector<std::size_t> Design::of_group(std::size_t group) const {
  std::vector<std::size_t> members;
  for (std::size_t v = 0; v < variants.size(); ++v)
    if (variants[v].group == group) members.push_back(v);
  return members;
}

MatrixXd drawn_shares(int samples, int dimensions, std::uint64_t seed, bool latin) {
  std::mt19937_64 engine(seed);
  MatrixXd shares(samples, dimensions);
  std::vector<int> order(samples);
  for (int d = 0; d < dimensions; ++d) {
    std::iota(order.begin(), order.end(), 0);
    if (latin) {
      for (int i = samples - 1; i > 0; --i)
        std::swap(order[i], order[static_cast<int>(core::uniform(engine) * (i + 1))]);
    }
    for (int i = 0; i < samples; ++i) {
      const double inside = std::clamp(core::uniform(engine), 0x1p-53, 1.0 - 0x1p-53);
      shares(i, d) = latin ? (order[i] + inside) / samples : inside;
    }
  }
  return shares;
}

double variant_count(const StudyPlan& plan) {
  double fixed = 1.0;
  int drawn = 0;
  for (const StudyParameter& parameter : plan.parameters) {
    if (parameter.distribution.is_drawn()) {
      ++drawn;
    } else {
      fixed *= 1.0 * std::ssize(parameter.distribution.values);
    }
  }
  const double rows = drawn == 0                               ? 1.0
                      : plan.sampling == Sampling::pick_freeze ? 1.0 * plan.samples * (drawn + 2)
                                                               : 1.0 * plan.samples;
  return rows * fixed * (1.0 * std::ssize(plan.sizes));
}

Design make_design(const StudyPlan& plan) {
  Design design;
  for (std::size_t p = 0; p < plan.parameters.size(); ++p)
    if (plan.parameters[p].distribution.is_drawn()) design.drawn.push_back(p);
  const std::vector<VectorXd> fixed = combinations(plan);
  const bool any_drawn = !design.drawn.empty();
  const MatrixXd values = any_drawn ? draws(plan, design.drawn) : MatrixXd(1, 0);
  design.rows = any_drawn ? values.rows() : std::ssize(fixed);
  for (const std::string& size : plan.sizes) {
    if (!any_drawn) {
      // Fixed values alone: their combinations are the variants of one group.
      design.groups.push_back({size, size, VectorXd::Constant(std::ssize(plan.parameters), NAN)});
      for (const VectorXd& combination : fixed) design.variants.push_back({design.groups.size() - 1, combination});
      continue;
    }
    for (std::size_t c = 0; c < fixed.size(); ++c) {
      design.groups.push_back({fixed.size() > 1 ? fmt::format("{}_{}", size, c + 1) : size, size, fixed[c]});
      for (Eigen::Index i = 0; i < values.rows(); ++i) {
        Variant variant{design.groups.size() - 1, fixed[c]};
        for (std::size_t k = 0; k < design.drawn.size(); ++k) variant.values[design.drawn[k]] = values(i, k);
        design.variants.push_back(std::move(variant));
      }
    }
  }
  return design;
}

mesh::Machine machine_of(const StudyPlan& plan, const VectorXd& values) {
  mesh::Machine machine = plan.machine_case.machine;
  for (std::size_t p = 0; p < plan.parameters.size(); ++p) {
    const diagnosis::Parameter& parameter = plan.parameters[p].parameter;
    const double value = values[p];
    if (value != parameter.nominal) machine = diagnosis::with_parameter(machine, parameter, value);
  }
  return machine;
}

}  // namespace thermotwin::study
