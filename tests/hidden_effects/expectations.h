// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// What a truth is expected to show in a record, linearised and with all nuisances: the Bayes factors by
// which it can be told from no cause and from the best rival. The truth's own column is the secant from
// nominal to its value (a film twice as good does not carry off twice as much), all others are tangents at
// nominal. A missing source is one hypothesis spread over all places and inputs; what lies within 10 cm and
// follows the same input is the truth.

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "diagnosis/causes/parameter.h"
#include "diagnosis/record/diagnose_options.h"
#include "diagnosis/response/problem.h"
#include "diagnosis/response/response.h"
#include "reduction/model/reduced_model.h"
#include "specimen.h"

namespace thermotwin::hidden {

constexpr double same_place_m = 0.1;

/// Of the same cause: kind and where, of a missing source what it follows and its place.
/// Whether the source follows the input, or one that changed as the input did.
bool may_follow(const diagnosis::MissingSource& source, const std::string& input);
bool same_cause(const diagnosis::Parameter& a, const diagnosis::Parameter& b);
/// Distance of two missing sources' centres in the machine at rest, m.
double distance(const diagnosis::Parameter& a, const diagnosis::Parameter& b);
/// The truth as the reduced model can have it: a missing source on the nearest patch of its body.
diagnosis::Parameter on_model(const diagnosis::Parameter& truth, const reduction::ReducedModel& model);

struct Factors {
  double against_none = 0, against_rival = 0;  ///< expected 2 ln of the Bayes factors
  std::string rival;
};

/// A record as the diagnosis sees it.
class Seen {
public:
  /// The model must outlive it. @param inputs  that a missing source may follow
  Seen(const reduction::ReducedModel& model, const compensation::Measurement& measurement,
       const std::vector<Followable>& inputs, const diagnosis::DiagnoseOptions& how = {});
  Factors factors(const Truth& truth) const;
  /// The same of one of two causes where the other is there too, and known to be: against the other alone, and against
  /// the other with the best rival. Zero where one of them is a missing source.
  Factors factors_beside(const Truth& truth, const Truth& other) const;
  const diagnosis::Problem& problem() const { return problem_; }
  const diagnosis::Response& response() const { return *response_; }

private:
  /// What a truth changes per unit, from nominal to its value, white.
  Eigen::VectorXd secant(const Truth& truth) const;
  /// What nuisances take of a white signal: inner products are less by those of it.
  Eigen::VectorXd taken(const Eigen::VectorXd& white) const;
  /// Log evidence of heat on patches (rows) with every input (columns) for a white signal.
  Eigen::MatrixXd of_spots(const Eigen::VectorXd& white) const;

  /// From a patch's middle to a missing source, m.
  double apart(Eigen::Index patch, const Truth& truth) const;
  /// Log evidence of heat at a missing source's place (all patches within same_place_m, else the nearest) with its own
  /// input.
  double at_its_place(const Truth& truth, const Eigen::VectorXd& white) const;

  const reduction::ReducedModel& model_;
  std::vector<Followable> inputs_;
  Eigen::MatrixXd series_;  ///< (steps x inputs) of their largest value
  std::unique_ptr<diagnosis::Observations> observations_;
  std::unique_ptr<diagnosis::Response> response_;
  diagnosis::Problem problem_;
  std::unique_ptr<diagnosis::Whitener> whitener_;
  Eigen::MatrixXd columns_, nuisances_;  ///< white; the second in units of their priors
  std::vector<Eigen::Index> patches_;    ///< of the model, those that are looked at
  Eigen::MatrixXd spots_, spots_taken_;  ///< white; what nuisances take of them
  Eigen::LLT<Eigen::MatrixXd> taken_;
};

/// What a clean machine of the type shows, for choosing what can be seen.
class Expectations {
public:
  /// Both must outlive it.
  Expectations(const Specimen& specimen, const reduction::ReducedModel& model,
               const diagnosis::DiagnoseOptions& how = {})
      : specimen_(specimen),
        model_(model),
        how_(how) {}
  Factors of(const Truth& truth, const std::string& load);
  const reduction::ReducedModel& model() const { return model_; }

private:
  const Specimen& specimen_;
  const reduction::ReducedModel& model_;
  diagnosis::DiagnoseOptions how_;
  std::map<std::string, std::unique_ptr<Seen>> seen_;
};

}  // namespace thermotwin::hidden
