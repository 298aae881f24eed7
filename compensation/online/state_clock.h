// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Advances the thermal state in longer steps than the rows. A step from t_n to t_n+1 ends at a row and joins the rows
// in between: the state x_n advances by h = t_n+1 - t_n at p and q of the mean row (ReducedStepper, input_mean.h). h is
// at most step_s; a row that is longer is divided into equal steps. Between steps the state is extrapolated at the rate
// of the last step,
//   x(t) = x_n + a (x_n - x_n-1),   a = (t - t_n) / (t_n - t_n-1).
// The means of p, q, x and K0 + sum p K since the last take_interval() are kept for error_model.h.

#include <Eigen/Core>

#include <optional>

#include "compensation/online/error_model.h"
#include "compensation/online/input_mean.h"
#include "reduction/model/reduced_model.h"
#include "solver/operation/chiller.h"

namespace thermotwin::compensation {

class StateClock {
public:
  /// @param model, operating  must outlive the clock  @param step_s  longest step of the state
  StateClock(const reduction::ReducedModel& model, const solver::OperatingModel& operating, double step_s);

  void set_state(const Eigen::VectorXd& state);
  /// Starts at the first row. @param readings_K  (sensors + observed) for chillers and laws
  void start(double time, const Eigen::VectorXd& row, const Eigen::VectorXd& readings_K);

  /// @return whether the rows so far have to end as a step before a row of this duration
  bool ends_before(double duration) const {
    return inputs_.duration() > 0.0 && inputs_.duration() + duration > step_s_ * (1.0 + 1e-9);
  }
  /// Adds a row that holds until the time.
  void add(const Eigen::VectorXd& row, double time);
  bool full() const { return inputs_.duration() >= step_s_ * (1.0 - 1e-9); }

  /// The rows since the last step as one step: the mean row over a number of equal parts.
  struct Step {
    const Eigen::VectorXd& mean;
    double duration;  ///< s
    int parts;        ///< 0: shorter than 1 us, the state does not advance
    double part_s;    ///< duration of a part
  };
  /// @return valid until the next add()
  Step take_step();
  void advance(const Eigen::VectorXd& mean, const Eigen::VectorXd& readings_K, double duration);
  void end_step() { step_end_ = time_; }

  double time() const { return time_; }          ///< of the last row
  double step_end() const { return step_end_; }  ///< of the last step, or of its last part
  double started_at() const { return started_at_; }
  double last_step() const { return last_step_; }
  /// The factor a of the extrapolation above; it may exceed 1.
  double ahead() const { return last_step_ > 0.0 ? (time_ - step_end_) / last_step_ : 0.0; }
  /// The factor a, limited to 1.
  double share_ahead() const { return last_step_ > 0.0 ? std::min(1.0, (time_ - step_end_) / last_step_) : 0.0; }

  const Eigen::VectorXd& state() const { return state_; }    ///< x_n
  const Eigen::VectorXd& change() const { return change_; }  ///< x_n - x_n-1
  const Eigen::VectorXd& sensors_state() const { return sensors_state_; }
  const Eigen::VectorXd& sensors_change() const { return sensors_change_; }
  const solver::Coefficients& coefficients() const { return coefficients_; }
  /// K0 + sum p K
  Eigen::MatrixXd operator_at(const Eigen::VectorXd& p) const;

  /// s, since the last take_interval()
  double interval_s() const { return interval_.duration; }
  /// @return means, valid until the next call
  const ErrorModel::Interval& take_interval();
  /// An interval without duration, of the model's sizes.
  ErrorModel::Interval no_interval() const;

private:
  void clear_interval();

  const reduction::ReducedModel& model_;
  const solver::OperatingModel& operating_;
  double step_s_;
  reduction::ReducedStepper stepper_;
  InputMean inputs_;
  std::optional<solver::Chiller> chiller_;
  solver::Coefficients coefficients_;
  double time_ = 0, step_end_ = 0, started_at_ = 0, last_step_ = 0;
  Eigen::VectorXd state_, before_, change_, sensors_state_, sensors_change_;
  ErrorModel::Interval interval_, taken_;  ///< sums since the last take_interval(); means that it returned
  Eigen::MatrixXd operator_sum_;
  Eigen::VectorXd first_p_;
  bool p_changed_ = false;
};

}  // namespace thermotwin::compensation
