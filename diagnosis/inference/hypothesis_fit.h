// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// One hypothesis, a set of causes with their sizes, against the fitted part of a measurement: fitted by
// Gauss-Newton about its own estimate, with the freedom that real causes have, and the linear form there.

#include <Eigen/Core>

#include <vector>

#include "diagnosis/causes/parameter.h"
#include "diagnosis/inference/unknown_cause.h"
#include "diagnosis/response/problem.h"

namespace thermotwin::diagnosis {

struct Hypothesis {
  std::vector<int> members;                ///< indices of parameters; empty: no cause
  double log_prior = 0, log_evidence = 0;  ///< evidence against no cause, times evidence_share
  double probability = 0;
  Eigen::VectorXd value, std;  ///< (members) estimates
  bool refined = false;
  double chi_square = 0;        ///< of the fitted part, if refined
  Eigen::VectorXd predicted;    ///< (observations) at the estimate, all else at nominal on the linear form, if refined
  Eigen::MatrixXd sensitivity;  ///< (observations x members) there
  Eigen::MatrixXd
      spread;  ///< (observations x members) there, see Response::Linear; of a lag what a delay in its stead does
};

/// The fitted part, or all of the record, decorrelated, about the nominal machine.
struct White {
  bool whole;
  Whitener whitener;
  Eigen::MatrixXd columns;   ///< (rows x columns of the problem)
  Eigen::VectorXd residual;  ///< (rows)

  explicit White(const Problem& problem, bool whole_record = false);
  Eigen::MatrixXd of(const Problem& problem, const Eigen::MatrixXd& stacked) const {
    return whitener.whiten(whole ? problem.decorrelated(stacked) : problem.fitted(stacked));
  }
};

/// What the fitted part is linear in about an estimate, white: as if all parameters were nominal and only the
/// members' columns and the residual knew of it. Columns of the members' freedom follow those of the problem.
struct LinearForm {
  Eigen::MatrixXd columns;
  Eigen::VectorXd residual, prior_std;  ///< priors as nominal, the members' too
  std::vector<int> members;
  Eigen::VectorXd value;  ///< (members)
  Eigen::VectorXd shift;  ///< (observations) added to measured less predicted there: what columns account for
};
LinearForm nominal_form(const Problem& problem, const White& white);
/// @param h  refined
LinearForm form_about(const Problem& problem, const White& white, const Hypothesis& h);
/// The same with all other parameters linearised there too, one more run of the model: a sensor that has come loose
/// shows nothing until something warms its place.
LinearForm form_beside(const Problem& problem, const Response& response, const mesh::Machine& machine,
                       const White& white, const Hypothesis& h);

/// What bounds do to the evidence of a Gaussian: ln of the mass that the posterior has within them over that of
/// the prior. A time constant or a power that would have to be negative explains nothing.
double log_within_bounds(const Parameter& parameter, double value, double std);

/// Gauss-Newton about the hypothesis' own estimate, at most `iterations` times (thrice as often where readings are
/// concerned: clocks and time constants are far from linear); its evidence by Laplace at the end.
/// @param log_nominal  evidence of no cause   @param evidence_share  of SearchOptions
void refine(Hypothesis& h, const Problem& problem, const Response& response, const mesh::Machine& machine,
            const White& white, double log_nominal, int iterations, double evidence_share);

/// Linearises at the hypothesis' own estimate: its prediction, sensitivity and spread.
void linearise(Hypothesis& h, const Problem& problem, const Response& response, const mesh::Machine& machine);

/// What a hypothesis asks for beyond itself where it has to describe all of the record.
struct Strain {
  /// Of a mean of the held-out part as foretold, all else as the fitted part leaves it, uncertain as it then is: about
  /// 1 where the hypothesis is right, less where errors are smaller than allowed for.
  double heldout_chi_square = 0;
  double heldout_misfit = 0;  ///< by how many nats these means are further off than expected
  double freedom =
      0;  ///< most of what its own size wanders, its heat spreads or its lag delays, expected standard deviations
  double other = 0;  ///< most that another parameter is off, stated standard deviations
  int which = -1;    ///< that parameter
};
/// @param h  linearised at its estimate
Strain strain_of(const Problem& problem, const Hypothesis& h);

/// Log evidence, with the whitening's determinant, of a refined hypothesis beside something unknown, which wanders by a
/// share of what was seen without it; the channel is that where one alone is off.
UnknownEvidence evidence_beside_unknown(const Problem& problem, const Hypothesis& h);

/// Whitened residual of the fitted part under a hypothesis, nuisances at their posterior mean.
Eigen::VectorXd white_residual(const Problem& problem, const Hypothesis& hypothesis);

}  // namespace thermotwin::diagnosis
