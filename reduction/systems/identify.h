// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// A state-space model from the tables of a campaign alone, without an operator of the full model:
//   x' = A x + B u,   y = C x,   u and y as in campaign_tables.h.
// First fixed poles: every input passes first-order lags whose time constants lie evenly in the logarithm
// between the sampling and the length of the loads, and C is the least-squares solution over all loads
// (orthonormal bases of fixed poles; Heuberger, Van den Hof and Wahlberg 2005), with a ridge that a load
// held out of the fit chooses. Then balanced truncation; the order, too, is the one that does best on
// the held-out load. Every lag is stable, and balanced truncation keeps that: no model is unstable,
// whatever the data. What p(t) does (films that speeds change, coolants that stop, moving axes) is in
// the least squares' mean and nowhere else, and nothing is known of an input that no load moved.

#include <Eigen/Core>

#include <string>
#include <vector>

#include "reduction/systems/campaign_tables.h"
#include "reduction/systems/linear_system.h"
#include "solver/campaign/campaign.h"
#include "solver/campaign/load_result.h"

namespace thermotwin::reduction {

struct IdentifyOptions {
  Eigen::Index order = 0;  ///< 0: chosen on the held-out load
  int lags = 6;            ///< time constants of each input
  void validate() const;   ///< @throws InputError
};

/// One load as samples of the system.
struct Samples {
  std::string load;
  Eigen::VectorXd time;             ///< s
  Eigen::MatrixXd inputs, outputs;  ///< (times x inputs): means over the interval before; (times x outputs)
  Eigen::Index poses = 0;           ///< six outputs each, the first ones
  double initial_K = 0;             ///< uniform at the start
};
Samples make_samples(const CampaignInputs& inputs, const CampaignTables& tables, double reference_C);

class Identification {
public:
  /// @param even  inputs that are the machine's own temperature where all is even, see CampaignInputs
  /// @throws InputError: no load, loads that disagree in their outputs, no input that moves
  Identification(const std::vector<Samples>& training, const std::vector<bool>& even, const IdentifyOptions& options);

  /// All lags, inputs in units of their largest value and outputs in um: of order lags x inputs.
  const LinearSystem& lags() const { return lags_; }
  /// The model of an order, of u and y as the tables have them. E is the identity.
  ReducedLinearSystem model(Eigen::Index order) const;
  /// y at the load's times; before time 0 all even inputs stood at initial_K, the others at 0.
  Eigen::MatrixXd predict(const ReducedLinearSystem& model, const Samples& load) const;
  /// The same in what the campaign's errors are measured by.
  solver::LoadResult predicted(const ReducedLinearSystem& model, const Samples& load,
                               const CampaignTables& tables) const;

  Eigen::Index largest_order() const { return usable_; }
  Eigen::Index order() const { return order_; }  ///< chosen, or as asked for
  double ridge() const { return ridge_; }
  /// What was kept out while ridge and order were chosen: a load, or the last quarter of all.
  const std::string& kept_out() const { return kept_out_; }
  /// Order and RMS of the translations' error there, um, of models that did not see it.
  const std::vector<std::pair<Eigen::Index, double>>& order_error_um() const { return order_error_um_; }
  /// Inputs (by place) that no load moved: their effect is unknown.
  const std::vector<Eigen::Index>& never_moved() const { return never_moved_; }
  /// Of these, and of those that leave the range of training by more than a tenth of it, the ones that the load has.
  std::vector<Eigen::Index> beyond(const Samples& load) const;

private:
  struct Fit;
  struct Split;
  /// Of rows, and of loads, s.
  struct Spans {
    double shortest, longest;
  };
  void check(const std::vector<Samples>& training) const;
  Spans find_ranges(const std::vector<Samples>& training);
  void find_active(Eigen::Index inputs);
  void set_constants(int lags, const Spans& spans);
  void set_weights(const Samples& load);
  Split keep_out(const std::vector<Samples>& training) const;
  Eigen::MatrixXd best_ridge(const Fit& part, const std::vector<Eigen::MatrixXd>& states,
                             const std::vector<Eigen::MatrixXd>& weighted, const std::vector<Eigen::Index>& seen);
  void choose_order(Eigen::Index wanted, const std::vector<Samples>& training, const std::vector<Eigen::Index>& seen);
  Eigen::MatrixXd lag_states(const Samples& load) const;
  void balance(const Eigen::MatrixXd& weighted_c);
  double rms_um(const ReducedLinearSystem& model, const std::vector<Samples>& loads,
                const std::vector<Eigen::Index>& from) const;

  std::vector<bool> even_;
  std::vector<Eigen::Index> active_, never_moved_;
  Eigen::VectorXd low_, high_, scale_, weight_, constants_;  ///< weight_: of outputs
  LinearSystem lags_;
  Eigen::MatrixXd left_, right_;  ///< balancing bases, all usable columns
  Eigen::Index usable_ = 0, order_ = 0, poses_ = 0;
  double ridge_ = 0;
  std::string kept_out_;
  std::vector<std::pair<Eigen::Index, double>> order_error_um_;
};

}  // namespace thermotwin::reduction
