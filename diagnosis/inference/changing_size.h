// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The power of a source or the conductance of a joint that changes in the course of a record. Two forms compete with
// the causes that are constant:
// - a step at an unknown time (re-lubrication, preload that is lost), a cause of the kinds source_step, contact_step,
// - a size of its own in each of some intervals (friction that jumps, lubricant that thins), which no value of
//   machine.toml describes: other_law.
// Both are linear in the responses to a step at each of some times.

#include <Eigen/Core>

#include <vector>

#include "diagnosis/causes/parameter.h"
#include "diagnosis/inference/model_search.h"
#include "diagnosis/response/problem.h"
#include "diagnosis/response/response.h"

namespace thermotwin::diagnosis {

struct ChangingSizes {
  struct Step {
    Parameter parameter;
    Eigen::VectorXd column, freedom;  ///< (observations) per unit of the factor; the same for one deviation of its time
    double log_evidence = 0;          ///< against none, on the linear form
    double over_constant = 0;         ///< less that of a constant change at its place
  };
  std::vector<Step> steps;        ///< most evidence first
  std::vector<ChangingLaw> laws;  ///< without probability
};

/// @param found  what a search without them found: only its leading sources and joints are tried
ChangingSizes find_changing_sizes(const Problem& problem, const Response& response, const mesh::Machine& machine,
                                  const SearchResult& found);

/// Adds the steps that may compete with what was found to the parameters and columns of a problem.
/// @return whether there is one
bool add_steps(Problem& problem, const std::vector<ChangingSizes::Step>& steps, const SearchResult& found);

/// Without the laws that are not much better than a constant change or a step at the same place: a size of its own in
/// each of many intervals also takes what the form of any cause is off by.
std::vector<ChangingLaw> clear_laws(const Problem& problem, const SearchResult& found, std::vector<ChangingLaw> laws);

}  // namespace thermotwin::diagnosis
